//! Mandelbox: fold at a box, fold at a ball, scale, add the point, repeat.
//!
//! Idea: Lowe 2010. A step mirrors each coordinate that is beyond the fold limit back at it, inverts points in the ball of
//! the fixed radius (in that of the least radius, it scales them by a constant instead), scales by s and adds the first
//! point. The solid is where the orbit has stayed in the ball through the corners of the box that holds the set.
//!
//! Distance: (|z| - R)/D/SLOPE. Both folds are continuous; a mirror keeps lengths and an inversion scales them by
//! m = (fixed/|z|)², so D ← D |s| m + 1 bounds the derivative of z by the first point (Christensen 2011, part VI), and |∇|z||/D
//! is at most one. What is left is the slope of 1/D itself, which the factor m has in the shell between both radii.
//!
//! Bounds: for s < -1 the corner of the set is twice the fold limit, a fixed point of the map; for s > 1 it is
//! 2 (s + 1)/(s - 1) times it. The solid is cut at that box, and at five times the limit where it would be larger.
//!
//! SLOPE: see `MEASURED`. Cost: about 30 operations for each iteration, no root.

use crate::bounds::Aabb;
use crate::number::{Real, Vec3};
use crate::orbit;
use crate::registry::{Info, Param, Primitive, TRAPS, Unit};

pub(crate) struct Shape;

/// The most iterations.
const LIMIT: u32 = 20;
/// Above the largest slope of (|z| - R)/D.
const SLOPE: f32 = 1.0;

/// The point and the bound D of its derivative.
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
    fn step(&self, [x, y, z, derivative]: State<N>, p: Vec3<N>, near: N::Mask) -> (State<N>, N::Mask) {
        let mirrored = |v: N| v.clamp(-self.fold, self.fold) * N::constant(2.0) - v;
        let z = Vec3::new(mirrored(x), mirrored(y), mirrored(z));
        let inverted = self.fixed_square / z.dot(z).max(self.least_square).min(self.fixed_square);
        let factor = self.scale * inverted;
        let z = z * factor + p;
        ([z.x, z.y, z.z, derivative * factor.abs() + N::one()], near)
    }
}

/// Half of an edge of the box that holds the set.
fn half_edge<N: Real>(scale: N, fold: N) -> N {
    let (one, two) = (N::one(), N::constant(2.0));
    let positive = (two * (scale + one) / (scale - one).max(N::constant(0.1))).min(N::constant(5.0));
    fold * N::select(scale.lt(N::zero()), two, positive)
}

impl Primitive for Shape {
    const INFO: Info = Info {
        exact: false,
        ..Info::new("mandelbox", "Mandelbox centred at the origin.", "Lowe 2010; Christensen 2011, part VI")
    };
    const PARAMS: &'static [Param] = &[
        Param::between("scale", -1.5, -3.0, 3.0, "Factor of each iteration; the set is the richer the nearer to -1 or 1."),
        Param::count("iterations", 12.0, 1.0, LIMIT as f32, "How often space is folded."),
        Param { unit: Unit::Metres, ..Param::between("fold", 1.0, 0.1, 10.0, "Where coordinates are mirrored.") },
        Param { unit: Unit::Metres, ..Param::between("min-radius", 0.5, 0.1, 10.0, "Within it all points are scaled alike.") },
        Param { unit: Unit::Metres, ..Param::between("fixed-radius", 1.0, 0.1, 10.0, "Radius of the ball of inversion.") },
    ];
    type Params<N: Real> = [N; 5];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, params: [N; 5]) -> N {
        let map = Map::new(params);
        let bound = map.bound(p);
        let near = orbit::is_near(bound, map.half);
        let start = [p.x, p.y, p.z, N::one()];
        let [x, y, z, derivative] = N::iterate(map.iterations, LIMIT, start, |state| map.step(state, p, near));
        let radius = map.half * N::constant(3f32.sqrt());
        let estimate = (Vec3::new(x, y, z).length() - radius) / (derivative * N::constant(SLOPE));
        orbit::within(estimate, bound, map.half)
    }
    fn bounds([scale, _, fold, ..]: [f32; 5]) -> Aabb {
        let half = half_edge(scale, fold);
        Aabb::centred(half, half, half)
    }
    const ORBIT: bool = true;
    fn orbit<N: Real>(p: Vec3<N>, params: [N; 5]) -> [N; TRAPS] {
        let map = Map::new(params);
        let near = orbit::is_near(map.bound(p), map.half);
        let start = [p.x, p.y, p.z, N::one()];
        orbit::traps::<N, 4, 9>(map.iterations, LIMIT, start, |state| map.step(state, p, near))
    }
}
