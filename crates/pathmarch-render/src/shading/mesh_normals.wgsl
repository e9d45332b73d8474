// import: shading/surface_interaction
// Normals of meshes.

/// Shading normal that points out of the solid: interpolated on meshes, else the geometric one.
fn smooth_outward(interaction: SurfaceInteraction) -> vec3f {
    let outward = outward_normal(interaction);
    // The gradient is the normal of a field.
    if !interaction.is_triangle_hit {
        return outward;
    }
    return mesh_shading_normal(interaction.leaf, interaction.triangle, interaction.p, outward);
}
