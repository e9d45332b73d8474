// import: intersect/march
// Soft shadows in few steps. Twin of soft_shadow.rs, which explains them.

/// Visibility of a light along a ray that starts on a leaf.
fn soft_shadow(ray: Ray, leaf: u32, limit: f32, sharpness: f32) -> f32 {
    var visibility = 1.0;
    let t_max = min(limit, frame.far);
    let min_step = MIN_STEP / sharpness;
    let max_step_share = max(MAX_STEP, MAX_STEP_BY_SHARPNESS * sharpness);
    var t = tolerance(ray.origin, 0.0);
    var previous = AT_INFINITY;
    for (var step = 0u; step < SHADOW_STEPS; step++) {
        let distance = occluder_distance(ray.origin + ray.direction * t, leaf) * frame.step_factor;
        // Distance back to the nearest miss, if that is within the last step.
        let back_estimate = distance * distance / (2.0 * previous);
        let back = select(0.0, back_estimate, back_estimate < previous);
        let nearest_miss = sqrt(max(distance * distance - back * back, 0.0));
        visibility = min(visibility, sharpness * nearest_miss / (t - back));
        let max_step = select(t * max_step_share, AT_INFINITY, previous == AT_INFINITY);
        previous = max(min(distance, max_step), t * min_step);
        t += previous;
        if visibility < SHADOWED_VISIBILITY || t > t_max {
            break;
        }
    }
    visibility = max(visibility - SHADOWED_VISIBILITY, 0.0) / (1.0 - SHADOWED_VISIBILITY);
    // Smoothstep.
    return visibility * visibility * (3.0 - 2.0 * visibility);
}
