// Directional albedo of GGX surfaces. Twin of albedo.rs, which explains it.

/// The albedo split of a GGX surface, from its table.
fn ggx_split(cosine: f32, roughness: f32) -> vec2f {
    let x = sqrt(clamp(cosine, 0.0, 1.0)) * f32(GGX_COSINES - 1u);
    let y = clamp(roughness, 0.0, 1.0) * f32(GGX_ROUGHNESSES - 1u);
    let column = min(u32(x), GGX_COSINES - 2u);
    let row = min(u32(y), GGX_ROUGHNESSES - 2u);
    let s = x - f32(column);
    let t = y - f32(row);
    let low = mix(ggx_entry(row, column), ggx_entry(row, column + 1u), s);
    let high = mix(ggx_entry(row + 1u, column), ggx_entry(row + 1u, column + 1u), s);
    return mix(low, high, t);
}

fn ggx_entry(row: u32, column: u32) -> vec2f {
    let place = GGX_DATA + 2u * (row * GGX_COSINES + column);
    return vec2f(bitcast<f32>(scene_word(place)), bitcast<f32>(scene_word(place + 1u)));
}
