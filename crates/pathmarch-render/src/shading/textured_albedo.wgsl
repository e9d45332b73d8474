// Textures of the albedo, for views. Twin of `TexturedPoint::colour`.

/// Albedo of the interaction that was evaluated last; w is 0 without a texture.
var<private> textured_albedo: vec4f;

/// Starts the evaluation of the textures of material `m`.
fn begin_textures(m: u32) {
    textured_albedo = vec4f(0.0);
}

/// Applies a layer with this colour and value of its texture.
fn apply_layer(layer: u32, texel: vec4f) {
    if scene_word(layer + LAYER_KIND) != PACKED_LAYER && scene_word(layer + LAYER_PLACE) == 0u {
        let base = texture_vector(scene_word(layer + LAYER_PREVIEWS));
        let below = select(base, textured_albedo.xyz, textured_albedo.w > 0.0);
        textured_albedo = vec4f(layer_colour(layer, texel, below), 1.0);
    }
}
