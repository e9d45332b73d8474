//! Veins across x, bent by octaves of noise (Perlin 1985, "An Image Synthesizer").

use super::noise::octaves;
use super::{OCTAVES, Param, SEED, Spot, TextureKind, TextureParameters};
use std::f32::consts::PI;

pub(super) static KIND: TextureKind = TextureKind {
    name: "marble",
    doc: "Veins across x: 1 in the middle of a vein, 0 far from it.",
    source: "Perlin 1985",
    params: &[
        Param::length("size", 0.3, "From vein to vein."),
        Param::between("turbulence", 1.2, 0.0, 20.0, "How far veins stray, in distances from one to the next."),
        Param::between("sharpness", 4.0, 0.1, 100.0, "Larger makes veins thinner."),
        OCTAVES,
        SEED,
    ],
    step: |[size, _, _, octaves, ..]| 0.05 * size * 0.5f32.powf(octaves - 1.0),
    value,
    wgsl: include_str!("marble.wgsl"),
};

fn value(spot: &Spot, &[size, turbulence, sharpness, count, seed, ..]: &TextureParameters) -> f32 {
    let q = spot.p / size;
    let place = q.x + turbulence * octaves(q, count, 0.5, seed as u32);
    // Within a quarter turn, where the sine is as exact on every device.
    let part = place - place.floor() - 0.5;
    (PI * part).cos().abs().max(1e-6).powf(sharpness)
}
