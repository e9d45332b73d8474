// Parameters of BSDFs without textures. Takes the place of textured_bsdf.wgsl.

/// Parameters 4k to 4k + 3 of a BSDF.
fn packed(m: u32, k: u32) -> vec4f {
    return material_parameter(m, k);
}

/// Colour of clear glass that a shadow ray passes through.
fn glass_colour(m: u32, interaction: SurfaceInteraction, path_length: f32) -> vec3f {
    return material_parameter(m, 0u).xyz;
}
