//! Shading: surface interactions of hits, and their textures.

pub(crate) mod surface_interaction;
pub(crate) mod textured_point;
