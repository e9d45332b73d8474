//! Intersection: the farther of two (Ricci 1973); the quadratic smooth maximum (Quilez 2013). A lower bound of the
//! distance outside.

use super::union::{blend, weight};
use crate::bounds::Aabb;
use crate::number::Real;
use crate::registry::{Info, Operator};

pub(crate) struct Op;

impl Operator for Op {
    const INFO: Info = Info {
        exact: false,
        ..Info::new("intersect", "What all of the children hold.", "Ricci 1973; Quilez 2013, quadratic smooth minimum")
    };

    #[inline(always)]
    fn sharp<N: Real>(a: N, b: N) -> N {
        a.max(b)
    }
    #[inline(always)]
    fn smooth<N: Real>(a: N, b: N, width: N) -> N {
        let h = blend(a, b, width).named("h");
        a.max(b) + h * h * width * N::constant(0.25)
    }
    #[inline(always)]
    fn sharp_weight<N: Real>(a: N, b: N) -> N {
        N::select(a.lt(b), N::one(), N::zero())
    }
    #[inline(always)]
    fn smooth_weight<N: Real>(a: N, b: N, width: N) -> N {
        weight(-a, -b, width)
    }
    fn bounds(a: Aabb, b: Aabb, _width: f32) -> Aabb {
        a.intersection(b)
    }
}
