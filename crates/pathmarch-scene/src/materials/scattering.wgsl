// What the materials' functions share. Twin of mod.rs and of `cosine_direction` in diffuse.rs.

struct Scattered {
    wi: vec3f,
    /// 0 for one of single directions; below 0 where the light is lost.
    pdf: f32,
    weight: vec3f,
    /// Relative index beyond the surface; 1 where it was reflected.
    eta: f32,
}

const ABSORBED = Scattered(vec3f(0.0, 0.0, 1.0), -1.0, vec3f(0.0), 1.0);

/// A direction about z, its density cosine/π over solid angle.
fn cosine_direction(u: vec2f) -> vec3f {
    return vec3f(sqrt(u.x) * unit_circle(u.y), sqrt(max(1.0 - u.x, 1e-8)));
}
