// Distance to scattered points. Twin of voronoi.rs.

fn voronoi_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    return nearest_points(spot.p / k[0], k[1], u32(k[2])).first;
}
