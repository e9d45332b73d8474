// import: intersect/march
// Soft shadows from near misses. Twin of `near_misses` in shadow.rs.

fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {
    var light = 1.0;
    let last = min(limit, frame.far);
    var t = tolerance(ray.origin, 0.0);
    for (var step = 0u; step < MAX_STEPS; step++) {
        let p = ray.origin + ray.direction * t;
        let distance = estimated_distance(p) * frame.step_factor;
        light = min(light, sharpness * distance / t);
        if light < 0.001 {
            return 0.0;
        }
        t += distance;
        if t > last {
            break;
        }
    }
    // Smooth at both ends.
    return light * light * (3.0 - 2.0 * light);
}
