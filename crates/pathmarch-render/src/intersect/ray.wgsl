// Rays. Twin of ray.rs.

/// Ray in world space.
struct Ray {
    origin: vec3f,
    /// Unit vector.
    direction: vec3f,
}
