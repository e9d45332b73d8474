//! The distance to the nearest of random points, of cells that fill space (Worley 1996): bubbles, pebbles, hammered metal.

use super::noise::nearest_points;
use super::{JITTER, Param, SEED, Spot, TextureKind, TextureParameters};

pub(super) static KIND: TextureKind = TextureKind {
    name: "voronoi",
    doc: "Cells: the distance to the nearest of scattered points, 0 at each.",
    source: "Worley 1996",
    params: &[Param::length("size", 0.2, "Distance from point to point."), JITTER, SEED],
    step: |[size, ..]| 0.01 * size,
    value,
    wgsl: include_str!("voronoi.wgsl"),
};

fn value(spot: &Spot, &[size, jitter, seed, ..]: &TextureParameters) -> f32 {
    nearest_points(spot.p / size, jitter, seed as u32).0
}
