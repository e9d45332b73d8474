// A trunk along y. Twin of wood.rs.

fn wood_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    let seed = u32(k[3]);
    let q = spot.p / k[0];
    let wide = lattice_noise(q * vec3f(0.15, 0.02, 0.15), seed);
    let narrow = lattice_noise(q * vec3f(0.6, 0.06, 0.6), seed + 1u);
    let radius = length(vec3f(q.x, 0.0, q.z)) + k[1] * (2.0 * wide + 0.5 * narrow);
    let within = radius - floor(radius);
    let late = smoothstep(0.25, 0.85, within) * (1.0 - smoothstep(0.9, 1.0, within));
    let ring = late * (0.6 + 0.4 * lattice_noise(vec3f(0.31 * radius, 0.5, 0.5), seed + 2u));
    let fibre = 0.5 + lattice_noise(q * vec3f(6.0, 0.12, 6.0), seed + 3u);
    return clamp(ring + (fibre - ring) * k[2], 0.0, 1.0);
}
