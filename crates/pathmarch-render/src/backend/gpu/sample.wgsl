// One sample of a pixel. gpu/kernel.rs names the function of the mode in place of the path's.

fn samples_of(x: u32, y: u32) -> vec4f {
    let random = random_new(x, y, slice.sample, frame.seed);
    return checked(kept(radiance_along(camera_ray(x, y, random), random)));
}
