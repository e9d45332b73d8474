//! The text of a document: patches, layout of lines, literals.

pub(super) mod layout;
pub(super) mod literals;
pub(super) mod patch;
