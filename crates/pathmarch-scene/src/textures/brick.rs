//! Courses of bricks on the sides of a wall, y up, or on a floor: projected along the axis that is nearest to the normal.
//! Mortar is 0; a brick is 1 or, each by its own random number, less (Ebert et al. 2003, chapter 2).

use super::noise::{TextureNumber, smoothstep};
use super::{Param, Place, SEED, TextureKind, TextureParameters};
use pathmarch_field::number::Vec3;
use wide::f32x8;

pub(super) static KIND: TextureKind = TextureKind {
    name: "brick",
    doc: "Bricks in mortar: 0 is mortar, bricks are up to 1.",
    source: "Ebert et al. 2003",
    params: &[
        Param::length("length", 0.25, "From brick to brick, mortar included."),
        Param::length("course", 0.075, "From course to course, mortar included."),
        Param::length_or_zero("mortar", 0.012, "Width of the joints."),
        Param::between("shift", 0.5, 0.0, 1.0, "How far each course is shifted against the one below, in bricks."),
        Param::between("variation", 0.4, 0.0, 0.9, "How much bricks differ: they are from 1 less this to 1."),
        SEED,
    ],
    step: |[length, course, mortar, ..]| 0.05 * mortar.max(0.02 * length.min(*course)),
    value: value::<f32>,
    values: value::<f32x8>,
    wgsl: include_str!("brick.wgsl"),
};

#[inline(always)]
fn value<N: TextureNumber>(
    place: &Place<N>,
    &[length, height, mortar, shift, variation, seed, ..]: &TextureParameters,
) -> N {
    let c = N::constant;
    let (p, n) = (place.p, place.normal.abs());
    let on_floor = n.x.max(n.z).lt(n.y);
    let faces_x = !on_floor & n.z.lt(n.x);
    let along = N::select(faces_x, p.z, p.x);
    let up = N::select(on_floor, p.z, p.y);
    // A hair beside the origin, as a checker.
    let course = (up / c(height) + c(0.001)).floor();
    let row_shift = course * c(shift);
    let at = along / c(length) + c(0.001) + (row_shift - row_shift.floor());
    let brick = at.floor();
    // Metres from the nearest edge of the brick's cell.
    let from_edge = |part: N, side: f32| c(0.5 * side) - ((part - c(0.5)) * c(side)).abs();
    let across = from_edge(at - brick, length);
    let above = from_edge(up / c(height) + c(0.001) - course, height);
    let own = N::one() - N::random(Vec3::new(brick, course, N::zero()), seed as u32).x * c(variation);
    let half = 0.5 * mortar.max(1e-6);
    own * smoothstep(0.7 * half, 1.5 * half, across.min(above))
}
