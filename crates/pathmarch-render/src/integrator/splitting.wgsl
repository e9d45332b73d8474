// import: backend/gpu/film, integrator/path, loop_check
// Samples of a pixel that share a camera ray. Twin of splitting.rs, which explains them.

/// Index of the camera ray that a sample belongs to.
fn ray_of(sample: u32) -> u32 {
    let own = min(sample, OWN_RAYS);
    return own + (sample - own) / SPLITTING;
}

/// Value of the slice's samples of a pixel, as the film adds them.
fn slice_value(x: u32, y: u32) -> vec4f {
    let sampler = pixel_sampler(x, y, ray_of(slice.sample), frame.seed);
    var first = path_from(camera_ray(x, y, sampler), sampler);
    if !path_arrive(&first) {
        return checked(kept(film_value(first.radiance)) * f32(slice.samples));
    }
    var sum = vec4f(0.0);
    var taken = 0u;
    var path = first;
    path.sampler.sample = slice.sample;
    // A lane whose path has ended takes its next one, so that lanes do not wait for each other.
    loop {
        if !path_scatter(&path) || !path_arrive(&path) {
            sum += kept(film_value(path.radiance));
            taken++;
            if taken >= slice.samples {
                break;
            }
            path = first;
            path.sampler.sample = slice.sample + taken;
        }
    }
    return checked(sum);
}
