//! Camera of the viewport: navigation and projection.

pub(crate) mod navigation;
pub(crate) mod projection;
