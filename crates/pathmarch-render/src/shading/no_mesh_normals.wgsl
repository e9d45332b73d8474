// import: shading/surface_interaction
// Normals of scenes whose meshes have none. Takes the place of mesh_normals.wgsl.

/// Returns the geometric normal that points out of the solid.
fn smooth_outward(interaction: SurfaceInteraction) -> vec3f {
    return outward_normal(interaction);
}
