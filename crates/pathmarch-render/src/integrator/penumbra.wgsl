// import: intersect/march
// Soft shadows from near misses. Twin of `near_misses` in shadow.rs.

/// Share of a light that the near misses of a shadow ray leave.
fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {
    var visibility = 1.0;
    let t_max = min(limit, frame.far);
    var t = tolerance(ray.origin, 0.0);
    for (var step = 0u; step < MAX_STEPS; step++) {
        let p = ray.origin + ray.direction * t;
        let distance = estimated_distance(p) * frame.step_factor;
        visibility = min(visibility, sharpness * distance / t);
        if visibility < 0.001 {
            return 0.0;
        }
        t += distance;
        if t > t_max {
            break;
        }
    }
    // Smoothstep.
    return visibility * visibility * (3.0 - 2.0 * visibility);
}
