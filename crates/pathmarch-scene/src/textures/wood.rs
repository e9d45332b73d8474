//! A trunk along y: rings about the axis, wide and light early in a year, thin and dark late, bent by noise, and fibres along
//! them (after Peachey 1985, "Solid Texturing of Complex Surfaces", and Ebert et al. 2003, chapter 2).

use super::noise::{TextureNumber, noise, smoothstep};
use super::{Param, Place, SEED, TextureKind, TextureParameters};
use pathmarch_field::number::Vec3;
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "wood",
    doc: "A trunk along y: rings, 1 where they are dark, and fibres.",
    source: "Peachey 1985; Ebert et al. 2003",
    params: &[
        Param::length("size", 0.02, "Width of a ring."),
        Param::between("waviness", 0.6, 0.0, 10.0, "How far rings stray, in rings."),
        Param::between("fibres", 0.35, 0.0, 1.0, "How strong the fibres are against the rings."),
        SEED,
    ],
    step: |[size, ..]| 0.01 * size,
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("wood.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(place: &Place<N>, &[size, waviness, fibres, seed, ..]: &TextureParameters) -> N {
    let c = N::constant;
    let seed = seed as u32;
    let q = place.p / c(size);
    let noise_of = |scale: [f32; 3], number: u32| noise(q.times(Vec3::constant(scale)), seed.wrapping_add(number));
    let [wide, narrow] = [noise_of([0.15, 0.02, 0.15], 0), noise_of([0.6, 0.06, 0.6], 1)];
    let radius = q.x.hypot(q.z) + (wide * c(2.0) + narrow * c(0.5)) * c(waviness);
    let within = radius - radius.floor();
    let late = smoothstep(0.25, 0.85, within) * (N::one() - smoothstep(0.9, 1.0, within));
    // Some years are darker than others.
    let year = noise(Vec3::new(radius * c(0.31), c(0.5), c(0.5)), seed.wrapping_add(2));
    let ring = late * (c(0.6) + year * c(0.4));
    let fibre = c(0.5) + noise_of([6.0, 0.12, 6.0], 3);
    (ring + (fibre - ring) * c(fibres)).clamp(N::zero(), N::one())
}
