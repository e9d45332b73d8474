// Some samples of every pixel of a band of rows.

// Eight lanes that run together, as in software, are a tile of 4x2 pixels and not a row: their rays part later. Thirty-two are
// 8x4 either way.
@compute @workgroup_size(8, 8)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let within = vec2u((lane & 3u) | ((lane >> 1u) & 4u), ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u));
    let id = 8u * group.xy + within;
    load_frame();
    let x = slice.first_column + id.x;
    if x >= frame.width || id.y >= slice.rows {
        return;
    }
    let y = slice.first_row + id.y;
    film[y * frame.width + x] += samples_of(x, y);
}

/// A sample as the film counts it: what is not finite is left out, and the fourth number says so.
fn kept(radiance: vec3f) -> vec4f {
    // Comparisons with what is not a number are false, so this also catches NaN.
    if all(radiance >= vec3f(0.0)) && all(radiance < vec3f(1e30)) {
        return vec4f(radiance, 0.0);
    }
    return vec4f(0.0, 0.0, 0.0, 1.0);
}
