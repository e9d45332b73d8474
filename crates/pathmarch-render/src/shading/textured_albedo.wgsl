// Textures of the albedo that views show. Twin of `TexturedPoint::colour`.

/// Albedo of the surface that was evaluated last; w is 0 where it is not textured.
var<private> textured_albedo: vec4f;

fn begin_textures(m: u32) {
    textured_albedo = vec4f(0.0);
}

fn apply_layer(layer: u32, shown: vec4f) {
    if scene_data[layer + LAYER_KIND] != PACKED_LAYER && scene_data[layer + LAYER_PLACE] == 0u {
        textured_albedo = vec4f(layer_colour(layer, shown), 1.0);
    }
}
