//! Union: the minimum of two distances (Ricci 1973), blended with any profile of [`crate::blend`]. A lower bound of the
//! distance inside.

use crate::blend::{Blend, Blending, minimum, weight};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::Real;
use crate::operators::{Boolean, OperatorDef};

pub(crate) struct Op;

/// Source of the sharp operators and their blends.
pub(super) const SOURCE: &str = "Ricci 1973; blends: Quilez 2013, quadratic smooth minimum, and Mercury 2015";

impl OperatorDef for Op {
    const INFO: Info = Info::new("union", "Union of all children.", SOURCE).inexact();
    const BOOLEAN: Option<Boolean> = Some(Boolean::Union);

    #[inline(always)]
    fn sharp<N: Real>(a: N, b: N) -> N {
        a.min(b)
    }
    #[inline(always)]
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        minimum(a, b, blend)
    }
    #[inline(always)]
    fn sharp_weight<N: Real>(a: N, b: N) -> N {
        N::select(b.lt(a), N::one(), N::zero())
    }
    #[inline(always)]
    fn blended_weight<N: Real>(a: N, b: N, blend: Blending<N>) -> N {
        weight(a, b, blend.amount)
    }
    fn bounds(a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb {
        a.union(b).expanded(blend.map_or(0.0, Blend::reach))
    }
}
