//! Checks of a scene that has been read: limits of 32-bit numbers, and warnings.

pub(crate) mod extent;
mod media;
pub(crate) mod warnings;
