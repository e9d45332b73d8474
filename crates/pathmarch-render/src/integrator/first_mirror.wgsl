// Mirrors that the camera sees, in one word for each pixel. Twin of first_mirror.rs.

/// Unit vector in two numbers from -1 to 1: an octahedral map (Meyer et al. 2010).
fn octahedral(v: vec3f) -> vec2f {
    let flat = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    let folded = (1.0 - abs(flat.yx)) * select(vec2f(-1.0), vec2f(1.0), flat >= vec2f(0.0));
    return select(flat, folded, v.z < 0.0);
}

/// Inverse of `octahedral`.
fn from_octahedral(flat: vec2f) -> vec3f {
    let z = 1.0 - abs(flat.x) - abs(flat.y);
    let overhang = max(-z, 0.0);
    return normalize(vec3f(flat - select(vec2f(-overhang), vec2f(overhang), flat >= vec2f(0.0)), z));
}

/// Word of a mirror at a distance from the camera, with this normal.
fn packed_first_mirror(distance: f32, normal: vec3f) -> u32 {
    let most = f32((1u << NORMAL_BITS) - 1u);
    let numbers = vec2u((0.5 * octahedral(normal) + 0.5) * most + 0.5);
    let kept = (bitcast<u32>(distance) >> DISTANCE_SHIFT) << DISTANCE_SHIFT;
    return MIRROR_BIT | kept | (numbers.x << NORMAL_BITS) | numbers.y;
}

/// Distance of a mirror from the camera, metres; 0 without one.
fn first_mirror_distance(mirror: u32) -> f32 {
    return bitcast<f32>(((mirror & ~MIRROR_BIT) >> DISTANCE_SHIFT) << DISTANCE_SHIFT);
}

/// Normal of a mirror.
fn first_mirror_normal(mirror: u32) -> vec3f {
    let most = (1u << NORMAL_BITS) - 1u;
    let numbers = vec2f(vec2u(mirror >> NORMAL_BITS, mirror) & vec2u(most));
    return from_octahedral(numbers / f32(most) * 2.0 - 1.0);
}
