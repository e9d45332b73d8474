//! Morph: interpolation between the distances of two shapes (Payne and Toga 1992, "Distance field manipulation of surface models",
//! section 4). The gradient is a mean of both, so that the Lipschitz constant is kept. Points outside of both shapes are outside
//! of every shape between them. Nothing appears between shapes that are far apart: they should overlap.

use crate::blend::{Blend, Blending};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::Real;
use crate::operators::OperatorDef;
use crate::parameter::Param;

pub(crate) struct Op;

impl OperatorDef for Op {
    const INFO: Info = Info::new("morph", "A shape between two.", "Payne and Toga 1992, section 4").inexact();
    const PARAMS: &'static [Param] =
        &[Param::between("amount", 0.5, 0.0, 1.0, "0 is the first child, 1 the second; materials change with it.")];
    const BLENDS: bool = false;
    const CHILDREN: (usize, usize) = (2, 2);

    #[inline(always)]
    fn sharp<N: Real>(a: N, _b: N) -> N {
        a
    }
    #[inline(always)]
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        a * (N::one() - blend.amount) + b * blend.amount
    }
    #[inline(always)]
    fn sharp_weight<N: Real>(_a: N, _b: N) -> N {
        N::zero()
    }
    #[inline(always)]
    fn blended_weight<N: Real>(_a: N, _b: N, blend: Blending<N>) -> N {
        blend.amount
    }
    fn bounds(a: Aabb, b: Aabb, _blend: Option<Blend>) -> Aabb {
        a.union(b)
    }
}
