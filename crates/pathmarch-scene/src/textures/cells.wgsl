// Cells of one value each. Twin of cells.rs.

fn cells_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    let seed = u32(k[2]);
    return lattice_random(nearest_points(spot.p / k[0], k[1], seed).owner, seed + 1u).x;
}
