// import: backend/gpu/film, estimator, guides, integrator/camera, loop_check, sampler
// One sample of a pixel.

/// Adds the slice's sample of a pixel to those before.
fn add_samples(before: vec4f, x: u32, y: u32) -> vec4f {
    let sampler = pixel_sampler(x, y, slice.sample, frame.seed);
    let value = kept(estimate(camera_ray(x, y, sampler), sampler));
    store_guide(y * frame.width + x, value.xyz);
    return before + checked(value);
}
