// Sphere tracing. Twin of march.rs, which explains the tolerances.

const MAX_STEPS = 256u;
const START_OFFSET = 3.0;
const NO_HIT = -1.0;

fn largest(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// What is negligible at a point of a path of this length.
fn tolerance(p: vec3f, path_length: f32) -> f32 {
    return max(frame.tolerance * path_length, frame.rounding * largest(abs(p)));
}

/// How far from a shape with a closed form a hit on it may be by rounding; `at` is the origin of its coordinates.
fn direct_tolerance(p: vec3f, at: vec3f) -> f32 {
    return frame.rounding * largest(max(abs(p), abs(p - at)));
}

/// Follows a ray after a path of length `before` up to `limit` metres; gives the metres to the hit, or NO_HIT.
fn march(ray: Ray, before: f32, limit: f32) -> f32 {
    let direct = direct_hit(ray.origin, ray.direction);
    let last = min(limit, frame.far);
    let otherwise = select(NO_HIT, direct, direct < last);
    let inverse = 1.0 / select(ray.direction, vec3f(1e-12), abs(ray.direction) < vec3f(1e-12));
    let a = (frame.bounds_min - ray.origin) * inverse;
    let b = (frame.bounds_max - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let end = min(min(far.x, min(far.y, far.z)), min(direct, last));
    var t = max(largest(near), 0.0);
    if t >= end {
        return otherwise;
    }
    var distance = 0.0;
    for (var step = 0u; step < MAX_STEPS; step++) {
        let p = ray.origin + ray.direction * t;
        distance = marched_distance(p) * frame.step_factor;
        if distance < tolerance(p, before + t) {
            return t;
        }
        t += distance;
        if t > end {
            return otherwise;
        }
    }
    return select(otherwise, t, distance < 0.01 * (before + t));
}
