//! Elongation: cuts space at the origin and inserts a straight piece (Quilez 2019, "Distance functions", elongation).
//! The map moves each point by its nearest point of a box and never enlarges distances.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info::new(
            "elongate",
            "Cuts its child in the middle, moves the parts apart and joins them straight.",
            "Quilez 2019, elongation",
        ).inexact().size_params(3);
    const PARAMS: &'static [Param] = &[
        Param::length_or_zero("x", 0.5, "Length of the straight piece along x."),
        Param::length_or_zero("y", 0.0, "Length of the straight piece along y."),
        Param::length_or_zero("z", 0.0, "Length of the straight piece along z."),
    ];
    type Coefficients<N: Real> = [N; 3];

    fn coefficients(params: &[f32], _inside: Aabb) -> [f32; 3] {
        [params[0], params[1], params[2]]
    }
    #[inline(always)]
    fn point<N: Real>(p: Vec3<N>, _place: N, [x, y, z]: [N; 3]) -> Vec3<N> {
        let apart = |v: N, length: N| {
            let half = length * N::constant(0.5);
            v - v.clamp(-half, half)
        };
        Vec3::new(apart(p.x, x), apart(p.y, y), apart(p.z, z))
    }
    fn bounds(params: &[f32], inside: Aabb) -> Aabb {
        // The piece exists only where the middle is solid; a box beside it moves.
        Aabb {
            min: std::array::from_fn(|k| inside.min[k] - 0.5 * params[k]),
            max: std::array::from_fn(|k| inside.max[k] + 0.5 * params[k]),
        }
    }
}
