//! Shell: a wall along the surface, half of it on either side (Quilez 2008, "Distance functions", onion).

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new("shell", "Wall along the surface of its child, hollow inside.", "Quilez 2008, onion");
    const PARAMS: &'static [Param] = &[Param::length("thickness", 0.05, "Thickness of the wall, half of it outside.")];
    type Coefficients<N: Real> = [N; 1];

    fn coefficients(params: &[f32], _inside: Aabb) -> [f32; 1] {
        [params[0]]
    }
    #[inline(always)]
    fn distance<N: Real>(_p: Vec3<N>, inside: N, [thickness]: [N; 1]) -> N {
        inside.abs() - thickness * N::constant(0.5)
    }
    fn inner_margin(params: &[f32], _inside: Aabb, margin: f32) -> Option<f32> {
        Some(margin + 0.5 * params[0])
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        inside.expanded(0.5 * params[0])
    }
}
