// Rasterised triangle ids: the index of the triangle plus one.

@vertex
fn vertex(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return view.clip_from_world * vec4f(position, 1.0);
}

@fragment
fn fragment(@builtin(primitive_index) triangle: u32) -> @location(0) u32 {
    return triangle + 1u;
}
