//! The distance to the nearest of random points, of cells that fill space (Worley 1996): bubbles, pebbles, hammered metal.

use super::noise::{TextureNumber, nearest_points};
use super::{JITTER, Param, Place, SEED, TextureKind, TextureParameters};
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "voronoi",
    doc: "Cells: the distance to the nearest of scattered points, 0 at each.",
    source: "Worley 1996",
    params: &[Param::length("size", 0.2, "Distance from point to point."), JITTER, SEED],
    step: |[size, ..]| 0.01 * size,
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("voronoi.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(place: &Place<N>, &[size, jitter, seed, ..]: &TextureParameters) -> N {
    nearest_points(place.p / N::constant(size), jitter, seed as u32).0
}
