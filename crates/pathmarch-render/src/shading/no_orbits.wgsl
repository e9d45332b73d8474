// Materials without orbit traps.

fn has_orbit(leaf: u32) -> bool {
    return false;
}

fn orbit(leaf: u32, p: vec3f) -> array<f32, 5> {
    return array<f32, 5>();
}
