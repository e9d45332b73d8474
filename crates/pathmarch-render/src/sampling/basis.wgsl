// Orthonormal bases around a direction. Twin of basis.rs.

/// Unit vector in the direction of one whose length is one but for rounding: a step of Newton's method.
fn renormalized(v: vec3f) -> vec3f {
    return v * (1.5 - 0.5 * dot(v, v));
}

/// Right-handed orthonormal basis with `n` as its z axis. Maps local to world space.
fn basis(n: vec3f) -> mat3x3f {
    let sign = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = vec3f(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    return mat3x3f(tangent, vec3f(b, sign + n.y * n.y * a, -n.y), n);
}
