//! Displacement by a wave in all three directions (Quilez 2008, "Distance functions", displacement): the surface moves by
//! amplitude · sin(ωx) sin(ωy) sin(ωz), whose slope is at most amplitude · ω. The sum of both is divided by one more than that,
//! which keeps a bound. Far from the solid the distance to its bounding box is the better bound; the larger one is used.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use std::f32::consts::TAU;
use super::bounding_box::{box_distance, corners};

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new("displace", "Displaces the surface of its child in and out by a wave.", "Quilez 2008, displacement").inexact();
    const PARAMS: &'static [Param] = &[
        Param::length_or_zero("amplitude", 0.05, "How far the surface moves, to either side."),
        Param::length("frequency", 2.0, "Waves in a metre.").with_unit(crate::parameter::Unit::Ratio),
    ];
    type Coefficients<N: Real> = [N; 9];

    fn coefficients(params: &[f32], inside: Aabb) -> [f32; 9] {
        let [a, b, c, d, e, f] = corners(Self::bounds(params, inside));
        let rate = TAU * params[1];
        [params[0], rate, 1.0 / (1.0 + params[0] * rate), a, b, c, d, e, f]
    }
    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, inside: N, [amplitude, rate, squeeze, a, b, c, d, e, f]: [N; 9]) -> N {
        let wave = (p.x * rate).sin() * (p.y * rate).sin() * (p.z * rate).sin();
        ((inside + amplitude * wave) * squeeze).max(box_distance(p, [a, b, c, d, e, f]))
    }
    fn inner_margin(params: &[f32], _inside: Aabb, margin: f32) -> Option<f32> {
        Some(margin * (1.0 + params[0] * TAU * params[1]) + params[0])
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        inside.expanded(params[0])
    }
}
