// One sample of a pixel, left out where the adapter ended its loops. gpu/kernel.rs names the function of the mode in place
// of the path's.

fn samples_of(x: u32, y: u32) -> vec4f {
    let random = random_new(x, y, slice.sample, frame.seed);
    let colour = radiance_along(camera_ray(x, y, random), random);
    if loops_ended() {
        atomicAdd(&suspended.count, 1u);
        return vec4f(0.0);
    }
    return kept(colour);
}
