// Statistics of sphere tracing, for the views of steps and violations. Twin of `MarchStats` in ray_stats.rs.

/// Number of evaluations of the field so far.
var<private> steps: u32;
/// Steepest change of the distance so far, relative to the Lipschitz constant.
var<private> steepest: f32;
/// Point (xyz) and distance (w) of the last evaluation.
var<private> last_evaluation: vec4f;

/// Distance to the sphere-traced objects. Counts its calls.
fn sphere_traced_distance(p: vec3f) -> f32 {
    let distance = uncounted_distance(p);
    let change = abs(distance - last_evaluation.w) * frame.step_factor - TOLERATED_ROUNDING_ERRORS * frame.rounding * largest(abs(p));
    if steps > 0u {
        steepest = max(steepest, change / max(length(p - last_evaluation.xyz), 1e-30));
    }
    last_evaluation = vec4f(p, distance);
    steps += 1u;
    return distance;
}
