// Veins across x. Twin of marble.rs.

fn marble_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    let q = spot.p / k[0];
    let place = q.x + k[1] * lattice_octaves(q, k[3], 0.5, u32(k[4]));
    let part = place - floor(place) - 0.5;
    return pow(max(abs(cos(3.14159265 * part)), 1e-6), k[2]);
}
