// One sample of every pixel of a band of rows. What a sample is depends on the mode: gpu/kernel.rs names its function in
// place of the path's.

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
    let random = random_new(x, y, slice.sample, frame.seed);
    let radiance = radiance_along(camera_ray(x, y, random), random);
    let pixel = y * frame.width + x;
    // Comparisons with what is not a number are false, so this also catches NaN.
    if all(radiance >= vec3f(0.0)) && all(radiance < vec3f(1e30)) {
        film[pixel] += vec4f(radiance, 0.0);
    } else {
        film[pixel].w += 1.0;
    }
}
