// import: backend/gpu/buffers, backend/gpu/lanes, slice
// Entry point: samples of every pixel of a slice.

@compute @workgroup_size(8, 8)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let id = 8u * group.xy + place_of_lane(lane);
    load_frame();
    let x = slice.first_column + id.x;
    if x >= frame.width || id.y >= slice.rows {
        return;
    }
    let y = slice.first_row + id.y;
    let pixel = y * frame.width + x;
    store_film(pixel, add_samples(film_sum(pixel), x, y));
}
