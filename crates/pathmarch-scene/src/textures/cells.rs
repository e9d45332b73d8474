//! Cells around random points, each of a value of its own (Worley 1996): mosaics, flagstones, lizards.

use super::noise::{nearest_points, random};
use super::{JITTER, Param, SEED, Spot, TextureKind, TextureParameters};

pub(super) static KIND: TextureKind = TextureKind {
    name: "cells",
    doc: "Cells around scattered points, each of one random value.",
    source: "Worley 1996",
    params: &[Param::length("size", 0.2, "Of a cell."), JITTER, SEED],
    step: |[size, ..]| 0.01 * size,
    value,
    wgsl: include_str!("cells.wgsl"),
};

fn value(spot: &Spot, &[size, jitter, seed, ..]: &TextureParameters) -> f32 {
    let (_, _, cell) = nearest_points(spot.p / size, jitter, seed as u32);
    random(cell, (seed as u32).wrapping_add(1)).x
}
