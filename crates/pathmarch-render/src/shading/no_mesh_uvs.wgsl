// Pictures at texture coordinates in scenes without them. Takes the place of mesh_uvs.wgsl.

/// Does nothing.
fn begin_uvs(leaf: u32, triangle: u32, local: vec3f) {}

/// Returns zero: there is no tangent.
fn uv_tangent() -> vec4f {
    return vec4f(0.0);
}

/// Returns black.
fn uv_picture(texture: u32, picture: TexturePicture, footprint: f32) -> vec4f {
    return vec4f(0.0);
}
