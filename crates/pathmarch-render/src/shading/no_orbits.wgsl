// Materials without orbit traps.

fn has_orbit(leaf: u32) -> bool {
    return false;
}

fn orbit(leaf: u32, p: vec3f, centre: vec3f) -> array<f32, 6> {
    return array<f32, 6>();
}
