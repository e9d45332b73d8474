// import: intersect/ray, sampler, sampling/unit_circle
// Camera rays. Twin of camera.rs.

/// Camera ray of a sample of the pixel (`x`, `y`); row 0 is at the top.
fn camera_ray(x: u32, y: u32, sampler: PixelSampler) -> Ray {
    return camera_ray_of(vec2u(x, y), vec2u(frame.width, frame.height), sampler);
}

/// Point on the ray through the centre of the lens and the place in the picture of a camera ray, at the depth of a point.
fn central_point(ray: Ray, p: vec3f) -> vec3f {
    if frame.lens_radius == 0.0 {
        return p;
    }
    let in_focus = ray.origin + ray.direction * (frame.focus / dot(ray.direction, frame.forward));
    return frame.position + (in_focus - frame.position) * (dot(p - frame.position, frame.forward) / frame.focus);
}

/// Vector from the centre of the lens to a sample of a pixel of a picture of this size; its depth is 1.
fn view_vector(pixel: vec2u, size: vec2u, sampler: PixelSampler) -> vec3f {
    let pixel_offset = sample_2d(sampler, PAIR_PIXEL);
    let across = 2.0 * (f32(pixel.x) + pixel_offset.x) / f32(size.x) - 1.0;
    let up = 1.0 - 2.0 * (f32(pixel.y) + pixel_offset.y) / f32(size.y);
    return frame.forward + frame.right * across + frame.up * up;
}

/// Camera ray of a sample of a pixel of a picture of this size.
fn camera_ray_of(pixel: vec2u, size: vec2u, sampler: PixelSampler) -> Ray {
    let towards = view_vector(pixel, size, sampler);
    if frame.lens_radius == 0.0 {
        return Ray(frame.position, normalize(towards));
    }
    let u = sample_2d(sampler, PAIR_LENS);
    let radius = frame.lens_radius * sqrt(u.x);
    let disc_point = radius * unit_circle(u.y);
    let offset = normalize(frame.right) * disc_point.x + normalize(frame.up) * disc_point.y;
    return Ray(frame.position + offset, normalize(towards * frame.focus - offset));
}
