// Textures of preview materials. Twin of `TexturedPoint::preview`.

/// Changes of the preview material at the interaction that was evaluated last.
var<private> preview_changes: array<f32, PREVIEW_PARAMETERS>;

/// Colour of the first parameter so far; w is 0 without a texture of it.
var<private> first_colour: vec4f;

/// Starts the evaluation of the textures of material `m`.
fn begin_textures(m: u32) {
    first_colour = vec4f(0.0);
    preview_changes = array<f32, PREVIEW_PARAMETERS>();
}

/// Applies a layer with this colour and value of its texture.
fn apply_layer(layer: u32, texel: vec4f) {
    let previews = scene_word(layer + LAYER_PREVIEWS);
    if scene_word(layer + LAYER_KIND) != PACKED_LAYER {
        let is_first = scene_word(layer + LAYER_PLACE) == 0u;
        let below = select(texture_vector(previews), first_colour.xyz, is_first && first_colour.w > 0.0);
        let colour = layer_colour(layer, texel, below);
        let change = colour - below;
        if is_first {
            first_colour = vec4f(colour, 1.0);
        }
        for (var k = 0u; k < PREVIEW_PARAMETERS; k++) {
            preview_changes[k] += texture_number(previews + 3u + k) * change[select((max(k, 4u) - 4u) % 3u, k, k < 3u)];
        }
        return;
    }
    let position = texel.w * f32(KNOTS - 1u);
    let first = min(u32(position), KNOTS - 2u);
    for (var k = 0u; k < PREVIEW_PARAMETERS; k++) {
        let a = texture_number(previews + PREVIEW_PARAMETERS * first + k);
        let b = texture_number(previews + PREVIEW_PARAMETERS * (first + 1u) + k);
        preview_changes[k] += a + (b - a) * (position - f32(first));
    }
}

/// Applies textures to a preview material.
fn textured_preview(material: PreviewMaterial) -> PreviewMaterial {
    let c = preview_changes;
    return PreviewMaterial(
        material.diffuse + vec3f(c[0], c[1], c[2]),
        material.roughness + c[3],
        material.f0 + vec3f(c[4], c[5], c[6]),
        material.f90 + vec3f(c[7], c[8], c[9]),
        material.transmitted + vec3f(c[10], c[11], c[12]),
        material.ior + c[13],
    );
}
