// import: reconstruct/pass
// Light of facets and media, as the spatial filter sees it. Twin of `Reaches` in spatial.rs.

/// True if a pixel has such light.
fn is_in_layer(guide: Guide) -> bool {
    return guide.alpha > 0.0;
}

/// True if that is light of media.
fn is_of_medium(guide: Guide) -> bool {
    return has_medium(guide);
}

/// Weight of two pixels with these indices that share the light of a medium.
fn shared_medium(pixels: vec2u) -> f32 {
    return max(1.0 - abs(images[pixels.x].y - images[pixels.y].y) / MEDIUM_REACH, 0.0);
}

/// Weight of two pixels with these indices as parts of one reflection. `side` is that of the larger pixel.
fn shared_reflection(a: Guide, b: Guide, pixels: vec2u, apart: vec3f, side: f32) -> f32 {
    let reach = min(images[pixels.x].y, images[pixels.y].y) + side;
    let turned = a.normal - b.normal;
    let turn_reach = TURN_REACH * min(a.alpha, b.alpha);
    return max(1.0 - dot(apart, apart) / (reach * reach) - dot(turned, turned) / (turn_reach * turn_reach), 0.0);
}

/// Mean square of the luminance of its samples, whose mean is this.
fn mean_square(guide: Guide, mean: f32) -> f32 {
    return guide.reflected_square;
}
