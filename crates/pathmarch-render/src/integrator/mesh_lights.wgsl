// import: integrator/sky, textures
// Emitting triangles of meshes. Twin of scene/mesh_light.rs, which explains them.

/// Number of the light that a triangle of a leaf is, from one on, or zero; `light` is that of any light of the leaf.
fn light_of_triangle(light: u32, triangle: u32) -> u32 {
    if light == 0u || triangle == NO_TRIANGLE {
        return light;
    }
    let any = light_at(light - 1u);
    if any.kind != TRIANGLES || any.x.y < 0.0 {
        return light;
    }
    return scene_word(scene_word(MESH_LIGHT_DATA + 2u * u32(any.x.y) + 1u) + triangle);
}

/// Samples a point by area on the triangles of a mesh.
fn sample_mesh(light: Light, p: vec3f, position: vec2f) -> LightSample {
    let table = scene_word(MESH_LIGHT_DATA + 2u * u32(light.x.x));
    let count = scene_word(table + 1u);
    let cell = sample_alias_table(table + 2u, count, position.x);
    let triangle = scene_word(table + 2u + 2u * count + u32(cell.x));
    let root = sqrt(cell.y);
    let weights = vec2f(root * (1.0 - position.y), root * position.y);
    let instance = mesh_word(mesh_word(2u) + light.leaf);
    let corners = triangle_edges(instance, triangle);
    let local = corners[0] + corners[1] * weights.x + corners[2] * weights.y;
    let rows = instance_rows(instance);
    let scale = mesh_float(instance + 3u);
    let size = largest_of_edges(corners[1], corners[2]);
    let normal = normalize(rows * cross(corners[1] / size, corners[2] / size));
    // The rows are divided by the scale.
    let offset = mesh_vector(instance) + rows * local * (scale * scale) - p;
    let square = dot(offset, offset);
    let distance = sqrt(square);
    let direction = offset / distance;
    let cosine = -dot(normal, direction);
    if cosine == 0.0 || (cosine < 0.0 && scene_word(table) != 0u) {
        return LightSample(direction, 0.0, vec3f(0.0), 0.0, NO_TARGET, 0.0);
    }
    let radiance = emission_on_mesh(light.leaf, triangle, local) * light.inverse_pmf;
    let pdf = square / (light.area * abs(cosine));
    return LightSample(direction, distance * SHADOW_RAY_SHARE, radiance / pdf, pdf * light.pmf, NO_TARGET, 0.0);
}
