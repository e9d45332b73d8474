//! Veins across x, bent by octaves of noise (Perlin 1985, "An Image Synthesizer").

use super::noise::{TextureNumber, octaves};
use super::{OCTAVES, Param, Place, SEED, TextureKind, TextureParameters};
use pathmarch_field::number::unit_circle;
use wide::f32x8;

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
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("marble.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(
    place: &Place<N>,
    &[size, turbulence, sharpness, count, seed, ..]: &TextureParameters,
) -> N {
    let q = place.p / N::constant(size);
    let vein = q.x + octaves(q, count, 0.5, seed as u32) * N::constant(turbulence);
    // Within a quarter turn, where the cosine is as exact on every device.
    let part = vein - vein.floor() - N::constant(0.5);
    let [cosine, _] = unit_circle(part.abs() * N::constant(0.5));
    cosine.abs().max(N::constant(1e-6)).powf(sharpness)
}
