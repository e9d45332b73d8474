//! Extrusion along z (Quilez 2008, "Distance functions", extrusion): the child is evaluated in the plane z = 0 and
//! cut by two planes across z. The distance of a prism is that of a box in the coordinates (distance in the plane, distance to
//! the ends): exact if that of the profile is.
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
        "extrude",
        "A profile drawn out along z, centred at z = 0; of a solid, its slice there.",
        "Quilez 2008, extrusion",
    );
    const PARAMS: &'static [Param] = &[Param::length("height", 1.0, "Length along z, from end to end.")];
    type Coefficients<N: Real> = [N; 1];
    const OF_PROFILES: bool = true;

    fn coefficients(params: &[f32], _inside: Aabb) -> [f32; 1] {
        [0.5 * params[0]]
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, _place: N, _numbers: [N; 1]) -> Vec3<N> {
        Vec3::new(p.x, p.y, N::zero())
    }
    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, inside: N, [half]: [N; 1]) -> N {
        let ends = (p.z.abs() - half).named("ends");
        inside.max(N::zero()).hypot(ends.max(N::zero())) + inside.max(ends).min(N::zero())
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        let half = 0.5 * params[0];
        let ([x, y, _], [xx, yy, _]) = (inside.min, inside.max);
        Aabb { min: [x, y, -half], max: [xx, yy, half] }
    }
}
