// import: backend/gpu/buffers, backend/gpu/lanes, integrator/path_reuse
// Entry point: samples of every pixel of a slice, of which those of a tile of 8x8 pixels, a workgroup, share light.

@compute @workgroup_size(8, 8)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let id = 8u * group.xy + place_of_lane(lane);
    load_frame();
    let x = slice.first_column + id.x;
    let y = slice.first_row + id.y;
    let is_inside = x < frame.width && id.y < slice.rows;
    let pixel = select(0u, y * frame.width + x, is_inside);
    let sum = add_shared_samples(film_sum(pixel), x, y, is_inside);
    if is_inside {
        store_film(pixel, sum);
    }
}
