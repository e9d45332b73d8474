// import: intersect/ray, ray_kind
// Sphere tracing. Twin of march.rs, which explains the tolerances.

/// Distance of a ray that hits nothing.
const NO_HIT = -1.0;
/// Distance beyond every scene, metres.
const AT_INFINITY = 1e30;

/// Largest component.
fn largest(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// Hit tolerance at a point of a path of this length, metres.
fn tolerance(p: vec3f, path_length: f32) -> f32 {
    return max(frame.tolerance * path_length, frame.rounding * largest(abs(p)));
}

/// Rounding error of a point on a surface, metres; `origin` is that of its coordinates.
fn rounding_at(p: vec3f, origin: vec3f) -> f32 {
    return frame.rounding * largest(max(abs(p), abs(p - origin)));
}

/// Distance from a surface at which rays start, metres, from the rounding error and the distance at the hit.
fn start_offset(rounding: f32, distance: f32) -> f32 {
    return START_OFFSET * rounding + 0.05 * abs(distance);
}

/// Hit of a ray.
struct Hit {
    /// Distance from the origin, metres, or NO_HIT.
    t: f32,
    /// True for an analytic hit.
    analytic: bool,
    /// Analytic shape, or SPHERE_TRACED, as `surface` takes it.
    hit_id: u32,
    /// Triangle of a hit with a mesh, or NO_TRIANGLE.
    triangle: u32,
}

/// First hit of a ray that continues a path of this length, up to `limit` metres.
fn march(ray: Ray, path_length: f32, limit: f32) -> Hit {
    begin_ray(path_length);
    let analytic = analytic_hit(ray.origin, ray.direction);
    let t_max = min(limit, frame.far);
    let inverse = 1.0 / select(ray.direction, vec3f(1e-12), abs(ray.direction) < vec3f(1e-12));
    let a = (frame.bounds_min - ray.origin) * inverse;
    let b = (frame.bounds_max - ray.origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let end = min(min(far.x, min(far.y, far.z)), min(analytic.t, t_max));
    var t = max(largest(near), 0.0);
    let analytic_t = select(NO_HIT, analytic.t, analytic.t < t_max);
    if !HAS_SPHERE_TRACED {
        return Hit(analytic_t, true, analytic.hit_id, analytic.triangle);
    }
    // While the ray leaves the surface that it starts on and the distance rises, a small distance is no hit.
    var last_distance = select(AT_INFINITY, 0.0, t == 0.0);
    var distance = 0.0;
    var radius = 0.0;
    var stride = 0.0;
    for (var step = 0u; step < MAX_STEPS; step++) {
        if t >= end {
            // The ray ends beyond the last unbounding sphere: evaluate the field at the end of that sphere first.
            t += radius - stride;
            stride = radius;
            if t >= end {
                distance = AT_INFINITY;
                break;
            }
        }
        let p = ray.origin + ray.direction * t;
        distance = sphere_traced_distance(p) * frame.step_factor;
        // Disjoint unbounding spheres: retreat to the end of the last one.
        if stride > radius + distance {
            t += radius - stride;
            stride = radius;
            continue;
        }
        let change = clamp((distance - radius) / max(stride, 1e-30), MIN_SLOPE, MAX_SLOPE);
        let slope = select(MIN_SLOPE, change, stride > 0.0);
        var hit_tolerance = tolerance(p, path_length + t);
        if REFINED_GRAZING && slope > GRAZING_SLOPE {
            hit_tolerance = max(GRAZING_TOLERANCE * hit_tolerance, frame.rounding * largest(abs(p)));
        }
        if distance < min(hit_tolerance, last_distance) {
            break;
        }
        last_distance = select(AT_INFINITY, distance, distance < hit_tolerance);
        radius = max(distance, hit_tolerance);
        stride = radius * max(RELAXATION / (1.0 - slope), 1.0);
        t += stride;
    }
    // A ray without steps left hits a surface that is close.
    if distance < 0.01 * (path_length + t) {
        return Hit(t, false, SPHERE_TRACED, NO_TRIANGLE);
    }
    return Hit(analytic_t, true, analytic.hit_id, analytic.triangle);
}
