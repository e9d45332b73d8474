// import: backend/gpu/film, integrator/camera_ray_index, integrator/path, loop_check
// Samples of a pixel that share a camera ray. Twin of splitting.rs, which explains them.

/// Adds the film values of the slice's samples of a pixel to those before, one after the other.
fn add_samples(before: vec4f, x: u32, y: u32) -> vec4f {
    let sampler = pixel_sampler(x, y, camera_ray_index(slice.sample), frame.seed);
    var first_path = path_from(camera_ray(x, y, sampler), sampler);
    if !path_intersect(&first_path) {
        let value = kept(film_value(first_path.radiance));
        var sum = before;
        for (var k = 0u; k < slice.samples; k++) {
            sum += value;
        }
        return checked(sum);
    }
    var sum = before;
    var samples_done = 0u;
    var path = first_path;
    path.sampler.sample = slice.sample;
    // A lane whose path has ended takes the next path of its pixel, so that lanes do not wait for each other.
    loop {
        if !path_scatter(&path) || !path_intersect(&path) {
            sum += kept(film_value(path.radiance));
            samples_done++;
            if samples_done >= slice.samples {
                break;
            }
            path = first_path;
            path.sampler.sample = slice.sample + samples_done;
        }
    }
    return checked(sum);
}
