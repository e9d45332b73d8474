// import: intersect/ray
// Sphere tracing. Twin of march.rs, which explains the tolerances.

/// Distance of a ray that hits nothing.
const NO_HIT = -1.0;
/// A distance beyond every scene.
const AT_INFINITY = 1e30;

fn largest(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// Hit tolerance at a point of a path of this length, metres.
fn tolerance(p: vec3f, path_length: f32) -> f32 {
    return max(frame.tolerance * path_length, frame.rounding * largest(abs(p)));
}

/// Rounding error of a point on a surface, metres; `at` is the origin of its coordinates.
fn rounding_at(p: vec3f, at: vec3f) -> f32 {
    return frame.rounding * largest(max(abs(p), abs(p - at)));
}

/// Distance from a surface at which rays start, metres, from the rounding error and the distance at the hit.
fn start_offset(rounding: f32, distance: f32) -> f32 {
    return START_OFFSET * rounding + 0.05 * abs(distance);
}

/// Hit of a ray.
struct Hit {
    /// Distance, metres, or NO_HIT.
    t: f32,
    /// Whether the shape is analytic.
    analytic: bool,
    /// Shape or marker that `surface` takes.
    hit_id: u32,
}

/// First hit of a ray that continues a path of this length, up to `limit` metres.
fn march(ray: Ray, path_length: f32, limit: f32) -> Hit {
    let first = analytic_hit(ray.origin, ray.direction);
    let analytic = first.t;
    let last = min(limit, frame.far);
    let inverse = 1.0 / select(ray.direction, vec3f(1e-12), abs(ray.direction) < vec3f(1e-12));
    let a = (frame.bounds_min - ray.origin) * inverse;
    let b = (frame.bounds_max - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let end = min(min(far.x, min(far.y, far.z)), min(analytic, last));
    var t = max(largest(near), 0.0);
    let otherwise = select(NO_HIT, analytic, analytic < last);
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
        var close = tolerance(p, path_length + t);
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
    if distance < 0.01 * (path_length + t) {
        return Hit(t, false, SPHERE_TRACED);
    }
    return Hit(otherwise, true, first.hit_id);
}
