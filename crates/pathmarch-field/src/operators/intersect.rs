//! Intersection: the maximum of two distances (Ricci 1973), which is minus the union of both complements, blended with any
//! profile of [`crate::blend`]. A lower bound of the distance outside.

use crate::blend::{Blend, Blending, minimum, weight};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::Real;
use crate::operators::{Boolean, OperatorDef};
use super::union::SOURCE;

pub(crate) struct Op;

impl OperatorDef for Op {
    const INFO: Info = Info::new("intersect", "Intersection of all children.", SOURCE).inexact();
    const BOOLEAN: Option<Boolean> = Some(Boolean::Intersection);

    #[inline(always)]
    fn sharp<N: Real>(a: N, b: N) -> N {
        a.max(b)
    }
    #[inline(always)]
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        -minimum(-a, -b, blend)
    }
    #[inline(always)]
    fn sharp_weight<N: Real>(a: N, b: N) -> N {
        N::select(a.lt(b), N::one(), N::zero())
    }
    #[inline(always)]
    fn blended_weight<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        weight(-a, -b, blend.amount)
    }
    fn bounds(a: Aabb, b: Aabb, _blend: Option<Blend>) -> Aabb {
        a.intersection(b)
    }
}
