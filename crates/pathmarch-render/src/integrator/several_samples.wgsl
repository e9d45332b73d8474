// import: backend/gpu/film, integrator/camera, integrator/path, loop_check, sampler
// Several samples of a pixel, each with a camera ray of its own, one after the other. Software adapters read and write the film
// once for all of them, and their lanes do not wait for the longest path of a sample.

/// Path of a sample of a pixel, at the camera.
fn path_of_sample(x: u32, y: u32, sample: u32) -> Path {
    let sampler = pixel_sampler(x, y, sample, frame.seed);
    return path_from(camera_ray(x, y, sampler), sampler);
}

/// Adds the film values of the slice's samples of a pixel to those before, one after the other.
fn add_samples(before: vec4f, x: u32, y: u32) -> vec4f {
    var sum = before;
    var sample = slice.sample;
    let end = slice.sample + slice.samples;
    var path = path_of_sample(x, y, sample);
    loop {
        let goes_on = path_intersect(&path) && path_scatter(&path);
        if !goes_on {
            sum += kept(film_value(path.radiance));
            sample++;
        }
        if sample >= end {
            break;
        }
        // A loop, as software adapters skip nothing else where no lane needs it.
        loop {
            if goes_on {
                break;
            }
            path = path_of_sample(x, y, sample);
            break;
        }
    }
    return checked(sum);
}
