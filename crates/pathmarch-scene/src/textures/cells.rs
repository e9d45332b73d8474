//! Cells around random points, each of a value of its own (Worley 1996): mosaics, flagstones, lizards.

use super::noise::{TextureNumber, nearest_points};
use super::{JITTER, Param, Place, SEED, TextureKind, TextureParameters};
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "cells",
    doc: "Cells around scattered points, each of one random value.",
    source: "Worley 1996",
    params: &[Param::length("size", 0.2, "Of a cell."), JITTER, SEED],
    step: |[size, ..]| 0.01 * size,
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("cells.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(place: &Place<N>, &[size, jitter, seed, ..]: &TextureParameters) -> N {
    let (_, _, cell) = nearest_points(place.p / N::constant(size), jitter, seed as u32);
    N::random(cell, (seed as u32).wrapping_add(1)).x
}
