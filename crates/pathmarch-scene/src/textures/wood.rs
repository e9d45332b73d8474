//! A trunk along y: rings about the axis, wide and light early in a year, thin and dark late, bent by noise, and fibres along
//! them (after Peachey 1985, "Solid Texturing of Complex Surfaces", and Ebert et al. 2003, chapter 2).

use super::noise::{noise, smoothstep};
use super::{Param, SEED, Spot, TextureKind, TextureParameters};
use glam::Vec3;

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
    value,
    wgsl: include_str!("wood.wgsl"),
};

fn value(spot: &Spot, &[size, waviness, fibres, seed, ..]: &TextureParameters) -> f32 {
    let seed = seed as u32;
    let q = spot.p / size;
    let wide = noise(q * Vec3::new(0.15, 0.02, 0.15), seed);
    let narrow = noise(q * Vec3::new(0.6, 0.06, 0.6), seed.wrapping_add(1));
    let radius = Vec3::new(q.x, 0.0, q.z).length() + waviness * (2.0 * wide + 0.5 * narrow);
    let year = radius.floor();
    let within = radius - year;
    let late = smoothstep(0.25, 0.85, within) * (1.0 - smoothstep(0.9, 1.0, within));
    // Some years are darker than others.
    let ring = late * (0.6 + 0.4 * noise(Vec3::new(0.31 * radius, 0.5, 0.5), seed.wrapping_add(2)));
    let fibre = 0.5 + noise(q * Vec3::new(6.0, 0.12, 6.0), seed.wrapping_add(3));
    (ring + (fibre - ring) * fibres).clamp(0.0, 1.0)
}
