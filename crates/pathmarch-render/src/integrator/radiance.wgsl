// Paths as the film sums them in pictures of light.

fn as_filmed(radiance: vec3f) -> vec3f {
    return radiance;
}
