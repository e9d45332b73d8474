// Materials and triangles of the fields of meshes.

/// Surface with the material of the closest triangle, if it is the field of a mesh for which that matters.
fn with_nearest_triangle(surface_at_hit: Surface, p: vec3f) -> Surface {
    if surface_at_hit.triangle != NO_TRIANGLE || (leaf_at(surface_at_hit.leaf).flags & MESH_FIELD) == 0u {
        return surface_at_hit;
    }
    let instance = mesh_word(mesh_word(2u) + surface_at_hit.leaf);
    let local = instance_point(instance, modifier_coordinates(mesh_word(instance + 17u), p).p);
    let triangle = nearest_triangle(instance, local);
    return Surface(surface_at_hit.gradient, surface_at_hit.distance, leaf_of_triangle(instance, triangle), triangle);
}
