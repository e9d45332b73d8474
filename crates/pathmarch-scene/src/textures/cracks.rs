//! The borders between cells around random points (Worley 1996, F2 - F1): dry mud, scales, glaze.

use super::noise::{TextureNumber, nearest_points, smoothstep};
use super::{JITTER, Param, Place, SEED, TextureKind, TextureParameters};
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "cracks",
    doc: "Borders between cells: 0 in a crack, 1 on the cells.",
    source: "Worley 1996",
    params: &[Param::length("size", 0.2, "Of a cell."), Param::length("width", 0.02, "Of the cracks."), JITTER, SEED],
    step: |[size, width, ..]| 0.05 * size.min(*width),
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("cracks.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(place: &Place<N>, &[size, width, jitter, seed, ..]: &TextureParameters) -> N {
    let (first, second, _) = nearest_points(place.p / N::constant(size), jitter, seed as u32);
    smoothstep(0.0, 1.0, (second - first) * N::constant(size) / N::constant(width))
}
