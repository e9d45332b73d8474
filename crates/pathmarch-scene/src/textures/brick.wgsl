// Bricks in mortar. Twin of brick.rs.

fn brick_texture(spot: Spot, k: array<f32, 8>) -> f32 {
    let length_ = k[0];
    let height = k[1];
    let n = abs(spot.normal);
    let on_floor = n.y > max(n.x, n.z);
    let along = select(spot.p.x, spot.p.z, !on_floor && n.x > n.z);
    let up = select(spot.p.y, spot.p.z, on_floor);
    let course = floor(up / height + 0.001);
    let row_shift = course * k[3];
    let place = along / length_ + 0.001 + (row_shift - floor(row_shift));
    let brick = floor(place);
    let across = 0.5 * length_ - abs((place - brick - 0.5) * length_);
    let above = 0.5 * height - abs((up / height + 0.001 - course - 0.5) * height);
    let own = 1.0 - k[4] * lattice_random(vec3f(brick, course, 0.0), u32(k[5])).x;
    let half_ = 0.5 * max(k[2], 1e-6);
    return own * smoothstep(0.7 * half_, 1.5 * half_, min(across, above));
}
