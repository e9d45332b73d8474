// import: reconstruct/pass
// All light but that of facets, as the spatial filter sees it. Twin of the base in spatial.rs.

/// True if a pixel has such light.
fn is_in_layer(guide: Guide) -> bool {
    return true;
}

/// Weight of two pixels as parts of one reflection.
fn shared_reflection(a: Guide, b: Guide, pixels: vec2u, apart: vec3f, side: f32) -> f32 {
    return 1.0;
}
