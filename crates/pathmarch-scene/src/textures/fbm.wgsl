// Clouds. Twin of fbm.rs.

fn fbm_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    return 0.5 + 0.8 * k[3] * lattice_octaves(spot.p / k[0], k[1], k[2], u32(k[4]));
}
