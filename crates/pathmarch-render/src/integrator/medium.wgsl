// Absorbing media inside solids. Twin of medium.rs.

/// Transmittance of a medium over a length in metres; `medium` is the absorption coefficient, per metre.
fn transmittance(medium: vec3f, length: f32) -> vec3f {
    return exp(-medium * min(length, UNBOUNDED_LENGTH));
}

/// Absorption coefficient beyond a surface that a path crosses, per metre.
fn medium_beyond(medium: vec3f, absorption: vec3f, inside: bool) -> vec3f {
    return max(select(medium + absorption, medium - absorption, inside), vec3f(0.0));
}
