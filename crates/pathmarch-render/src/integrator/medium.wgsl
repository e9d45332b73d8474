// Absorbing media. Twin of `transmittance` and `medium_beyond` in path.rs.

/// Transmittance of a medium over a length.
fn transmittance(medium: vec3f, length: f32) -> vec3f {
    return exp(-medium * min(length, UNBOUNDED_LENGTH));
}

/// Absorption coefficient beyond a surface that a path crosses.
fn medium_beyond(medium: vec3f, absorption: vec3f, inside: bool) -> vec3f {
    return max(select(medium + absorption, medium - absorption, inside), vec3f(0.0));
}
