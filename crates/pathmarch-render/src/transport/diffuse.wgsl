// Lambert's cosine law. Twin of diffuse.rs.

/// Two unit vectors that make a right-handed basis with `n`, as columns with it.
fn basis(n: vec3f) -> mat3x3f {
    let s = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return mat3x3f(vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3f(b, s + n.y * n.y * a, -n.y), n);
}

/// A direction about `n`, its density cosine/π over solid angle.
fn cosine_direction(n: vec3f, u: vec2f) -> vec3f {
    let radius = sqrt(u.x);
    let angle = 6.2831853 * u.y;
    let height = sqrt(max(1.0 - u.x, 0.0));
    return normalize(basis(n) * vec3f(radius * cos(angle), radius * sin(angle), height));
}
