//! Edits of a document, each a series of patches of its text.

pub(super) mod additions;
pub(super) mod camera;
pub(super) mod combine;
pub(super) mod keyframes;
pub(super) mod kinds;
mod naming;
pub(super) mod outline_points;
pub(super) mod presets;
pub(super) mod ramp;
pub(super) mod structure;
pub(super) mod transaction;
pub(super) mod write;
