//! The meaning of nodes: one file for each kind of node, and what they share.
//!
//! Every function reports the mistakes that it finds and returns as much as it could read, so that one mistake hides no
//! other.

pub(crate) mod arguments;
pub(crate) mod camera;
pub(crate) mod colours;
pub(crate) mod context;
pub(crate) mod custom_sdf;
mod decals;
pub(crate) mod declarations;
pub(crate) mod fog;
pub(crate) mod include;
pub(crate) mod lights;
pub(crate) mod materials;
mod numbers;
pub(crate) mod objects;
mod outlines;
pub(crate) mod parameters;
pub(crate) mod params;
mod placement;
pub(crate) mod render;
mod settings;
pub(crate) mod sky;
pub(crate) mod textures;
pub(crate) mod unexpected;
pub(crate) mod unit;
pub(crate) mod version;
