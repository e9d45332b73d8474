//! Courses of bricks on the sides of a wall, y up, or on a floor: projected along the axis that is nearest to the normal.
//! Mortar is 0; a brick is 1 or, each by its own random number, less (Ebert et al. 2003, chapter 2).

use super::noise::{random, smoothstep};
use super::{Param, SEED, Spot, TextureKind, TextureParameters};
use glam::Vec3;

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
    value,
    wgsl: include_str!("brick.wgsl"),
};

fn value(spot: &Spot, &[length, height, mortar, shift, variation, seed, ..]: &TextureParameters) -> f32 {
    let n = spot.normal.abs();
    let on_floor = n.y > n.x.max(n.z);
    let along = if !on_floor && n.x > n.z { spot.p.z } else { spot.p.x };
    let up = if on_floor { spot.p.z } else { spot.p.y };
    // A hair beside the origin, as a checker.
    let course = (up / height + 0.001).floor();
    let row_shift = course * shift;
    let place = along / length + 0.001 + (row_shift - row_shift.floor());
    let brick = place.floor();
    // Metres from the nearest edge of the brick's cell.
    let across = 0.5 * length - ((place - brick - 0.5) * length).abs();
    let above = 0.5 * height - ((up / height + 0.001 - course - 0.5) * height).abs();
    let edge = across.min(above);
    let own = 1.0 - variation * random(Vec3::new(brick, course, 0.0), seed as u32).x;
    let half = 0.5 * mortar.max(1e-6);
    own * smoothstep(0.7 * half, 1.5 * half, edge)
}
