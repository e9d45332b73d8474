// Statistics of sphere tracing, for the views of steps and violations. Twin of `MarchStats`.

/// Evaluations of the field so far, and its steepest change over what the Lipschitz constant allows.
var<private> steps: u32;
var<private> steepest: f32;
/// Last point, and the distance there.
var<private> last_evaluation: vec4f;

/// Distance of the sphere-traced objects, counted.
fn sphere_traced_distance(p: vec3f) -> f32 {
    let distance = uncounted_distance(p);
    let change = abs(distance - last_evaluation.w) * frame.step_factor - NOISE * frame.rounding * largest(abs(p));
    if steps > 0u {
        steepest = max(steepest, change / max(length(p - last_evaluation.xyz), 1e-30));
    }
    last_evaluation = vec4f(p, distance);
    steps += 1u;
    return distance;
}
