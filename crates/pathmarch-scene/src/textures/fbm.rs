//! Clouds: octaves of gradient noise, each finer and weaker (fractional Brownian motion; Musgrave in Ebert et al. 2003,
//! chapter 16).

use super::noise::{TextureNumber, octaves};
use super::{GAIN, OCTAVES, Param, Place, SEED, TextureKind, TextureParameters};
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "fbm",
    doc: "Clouds: noise with ever finer detail.",
    source: "Perlin 1985 and 2002; Ebert et al. 2003",
    params: &[
        Param::length("size", 0.2, "Of the largest features."),
        OCTAVES,
        GAIN,
        Param::between(
            "contrast",
            1.0,
            0.0,
            100.0,
            "0 is flat, 1 mostly between the ends, above it has areas of both.",
        ),
        SEED,
    ],
    step: |[size, octaves, ..]| 0.05 * size * 0.5f32.powf(octaves - 1.0),
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("fbm.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(
    place: &Place<N>,
    &[size, count, gain, contrast, seed, ..]: &TextureParameters,
) -> N {
    let noise = octaves(place.p / N::constant(size), count, gain, seed as u32);
    N::constant(0.5) + noise * N::constant(0.8 * contrast)
}
