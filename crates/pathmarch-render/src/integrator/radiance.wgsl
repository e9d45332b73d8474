// Film of radiance.

/// Film value of a path: its radiance.
fn film_value(radiance: vec3f) -> vec3f {
    return radiance;
}
