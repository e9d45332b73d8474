// Rays. Twin of ray.rs.

/// Ray in world space.
struct Ray {
    origin: vec3f,
    /// Of length one.
    direction: vec3f,
}
