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
fn record_guide(
    interaction: SurfaceInteraction,
    throughput: vec3f,
    length: f32,
    surface_index: u32,
    colour: vec3f,
) {}

/// Does nothing.
fn store_guide(pixel: u32, radiance: vec3f) {}
