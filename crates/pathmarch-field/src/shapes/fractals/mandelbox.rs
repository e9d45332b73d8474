//! Mandelbox: fold at a box, fold at a ball, scale, add the point, repeat.
//!
//! Idea: Lowe 2010. A step mirrors each coordinate that is beyond the fold limit back at it, inverts points in the ball
//! of the fixed radius (in that of the least radius, it scales them by a constant instead), scales by s and adds the
//! first point. The solid is where the orbit has stayed in the ball through the corners of the box that holds the set.
//!
//! Distance: (|z| - R)/D/SLOPE. Both folds are continuous; a mirror keeps lengths and an inversion scales them by m =
//! (fixed/|z|)², so D ← D max(|s| m, 1) + 1 bounds the derivative of z by the first point (Christensen 2011, part VI),
//! and |∇|z||/D is at most one. What is left is the slope of 1/D itself, which the factor m has in the shell between
//! both radii.
//!
//! Bounds: for s < -1 the corner of the set is twice the fold limit, a fixed point of the map; for s > 1 it is 2 (s +
//! 1)/(s - 1) times it. The solid is cut at that box, and at twelve times the limit where it would be larger.
//!
//! Measured: slope of the undivided estimate at most 1.37 with the defaults, 1.79 with any parameters where |scale| is
//! 1.1 or more, and 6.0 below that (where the set is no more than a blob, and the Lipschitz constant says so), by hill
//! climbing from the steepest of 2.4 million random points, over 3,000 random sets of parameters (`tests/fractals.rs`).
//! Without the bend inside it was 5.1 and 52. Cost: about 30 operations for each iteration, no root.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::{Param, Unit};
use crate::shapes::orbit;
use crate::shapes::{ShapeDef, TRAPS};

pub(crate) struct Shape;

/// Largest number of iterations.
const LIMIT: u32 = 20;
/// Strength of [`orbit::bent`] inside, where the derivative varies most.
const BEND: f32 = 48.0;
/// Upper bound of the slope of (|z| - R)/D.
const SLOPE: f32 = 2.0;

/// State: the point and the inverse of the bound D of its derivative, whose slope does not overflow.
type State<N> = [N; 4];

#[derive(Clone, Copy)]
struct Map<N> {
    scale: N,
    fold: N,
    least_square: N,
    fixed_square: N,
    iterations: N,
    half: N,
}

impl<N: Real> Map<N> {
    #[inline(always)]
    fn new([scale, iterations, fold, least, fixed]: [N; 5]) -> Self {
        let least_square = least * least;
        Self { scale, fold, least_square, fixed_square: fixed * fixed, iterations, half: half_edge(scale, fold) }
    }
    /// Outside the bounds, metres.
    #[inline(always)]
    fn bound(&self, p: Vec3<N>) -> N {
        let off = Vec3::new(p.x.abs() - self.half, p.y.abs() - self.half, p.z.abs() - self.half);
        off.max(N::zero()).length() + off.largest().min(N::zero())
    }
    #[inline(always)]
    fn step(&self, [x, y, z, shrink]: State<N>, p: Vec3<N>, near: N::Mask) -> (State<N>, N::Mask) {
        let mirrored = |v: N| v.clamp(-self.fold, self.fold) * N::constant(2.0) - v;
        let z = Vec3::new(mirrored(x), mirrored(y), mirrored(z));
        let inverted = self.fixed_square / z.dot(z).max(self.least_square).min(self.fixed_square);
        let factor = self.scale * inverted;
        let z = z * factor + p;
        ([z.x, z.y, z.z, shrink / (factor.abs().max(N::one()) + shrink)], near)
    }
}

/// Half edge of the bounding box of the set, metres.
fn half_edge<N: Real>(scale: N, fold: N) -> N {
    let (one, two) = (N::one(), N::constant(2.0));
    let positive = (two * (scale + one) / (scale - one).max(N::constant(0.1))).min(N::constant(12.0));
    fold * N::select(scale.lt(N::zero()), two, positive)
}

impl ShapeDef for Shape {
    const INFO: Info =
        Info::new("mandelbox", "Mandelbox centred at the origin.", "Lowe 2010; Christensen 2011, part VI").inexact();
    const PARAMS: &'static [Param] = &[
        Param::between(
            "scale",
            -1.5,
            -3.0,
            3.0,
            "Factor of each iteration; the set is the richer the nearer to -1 or 1.",
        ),
        Param::count("iterations", 12.0, 1.0, LIMIT as f32, "How often space is folded."),
        Param::between("fold", 1.0, 0.5, 2.0, "Where coordinates are mirrored.").with_unit(Unit::Metres),
        Param::between("min-radius", 0.5, 0.25, 2.0, "Within it all points are scaled alike.").with_unit(Unit::Metres),
        Param::between("fixed-radius", 1.0, 0.5, 2.0, "Radius of the ball of inversion.").with_unit(Unit::Metres),
    ];
    type Params<N: Real> = [N; 5];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, params: [N; 5]) -> N {
        let map = Map::new(params);
        let bound = map.bound(p);
        let near = orbit::is_near(bound, map.half);
        let start = [p.x, p.y, p.z, N::one()];
        let [x, y, z, shrink] = N::iterate(map.iterations, LIMIT, start, |state| map.step(state, p, near));
        let radius = map.half * N::constant(3f32.sqrt());
        let over = Vec3::new(x, y, z).length() - radius;
        let bent = orbit::bent(over, N::constant(BEND) * (-over).max(N::zero()) / radius);
        let estimate = bent * shrink * N::constant(1.0 / SLOPE);
        orbit::within(estimate, bound, map.half)
    }
    fn bounds([scale, _, fold, ..]: [f32; 5]) -> Aabb {
        let half = half_edge(scale, fold);
        Aabb::centred(half, half, half)
    }
    fn lipschitz([scale, ..]: [f32; 5]) -> f32 {
        if scale.abs() < 1.1 { 4.0 } else { 1.0 }
    }
    const ORBIT: bool = true;
    fn orbit<N: Real>(p: Vec3<N>, centre: Vec3<N>, params: [N; 5]) -> [N; TRAPS] {
        let map = Map::new(params);
        let near = orbit::is_near(map.bound(p), map.half);
        let start = [p.x, p.y, p.z, N::one()];
        orbit::traps::<N, 4, 10>(centre, map.iterations, LIMIT, start, |state| map.step(state, p, near))
    }
}
