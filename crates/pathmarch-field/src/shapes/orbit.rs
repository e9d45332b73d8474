//! Functions shared by fractals: orbits and their traps, and estimates clipped to a simple bounding solid.
//!
//! A fractal iterates one step on a state whose first three numbers are the point z: the orbit of the point. The step is
//! written once; the distance and the traps both iterate it.
//!
//! Why a fractal's distance is safe: it is a continuous function f that is negative in the solid and positive outside. If
//! |∇f| is at most L, then f/L is at most the distance to the surface (the argument of Hart 1996, section 2.2), whatever
//! f was derived from. So each file has to show two things: that f has no jumps, and L. Where L was measured and not
//! derived, f is divided by a constant above what was measured, so that it has slope one and does not shorten the steps
//! to other shapes of a scene. The figures in the files are those of the search in `tests/fractals.rs` with that constant
//! at one and 3,000 sets of parameters; the test repeats it with 300 and the constant in its place.

use crate::number::{Real, Vec3};
use crate::ray_interval::T_MAX;
use crate::shapes::TRAPS;

/// Intersection of the solids of `estimate` and `bound`; far outside only the latter.
///
/// More than `reach` metres outside the bound, the result does not depend on the estimate, so that its iteration may stop
/// ([`is_near`]). If both have a slope of at most one, so has the result, and it is continuous.
#[inline(always)]
pub(crate) fn within<N: Real>(estimate: N, bound: N, reach: N) -> N {
    bound.max(estimate.min(reach + reach - bound))
}

/// Reports whether [`within`] uses the estimate.
#[inline(always)]
pub(crate) fn is_near<N: Real>(bound: N, reach: N) -> N::Mask {
    bound.lt(reach)
}

/// Divides `value` by one plus `amount`, which is zero where the value is.
///
/// In a quotient f = g/D of a distance g after the iteration and a derivative D, |∇f| is at most |∇g|/D + g |∇D|/D². The first
/// term is at most one, the second proportional to g: g/(1 + b |g|) limits it to 1/b of what multiplies g, and leaves g as
/// it is near the surface, where dividing by a constant would make every step shorter.
#[inline(always)]
pub(crate) fn bent<N: Real>(value: N, amount: N) -> N {
    value / (N::one() + amount)
}

/// Strength of [`bent`] inside, where the derivative varies most.
const INSIDE_BEND: f32 = 16.0;

/// Distance estimate of the escape set of a map of degree n, from its potential.
///
/// The potential of Douady and Hubbard 1984, G = lim n^-k ln |z_k|, is zero on the set, and G / |∇G| = |z| ln |z| / |z'|
/// (Hart et al. 1989, section 3) is to first order the distance, of which half is a lower bound near a connected set.
/// Here after N iterations the solid is |z_N| < R, with R the radius beyond which every orbit escapes, so that the set
/// for any N is within the one for a smaller N: ln R is taken off. An orbit that has escaped after k < N iterations only
/// multiplies its logarithm by n in each further one, so `offset` is n^(k-N) ln R, and the result does not tell when
/// the iteration was stopped. Below 1/e the length is kept there, where its product with the logarithm is least.
/// `shrink` is 1/|z'|.
#[inline(always)]
pub(crate) fn from_potential<N: Real>(length: N, offset: N, shrink: N) -> N {
    let length = length.max(N::constant(0.367_879_44));
    let value = N::constant(0.5) * (length.ln() - offset) * length;
    bent(value, N::constant(INSIDE_BEND) * (-value).max(N::zero())) * shrink
}

/// Sorts three coordinates, the largest first: the mirrors across the diagonals of a cube.
///
/// Sorted by masks, not by max and min, which would both take the derivative of one side where two are equal.
#[inline(always)]
pub(crate) fn descending<N: Real>([x, y, z]: [N; 3]) -> Vec3<N> {
    let pair = |a: N, b: N| {
        let swap = a.lt(b);
        (N::select(swap, b, a), N::select(swap, a, b))
    };
    let (x, y) = pair(x, y);
    let (y, z) = pair(y, z);
    let (x, y) = pair(x, y);
    Vec3::new(x, y, z)
}

/// Iterates an orbit and returns its traps about `centre`; see [`ShapeDef::orbit`](super::ShapeDef::orbit).
///
/// `T` is `K + TRAPS`, the state and the traps side by side.
#[inline(always)]
pub(crate) fn traps<N: Real, const K: usize, const T: usize>(
    centre: Vec3<N>,
    iterations: N,
    limit: u32,
    start: [N; K],
    step: impl Fn([N; K]) -> ([N; K], N::Mask),
) -> [N; TRAPS] {
    const { assert!(T == K + TRAPS) };
    let farthest = N::constant(T_MAX);
    let state: [N; T] = std::array::from_fn(|k| match k {
        _ if k < K => start[k],
        _ if k >= T - 2 => N::zero(),
        _ => farthest,
    });
    let state = N::iterate(iterations, limit, state, |state| {
        let (next, go_on) = step(std::array::from_fn(|k| state[k]));
        let z = Vec3::new(next[0] - centre.x, next[1] - centre.y, next[2] - centre.z);
        let length = z.length();
        let near = [length, z.x.hypot(z.z), z.y.abs(), (length - N::one()).abs()];
        let next = std::array::from_fn(|k| match k {
            _ if k < K => next[k],
            _ if k == T - 1 => state[k] + N::one(),
            _ if k == T - 2 => state[k].max(length),
            _ => state[k].min(near[k - K]),
        });
        (next, go_on)
    });
    let mut traps: [N; TRAPS] = std::array::from_fn(|k| state[K + k]);
    traps[TRAPS - 1] = traps[TRAPS - 1] / iterations.floor();
    traps
}
