// Pixels of the lanes of a workgroup.

/// Pixel of a lane in the 8x8 pixels of its workgroup. Eight consecutive lanes, which software adapters run together, are a tile
/// of 4x2 pixels and not a row: their rays diverge later. Thirty-two lanes are 8x4 pixels either way.
fn place_of_lane(lane: u32) -> vec2u {
    return vec2u((lane & 3u) | ((lane >> 1u) & 4u), ((lane >> 2u) & 1u) | ((lane >> 3u) & 6u));
}
