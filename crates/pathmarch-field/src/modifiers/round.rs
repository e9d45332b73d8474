//! Rounding: offsets the surface outwards, which rounds edges (Quilez 2008, "Distance functions", rounding). Distances that are
//! exact outside stay exact there.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new("round", "Thickens its child on every side and rounds its edges.", "Quilez 2008, rounding");
    const PARAMS: &'static [Param] = &[Param::length_or_zero("radius", 0.1, "How far the surface moves outwards.")];
    type Coefficients<N: Real> = [N; 1];

    fn coefficients(params: &[f32], _inside: Aabb) -> [f32; 1] {
        [params[0]]
    }
    #[inline(always)]
    fn distance<N: Real>(_p: Vec3<N>, inside: N, [radius]: [N; 1]) -> N {
        inside - radius
    }
    fn inner_margin(params: &[f32], _inside: Aabb, margin: f32) -> Option<f32> {
        Some(margin + params[0])
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        inside.expanded(params[0])
    }
}
