// import: integrator/light_sampling
// Pictures without photon maps.

/// False: there are no light paths.
fn starts_light_paths(light: Light) -> bool {
    return false;
}

/// Never called: there are no photons.
fn photon_radiance(
    m: u32,
    interaction: SurfaceInteraction,
    wo: vec3f,
    world_from_local: mat3x3f,
    transmits: bool,
    footprint: f32,
    surface_index: u32,
    seed: u32,
) -> vec3f {
    return vec3f(0.0);
}
