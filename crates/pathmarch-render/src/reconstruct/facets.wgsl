// import: reconstruct/pass
// Light of facets, as the spatial filter sees it. Twin of `Layer::Facets` in spatial.rs.

/// True if a pixel has such light.
fn is_in_layer(guide: Guide) -> bool {
    return guide.alpha > 0.0;
}

/// Weight of two pixels as parts of one reflection. `side` is that of the larger pixel.
fn shared_reflection(a: u32, b: u32, apart: vec3f, side: f32) -> f32 {
    let reach = min(images[a].y, images[b].y) + side;
    return max(1.0 - dot(apart, apart) / (reach * reach), 0.0);
}
