// What varies of the numbers of a quick picture. Twin of `Painted::look` in paint.rs.

/// By how much they differ from the material's, at the surface that was met last.
var<private> look_changes: array<f32, 14>;

fn start_paint(m: u32) {
    look_changes = array<f32, 14>();
}

fn apply_layer(layer: u32, shown: vec4f) {
    let looks = tables[layer + 3u];
    if tables[layer + 1u] != PACKED_LAYER {
        let change = layer_colour(layer, shown) - texture_vector(looks);
        for (var k = 0u; k < LOOK_SIZE; k++) {
            look_changes[k] += texture_number(looks + 3u + k) * change[select((max(k, 4u) - 4u) % 3u, k, k < 3u)];
        }
        return;
    }
    let at = shown.w * f32(KNOTS - 1u);
    let first = min(u32(at), KNOTS - 2u);
    for (var k = 0u; k < LOOK_SIZE; k++) {
        let a = texture_number(looks + LOOK_SIZE * first + k);
        let b = texture_number(looks + LOOK_SIZE * (first + 1u) + k);
        look_changes[k] += a + (b - a) * (at - f32(first));
    }
}

fn changed_look(look: Look) -> Look {
    let c = look_changes;
    return Look(
        look.diffuse + vec3f(c[0], c[1], c[2]),
        look.roughness + c[3],
        look.straight + vec3f(c[4], c[5], c[6]),
        look.grazing + vec3f(c[7], c[8], c[9]),
        look.transmitted + vec3f(c[10], c[11], c[12]),
        look.ior + c[13],
    );
}
