// import: integrator/medium, nested_dielectrics
// Media around a path in scenes whose solids absorb and do no more. Takes the place of participating_media.wgsl.

/// Absorption coefficient, per metre.
alias Medium = vec3f;

/// Solids around a path; none are known.
struct Solids {
    leaves: vec4u,
    keys: vec4u,
}

/// Medium around the camera.
fn camera_medium() -> Medium {
    return frame.medium;
}

/// Transmittance of the medium over a length in metres.
fn transmittance_in(medium: Medium, length: f32) -> vec3f {
    return transmittance(medium, length);
}

/// Medium beyond the surface of a leaf that a path crosses.
fn medium_after(medium: Medium, leaf: u32, inside: bool) -> Medium {
    return medium_beyond(medium, material_at(leaf_at(leaf).material).absorption, inside);
}

/// The second medium if the condition is true, else the first.
fn chosen_medium(first: Medium, second: Medium, is_second: bool) -> Medium {
    return select(first, second, is_second);
}

/// Medium of a resumed path.
fn resumed_medium(absorption: vec3f, forward: f32, scattering: vec3f, solids: u32, emission: vec3f, around: vec4u) -> Medium {
    return absorption;
}

fn absorption_of(medium: Medium) -> vec3f {
    return medium;
}

fn scattering_of(medium: Medium) -> vec3f {
    return vec3f(0.0);
}

fn forward_of(medium: Medium) -> f32 {
    return 0.0;
}

fn emission_of(medium: Medium) -> vec3f {
    return vec3f(0.0);
}

fn solids_of(medium: Medium) -> u32 {
    return 0u;
}

fn around_of(medium: Medium) -> vec4u {
    return vec4u(0u);
}
