//! Elongation: space is cut at the origin and a straight piece is put in (Quilez 2019, "Distance functions", elongation).
//! The map of points takes each to the nearest of a box, whose complement it keeps: it never enlarges distances.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::modifiers::ModifierDef;
use crate::number::{Real, Vec3};
use crate::parameter::Param;

pub(crate) struct Op;

impl ModifierDef for Op {
    const INFO: Info = Info {
        exact: false,
        size_params: 3,
        ..Info::new(
            "elongate",
            "What it holds, cut in the middle, drawn apart, and straight between.",
            "Quilez 2019, elongation",
        )
    };
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
        // The piece is there only where the middle is solid; a box that has no part of it moves.
        Aabb {
            min: std::array::from_fn(|k| inside.min[k] - 0.5 * params[k]),
            max: std::array::from_fn(|k| inside.max[k] + 0.5 * params[k]),
        }
    }
}
