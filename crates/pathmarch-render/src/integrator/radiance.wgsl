// Film of radiance.

/// Value that the film adds up for the radiance of a path.
fn film_value(radiance: vec3f) -> vec3f {
    return radiance;
}
