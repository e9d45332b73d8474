// Sphere tracing. Twin of march.rs, which explains the tolerances.

const MAX_STEPS = 256u;
const START_OFFSET = 3.0;
const NO_HIT = -1.0;
/// How the distance changes along a ray, at the least and at the most.
const STEEPEST_FALL = -1.0;
const STEEPEST_RISE = 0.6;
/// A ray grazes where the distance along it changes by more than this per metre.
const GRAZING_SLOPE = -0.5;
/// Share of the tolerance at which a ray that grazes hits a surface.
const GRAZING_TOLERANCE = 0.0625;
/// A distance beyond every scene.
const AT_INFINITY = 1e30;

fn largest(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// What is negligible at a point of a path of this length.
fn tolerance(p: vec3f, path_length: f32) -> f32 {
    return max(frame.tolerance * path_length, frame.rounding * largest(abs(p)));
}

/// How far from a surface a point on it may be by rounding; `at` is the origin of its coordinates.
fn rounding_at(p: vec3f, at: vec3f) -> f32 {
    return frame.rounding * largest(max(abs(p), abs(p - at)));
}

/// How far off a surface a ray starts; `off` is the rounding there and `distance` that of the point that was reached.
fn start_offset(off: f32, distance: f32) -> f32 {
    return START_OFFSET * off + 0.05 * abs(distance);
}

/// Where a ray ends.
struct Hit {
    /// Metres, or NO_HIT.
    t: f32,
    /// Whether the object has a closed form.
    direct: bool,
    /// What `surface` tells it by.
    met: u32,
}

/// Follows a ray after a path of length `before` up to `limit` metres.
fn march(ray: Ray, before: f32, limit: f32) -> Hit {
    let first = analytic_hit(ray.origin, ray.direction);
    let direct = first.t;
    let last = min(limit, frame.far);
    let inverse = 1.0 / select(ray.direction, vec3f(1e-12), abs(ray.direction) < vec3f(1e-12));
    let a = (frame.bounds_min - ray.origin) * inverse;
    let b = (frame.bounds_max - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let end = min(min(far.x, min(far.y, far.z)), min(direct, last));
    var t = max(largest(near), 0.0);
    let otherwise = select(NO_HIT, direct, direct < last);
    if !HAS_SPHERE_TRACED {
        return Hit(otherwise, true, first.hit_id);
    }
    // On the way off the surface that the ray starts on, while the distance rises, closeness is no hit.
    var last_distance = select(AT_INFINITY, 0.0, t == 0.0);
    var distance = 0.0;
    var radius = 0.0;
    var stride = 0.0;
    for (var step = 0u; step < MAX_STEPS; step++) {
        if t >= end {
            // The way there may not be free.
            t += radius - stride;
            stride = radius;
            if t >= end {
                distance = AT_INFINITY;
                break;
            }
        }
        let p = ray.origin + ray.direction * t;
        distance = sphere_traced_distance(p) * frame.step_factor;
        if stride > radius + distance {
            t += radius - stride;
            stride = radius;
            continue;
        }
        let change = clamp((distance - radius) / max(stride, 1e-30), STEEPEST_FALL, STEEPEST_RISE);
        let slope = select(STEEPEST_FALL, change, stride > 0.0);
        var close = tolerance(p, before + t);
        if REFINED_GRAZING && slope > GRAZING_SLOPE {
            close = max(GRAZING_TOLERANCE * close, frame.rounding * largest(abs(p)));
        }
        if distance < min(close, last_distance) {
            break;
        }
        last_distance = select(AT_INFINITY, distance, distance < close);
        radius = max(distance, close);
        stride = radius * max(RELAXATION / (1.0 - slope), 1.0);
        t += stride;
    }
    // Out of steps, close to a surface counts as on it.
    if distance < 0.01 * (before + t) {
        return Hit(t, false, SPHERE_TRACED);
    }
    return Hit(otherwise, true, first.hit_id);
}
