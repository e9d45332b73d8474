// import: intersect/ray, shading/surface_interaction
// No guides. Takes the place of guides.wgsl.

/// Does nothing.
fn begin_guide(camera: Ray) {}

/// Never.
fn guide_waits() -> bool {
    return false;
}

/// Does nothing.
fn end_guide() {}

/// Does nothing.
fn record_scattering(m: u32, surface_index: u32, radiance: vec3f) {}

/// Does nothing.
fn record_shared(light: vec3f) {}

/// Does nothing.
fn record_medium(p: vec3f, light: vec3f) {}

/// Does nothing.
fn record_event(p: vec3f, surface_index: u32, radiance: vec3f) {}

/// Does nothing.
fn record_guide(
    interaction: SurfaceInteraction,
    throughput: vec3f,
    length: f32,
    surface_index: u32,
    colour: vec3f,
) {}

/// Does nothing.
fn store_guide(pixel: u32, radiance: vec3f) {}

/// Does nothing.
fn record_light_sample(m: u32, wo: vec3f, wi: vec3f, inside: bool, distance: f32, light: vec3f) {}

/// Does nothing.
fn record_next_ray(m: u32, wo: vec3f, wi: vec3f, inside: bool, radiance: vec3f) {}

/// Does nothing.
fn record_arrival(length: f32) {}
