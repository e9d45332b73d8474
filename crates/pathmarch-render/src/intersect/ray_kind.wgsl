// Kinds of rays, for meshes that are lit by their field.

/// Tells the field of a ray that continues a path of this length.
fn begin_ray(path_length: f32) {
    is_camera_ray = path_length == 0.0;
}

/// Distance at which other rays start off, besides that of all surfaces, metres.
fn clearance(hit_id: u32, triangle: u32) -> f32 {
    if triangle == NO_TRIANGLE {
        return 0.0;
    }
    return mesh_clearance(hit_id - MESH);
}
