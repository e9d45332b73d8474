// Film of moments, for error estimates. Twin of moments.rs.

/// Film value of a path: luminance and its square.
fn film_value(radiance: vec3f) -> vec3f {
    let luminance = dot(radiance, vec3f(0.2126, 0.7152, 0.0722));
    return vec3f(luminance, luminance * luminance, 0.0);
}
