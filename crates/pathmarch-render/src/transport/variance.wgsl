// Paths as what their uncertainty is computed of. Twin of variance.rs.

fn moments_along(camera: Ray, random: Random) -> vec3f {
    let luminance = dot(radiance_along(camera, random), vec3f(0.2126, 0.7152, 0.0722));
    return vec3f(luminance, luminance * luminance, 0.0);
}
