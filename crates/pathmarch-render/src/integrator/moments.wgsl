// Paths as what their uncertainty is computed of. Twin of variance.rs.

/// What the film sums of the radiance of a path: luminance and its square.
fn as_filmed(radiance: vec3f) -> vec3f {
    let luminance = dot(radiance, vec3f(0.2126, 0.7152, 0.0722));
    return vec3f(luminance, luminance * luminance, 0.0);
}

fn moments_along(camera: Ray, random: Random) -> vec3f {
    return as_filmed(radiance_along(camera, random));
}
