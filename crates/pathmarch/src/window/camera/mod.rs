//! The camera of the window: navigation, and projection of points of the world.

pub(crate) mod navigation;
pub(crate) mod projection;
