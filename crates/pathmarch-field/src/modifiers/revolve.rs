//! Revolution about y (Quilez 2008, "Distance functions", revolution): the child is evaluated in the plane z = 0, where
//! x is the distance from the axis less an offset, so that the y axis of the profile is `offset` off the axis. Parts of the
//! profile beyond the axis do not appear, but still limit the distance: a lower bound.
//!
//! A solid is replaced by its slice at z = 0, whose distance in the plane is never below that in space.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new(
            "revolve",
            "A profile turned about the y axis, as on a lathe; of a solid, its slice at z = 0.",
            "Quilez 2008, revolution",
        ).inexact();
    const PARAMS: &'static [Param] =
        &[Param::length_or_zero("offset", 0.0, "From the axis to the origin of the profile.")];
    type Coefficients<N: Real> = [N; 1];
    const OF_PROFILES: bool = true;

    fn coefficients(params: &[f32], _inside: Aabb) -> [f32; 1] {
        [params[0]]
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, _place: N, [offset]: [N; 1]) -> Vec3<N> {
        Vec3::new(p.x.hypot(p.z) - offset, p.y, N::zero())
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        let radius = (inside.max[0] + params[0]).max(0.0);
        Aabb { min: [-radius, inside.min[1], -radius], max: [radius, inside.max[1], radius] }
    }
}
