// import: backend/gpu/buffers, backend/gpu/film, backend/gpu/lanes, film_value, integrator/camera, integrator/path, sampler
// Entry point: samples of every pixel of a slice. A lane takes those of several pixels, one after the other, so that it does not
// wait for the longest path of its neighbours, and the film is read and written once for all samples of a pixel.

/// Path of a sample of a pixel, at the camera.
fn path_of_sample(x: u32, y: u32, sample: u32) -> Path {
    let sampler = pixel_sampler(x, y, sample, frame.seed);
    return path_from(camera_ray(x, y, sampler), sampler);
}

@compute @workgroup_size(8, 8)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let id = 8u * vec2u(PIXELS_PER_LANE, 1u) * group.xy + place_of_lane(lane);
    load_frame();
    let x = slice.first_column + id.x;
    let y = slice.first_row + id.y;
    let end_column = min(slice.first_column + slice.columns, frame.width);
    if x >= end_column || id.y >= slice.rows {
        return;
    }
    let first = y * frame.width + x;
    let pixels = min((end_column - x + 7u) / 8u, PIXELS_PER_LANE);
    let end = slice.sample + slice.samples;
    var sums: array<vec4f, PIXELS_PER_LANE>;
    for (var k = 0u; k < PIXELS_PER_LANE; k++) {
        sums[k] = film_sum(first + 8u * min(k, pixels - 1u));
    }
    var pixel = 0u;
    var sample = slice.sample;
    var path = path_of_sample(x, y, sample);
    loop {
        let goes_on = path_intersect(&path) && path_scatter(&path);
        // A loop, as software adapters skip nothing else where no lane needs it.
        loop {
            if goes_on {
                break;
            }
            let value = kept(film_value(path.radiance));
            for (var k = 0u; k < PIXELS_PER_LANE; k++) {
                sums[k] += select(vec4f(0.0), value, k == pixel);
            }
            sample++;
            if sample == end {
                sample = slice.sample;
                pixel++;
            }
            path = path_of_sample(x + 8u * pixel, y, sample);
            break;
        }
        if pixel >= pixels {
            break;
        }
    }
    for (var k = 0u; k < PIXELS_PER_LANE; k++) {
        if k < pixels {
            store_film(first + 8u * k, sums[k]);
        }
    }
}
