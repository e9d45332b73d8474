//! Subtraction: the first child without the others (Ricci 1973), which is minus the union of the complement of `a` and `b`,
//! blended with any profile of [`crate::blend`]. A lower bound of the distance outside, exact inside the kept part.

use crate::blend::{Blend, Blending, minimum, weight};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::Real;
use crate::operators::{Boolean, OperatorDef};
use super::union::SOURCE;

pub(crate) struct Op;

impl OperatorDef for Op {
    const INFO: Info =
        Info::new("subtract", "The first child without the others.", SOURCE).inexact();
    const CHILDREN: (usize, usize) = (2, usize::MAX);
    const BOOLEAN: Option<Boolean> = Some(Boolean::Difference);

    #[inline(always)]
    fn sharp<N: Real>(a: N, b: N) -> N {
        a.max(-b)
    }
    #[inline(always)]
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        -minimum(-a, b, blend)
    }
    #[inline(always)]
    fn sharp_weight<N: Real>(a: N, b: N) -> N {
        N::select(a.lt(-b), N::one(), N::zero())
    }
    #[inline(always)]
    fn blended_weight<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        weight(-a, b, blend.amount)
    }
    fn bounds(a: Aabb, _b: Aabb, _blend: Option<Blend>) -> Aabb {
        a
    }
}
