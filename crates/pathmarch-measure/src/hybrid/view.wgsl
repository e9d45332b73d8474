/// Camera of a picture. Twin of `ViewUniform`.
struct View {
    /// Projection whose pixel centres are the raster's samples.
    clip_from_world: mat4x4f,
    position: vec3f,
    width: u32,
    /// From the middle of the picture to its right edge, at a distance of one.
    right: vec3f,
    height: u32,
    /// From the middle of the picture to its upper edge, at a distance of one.
    up: vec3f,
    /// Largest second difference of depths over three pixels without an edge, relative to the depth.
    max_bend: f32,
    /// Unit vector.
    forward: vec3f,
    /// One if the ray of each pixel has an offset of its own, zero if all have that of the raster.
    has_own_offsets: u32,
    /// Position of the raster's samples in their pixels, 0 to 1.
    raster_offset: vec2f,
}

@group(0) @binding(0) var<uniform> view: View;
