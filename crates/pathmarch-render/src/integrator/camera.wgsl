// import: intersect/ray, sampler
// Camera rays. Twin of camera.rs.

fn camera_ray(x: u32, y: u32, sampler: PixelSampler) -> Ray {
    let jitter = sample_2d(sampler, PAIR_PIXEL);
    let across = 2.0 * (f32(x) + jitter.x) / f32(frame.width) - 1.0;
    let up = 1.0 - 2.0 * (f32(y) + jitter.y) / f32(frame.height);
    let view = frame.forward + frame.right * across + frame.up * up;
    if frame.lens_radius == 0.0 {
        return Ray(frame.position, normalize(view));
    }
    let u = sample_2d(sampler, PAIR_LENS);
    let radius = frame.lens_radius * sqrt(u.x);
    let angle = 6.2831853 * u.y;
    let offset = normalize(frame.right) * (radius * cos(angle)) + normalize(frame.up) * (radius * sin(angle));
    return Ray(frame.position + offset, normalize(view * frame.focus - offset));
}
