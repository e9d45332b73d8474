// import: reconstruct/direct
// All light but that of facets and media, as the spatial filter sees it. Twin of the base in spatial.rs.

/// True if a pixel has such light.
fn is_in_layer(guide: Guide) -> bool {
    return true;
}

/// True if that is light of media.
fn is_of_medium(guide: Guide) -> bool {
    return false;
}

/// Weight of two pixels that share the light of a medium.
fn shared_medium(pixels: vec2u) -> f32 {
    return 0.0;
}

/// Weight of two pixels as parts of one reflection.
fn shared_reflection(a: Guide, b: Guide, pixels: vec2u, apart: vec3f, side: f32) -> f32 {
    return 1.0;
}

/// Mean square of the luminance of its samples, whose mean is this.
fn mean_square(guide: Guide, mean: f32) -> f32 {
    return direct_square(guide, mean);
}
