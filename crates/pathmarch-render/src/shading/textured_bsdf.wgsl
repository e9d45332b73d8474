// Textures of BSDF parameters. Twin of `TexturedPoint::parameters`.

/// Parameters at the interaction that was evaluated last.
var<private> textured_parameters: array<vec4f, 8>;

/// Parameters 4k to 4k + 3 of a BSDF, at the interaction that was evaluated last.
fn packed(m: u32, k: u32) -> vec4f {
    return textured_parameters[k];
}

/// Starts the evaluation of the textures of material `m`.
fn begin_textures(m: u32) {
    textured_parameters = material_at(m).parameters;
}

/// Applies a layer with this colour and value of its texture.
fn apply_layer(layer: u32, texel: vec4f) {
    let first_or_count = scene_word(layer + LAYER_PLACE);
    if scene_word(layer + LAYER_KIND) != PACKED_LAYER {
        let vector = first_or_count / 4u;
        let colour = layer_colour(layer, texel, textured_parameters[vector].xyz);
        textured_parameters[vector] = vec4f(colour, textured_parameters[vector].w);
        return;
    }
    let position = texel.w * f32(KNOTS - 1u);
    let first = min(u32(position), KNOTS - 2u);
    let weight = position - f32(first);
    // In a layer of this kind, LAYER_PLACE is the number of parameters.
    let knots = layer + LAYER_CONTENTS + first_or_count;
    for (var k = 0u; k < first_or_count; k++) {
        let parameter = scene_word(layer + LAYER_CONTENTS + k);
        let a = texture_number(knots + first_or_count * first + k);
        let b = texture_number(knots + first_or_count * (first + 1u) + k);
        textured_parameters[parameter / 4u][parameter % 4u] = a + (b - a) * weight;
    }
}

/// Colour of clear glass that a shadow ray passes through. Leaves the parameters of the last interaction unchanged.
fn glass_colour(m: u32, interaction: SurfaceInteraction, path_length: f32) -> vec3f {
    let saved_parameters = textured_parameters;
    let saved_gradient = bump_gradient;
    let saved_map_normal = map_normal;
    let saved_map_tangent = map_tangent;
    evaluate_textures(m, interaction, path_length);
    let colour = textured_parameters[0].xyz;
    textured_parameters = saved_parameters;
    bump_gradient = saved_gradient;
    map_normal = saved_map_normal;
    map_tangent = saved_map_tangent;
    return colour;
}
