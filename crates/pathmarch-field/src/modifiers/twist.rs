//! Twist about the y axis (Barr 1984, "Global and local deformations of solid primitives", section 3).
//!
//! A point at the distance r from the axis is turned by an angle in proportion to its height. The map is a shear of slope
//! a = 2π turns r, whose largest stretch is (a + √(a² + 4)) / 2. Points outside of the bounding cylinder are first
//! moved to it, which moves no two points apart and none away from the solid; then the distance over the stretch at the
//! cylinder is a bound. Far from the solid the distance to its bounding box is the better bound; the larger one is used.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use std::f32::consts::TAU;
use super::bounding_box::{box_distance, corners, reach};

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new("twist", "Twists its child about the y axis, in proportion to the height.", "Barr 1984, section 3").inexact();
    const PARAMS: &'static [Param] = &[Param::between("turns-per-metre", 0.25, -1000.0, 1000.0, "Turns over a metre of height, right-handed about y.")];
    type Coefficients<N: Real> = [N; 9];
    const NEEDS_BOUNDS: bool = true;
    const IN_PLANE: bool = false;

    fn coefficients(params: &[f32], inside: Aabb) -> [f32; 9] {
        let [a, b, c, d, e, f] = corners(Self::bounds(params, inside));
        let (rate, reach) = (TAU * params[0], reach(inside, 0, 2));
        let slope = (rate * reach).abs();
        [rate, reach, 2.0 / (slope + (slope * slope + 4.0).sqrt()), a, b, c, d, e, f]
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, _place: N, [rate, reach, ..]: [N; 9]) -> Vec3<N> {
        let shrink = (reach / p.x.hypot(p.z).max(reach)).named("shrink");
        let turn = (p.y * rate).named("turn");
        let (sine, cosine) = ((turn.sin() * shrink).named("sine"), (turn.cos() * shrink).named("cosine"));
        Vec3::new(p.x * cosine - p.z * sine, p.y, p.x * sine + p.z * cosine)
    }
    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, inside: N, [_, _, squeeze, a, b, c, d, e, f]: [N; 9]) -> N {
        (inside * squeeze).max(box_distance(p, [a, b, c, d, e, f]))
    }
    fn inner_margin(params: &[f32], inside: Aabb, margin: f32) -> Option<f32> {
        let [_, _, squeeze, ..] = Self::coefficients(params, inside);
        Some(margin / squeeze)
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        if params[0] == 0.0 {
            return inside;
        }
        let radius = reach(inside, 0, 2);
        Aabb { min: [-radius, inside.min[1], -radius], max: [radius, inside.max[1], radius] }
    }
}
