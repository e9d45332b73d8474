// import: shading/surface_interaction, texture_target
// Materials without textures. Takes the place of textured_material.wgsl.

/// Does nothing.
fn evaluate_textures(m: u32, interaction: SurfaceInteraction, path_length: f32) {}

/// Returns the emitted radiance of material `m`.
fn emission_at(m: u32) -> vec3f {
    return material_at(m).emission;
}

/// Returns the emitted radiance of the material of a leaf.
fn emission_on_mesh(leaf: u32, triangle: u32, local: vec3f) -> vec3f {
    return material_at(leaf_at(leaf).material).emission;
}

/// Returns the normal itself.
fn bumped_normal(outward: vec3f) -> vec3f {
    return outward;
}
