// Light that media in front of the first surface scatter or emit. Twin of medium_light.rs.

/// Distance from the camera of a depth in a medium, metres; `far` is the far end of all rays.
fn distance_in_medium(depth: f32, far: f32) -> f32 {
    return MEDIUM_SCALE * far * depth / (1.0 - depth);
}

/// Inverse of `distance_in_medium`.
fn depth_in_medium(distance: f32, far: f32) -> f32 {
    return distance / (distance + MEDIUM_SCALE * far);
}
