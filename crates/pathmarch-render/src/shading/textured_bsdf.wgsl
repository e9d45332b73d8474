// Textures of the parameters that BSDFs read. Twin of `TexturedPoint::numbers`.

/// Parameters of the surface that was evaluated last.
var<private> textured_parameters: array<vec4f, 8>;

/// Four parameters of a material's BSDF, at the surface that was evaluated last.
fn packed(m: u32, k: u32) -> vec4f {
    return textured_parameters[k];
}

fn begin_textures(m: u32) {
    textured_parameters = materials[m].parameters;
}

fn apply_layer(layer: u32, shown: vec4f) {
    let place = scene_data[layer + LAYER_PLACE];
    if scene_data[layer + LAYER_KIND] != PACKED_LAYER {
        let colour = layer_colour(layer, shown);
        let vector = place / 4u;
        textured_parameters[vector] = vec4f(colour, textured_parameters[vector].w);
        return;
    }
    let at = shown.w * f32(KNOTS - 1u);
    let first = min(u32(at), KNOTS - 2u);
    let part = at - f32(first);
    // In layers of this kind the place is the number of places.
    let knots = layer + LAYER_CONTENTS + place;
    for (var k = 0u; k < place; k++) {
        let target_ = scene_data[layer + LAYER_CONTENTS + k];
        let a = texture_number(knots + place * first + k);
        let b = texture_number(knots + place * (first + 1u) + k);
        textured_parameters[target_ / 4u][target_ % 4u] = a + (b - a) * part;
    }
}

/// Colour of clear glass that a shadow ray passes. The surface that was evaluated last stays as it is.
fn glass_colour(m: u32, leaf: u32, p: vec3f, outward: vec3f, path_length: f32) -> vec3f {
    let kept = textured_parameters;
    let kept_gradient = bump_gradient;
    evaluate_textures(m, leaf, p, outward, path_length);
    let colour = textured_parameters[0].xyz;
    textured_parameters = kept;
    bump_gradient = kept_gradient;
    return colour;
}
