// What varies of the numbers that scattering functions read. Twin of `Painted::numbers` in paint.rs.

/// Those of the surface that was met last.
var<private> own: array<vec4f, 8>;

fn packed(m: u32, k: u32) -> vec4f {
    return own[k];
}

fn start_paint(m: u32) {
    own = materials[m].numbers;
}

fn apply_layer(layer: u32, shown: vec4f) {
    let form = tables[layer + 1u];
    let place = tables[layer + 2u];
    if form != PACKED_LAYER {
        let colour = layer_colour(layer, shown);
        let vector = place / 4u;
        own[vector] = vec4f(colour, own[vector].w);
        return;
    }
    let at = shown.w * f32(KNOTS - 1u);
    let first = min(u32(at), KNOTS - 2u);
    let part = at - f32(first);
    // As many numbers as places.
    let knots = layer + 4u + place;
    for (var k = 0u; k < place; k++) {
        let target_ = tables[layer + 4u + k];
        let a = texture_number(knots + place * first + k);
        let b = texture_number(knots + place * (first + 1u) + k);
        own[target_ / 4u][target_ % 4u] = a + (b - a) * part;
    }
}
