//! What a hit is to the integrators: position, normal and side of the surface, and its textures.

pub(crate) mod surface_interaction;
pub(crate) mod textured_point;
