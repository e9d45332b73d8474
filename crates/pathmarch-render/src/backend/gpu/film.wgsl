// Rejection of samples that are not finite.

/// Sample for the film; one that is not finite becomes zero and is counted in the fourth number.
fn kept(radiance: vec3f) -> vec4f {
    // Comparisons with NaN are false, so that this also catches NaN.
    if all(radiance >= vec3f(0.0)) && all(radiance < vec3f(1e30)) {
        return vec4f(radiance, 0.0);
    }
    return vec4f(0.0, 0.0, 0.0, 1.0);
}
