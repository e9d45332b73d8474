//! Union: the nearer of two (Ricci 1973). Blended by the quadratic polynomial smooth minimum (Quilez 2013,
//! "Smooth minimum", quadratic), whose gradient is a convex mix of both, so that the Lipschitz constant is kept.
//! The blend reaches `width` metres of difference and adds at most `width`/4 to the solid.

use crate::bounds::Aabb;
use crate::number::Real;
use crate::registry::{Info, Operator};

pub(crate) struct Op;

/// The part of the quadratic blend shared by all three operators: `h` in 0..1, one where both distances are equal.
#[inline(always)]
pub(super) fn blend<N: Real>(a: N, b: N, width: N) -> N {
    (N::one() - (a - b).abs() / width.max(N::constant(1e-6))).max(N::zero())
}

/// How much of `b` there is in the quadratic minimum of `a` and `b`.
#[inline(always)]
pub(super) fn weight<N: Real>(a: N, b: N, width: N) -> N {
    let half = blend(a, b, width) * N::constant(0.5);
    N::select(b.lt(a), N::one() - half, half)
}

impl Operator for Op {
    const INFO: Info = Info {
        exact: false,
        ..Info::new("union", "What any of the children holds.", "Ricci 1973; Quilez 2013, quadratic smooth minimum")
    };

    #[inline(always)]
    fn sharp<N: Real>(a: N, b: N) -> N {
        a.min(b)
    }
    #[inline(always)]
    fn smooth<N: Real>(a: N, b: N, width: N) -> N {
        // In this order |b - a| and the minimum take the same side where both are equal, so that their derivatives agree.
        let h = blend(b, a, width).named("h");
        a.min(b) - h * h * width * N::constant(0.25)
    }
    #[inline(always)]
    fn sharp_weight<N: Real>(a: N, b: N) -> N {
        N::select(b.lt(a), N::one(), N::zero())
    }
    #[inline(always)]
    fn smooth_weight<N: Real>(a: N, b: N, width: N) -> N {
        weight(a, b, width)
    }
    fn bounds(a: Aabb, b: Aabb, width: f32) -> Aabb {
        a.union(b).expanded(0.25 * width)
    }
}
