// Scenes without emitting triangles. Takes the place of mesh_lights.wgsl.

/// Never called: no light has triangles.
fn sample_mesh(light: Light, p: vec3f, position: vec2f) -> LightSample {
    return LightSample(vec3f(0.0), 0.0, vec3f(0.0), 0.0, NO_TARGET, 0.0);
}

/// Number of the light of a leaf.
fn light_of_triangle(light: u32, triangle: u32) -> u32 {
    return light;
}
