//! The tree of a document: paths, outline, lookups in nodes.

pub(super) mod nodes;
pub(super) mod outline;
pub(super) mod path;
