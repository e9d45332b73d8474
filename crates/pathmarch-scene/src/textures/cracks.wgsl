// Borders between cells. Twin of cracks.rs.

fn cracks_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    let found = nearest_points(spot.p / k[0], k[2], u32(k[3]));
    return smoothstep(0.0, 1.0, (found.second - found.first) * k[0] / k[1]);
}
