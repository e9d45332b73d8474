// import: intersect/march
// Soft shadows in few steps. Twin of soft_shadow.rs, which explains them.

/// Share of a light that arrives along a ray from the leaf `own`.
fn soft_shadow(ray: Ray, own: u32, limit: f32, sharpness: f32) -> f32 {
    var light = 1.0;
    let last = min(limit, frame.far);
    let least = COARSE / sharpness;
    let longest = max(LONGEST, LONGEST_OF_CONE * sharpness);
    var t = tolerance(ray.origin, 0.0);
    var previous = AT_INFINITY;
    for (var step = 0u; step < SHADOW_STEPS; step++) {
        let distance = occluder_distance(ray.origin + ray.direction * t, own) * frame.step_factor;
        // How far back the ray was nearest, unless that was before the last step.
        let guess = distance * distance / (2.0 * previous);
        let back = select(0.0, guess, guess < previous);
        let nearest = sqrt(max(distance * distance - back * back, 0.0));
        light = min(light, sharpness * nearest / (t - back));
        let most = select(t * longest, AT_INFINITY, previous == AT_INFINITY);
        previous = max(min(distance, most), t * least);
        t += previous;
        if light < PASSED || t > last {
            break;
        }
    }
    light = max(light - PASSED, 0.0) / (1.0 - PASSED);
    // Smooth at both ends.
    return light * light * (3.0 - 2.0 * light);
}
