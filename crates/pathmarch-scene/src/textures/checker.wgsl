// Cubes of two values. Twin of checker.rs.

fn checker_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    let cell = floor(spot.p / k[0] + 0.001);
    let sum = cell.x + cell.y + cell.z;
    return sum - 2.0 * floor(0.5 * sum);
}
