// import: backend/gpu/buffers, slice
// Entry point: samples of every pixel of a slice.

// Eight consecutive lanes, which software adapters run together, are a tile of 4x2 pixels and not a row: their rays diverge
// later. Thirty-two lanes are 8x4 pixels either way.
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
    let pixel = y * frame.width + x;
    film[pixel] = add_samples(film[pixel], x, y);
}
