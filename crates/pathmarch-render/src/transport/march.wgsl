// Sphere tracing. Twin of march.rs, which explains the tolerances.

const MAX_STEPS = 256u;
const START_OFFSET = 3.0;
const NO_HIT = -1.0;

fn largest(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// What is negligible at a point of a path of this length.
fn tolerance(p: vec3f, path_length: f32) -> f32 {
    return max(frame.tolerance * path_length, frame.precision * largest(abs(p)));
}

/// Marches a ray after a path of length `before` up to `limit` metres; gives the metres to the hit, or NO_HIT.
fn march(ray: Ray, before: f32, limit: f32) -> f32 {
    let inverse = 1.0 / ray.direction;
    let a = (frame.bounds_min - ray.origin) * inverse;
    let b = (frame.bounds_max - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let end = min(min(far.x, min(far.y, far.z)), min(frame.far, limit));
    var t = max(largest(near), 0.0);
    if t >= end {
        return NO_HIT;
    }
    var distance = 0.0;
    for (var step = 0u; step < MAX_STEPS; step++) {
        let p = ray.origin + ray.direction * t;
        distance = abs(field(p)) * frame.step_factor;
        if distance < tolerance(p, before + t) {
            return t;
        }
        t += distance;
        if t > end {
            return NO_HIT;
        }
    }
    return select(NO_HIT, t, distance < 0.01 * (before + t));
}
