//! Quaternion Julia set of q² + c, its slice through real, i and j parts.
//!
//! Idea: Norton 1982 iterates q ← q² + c over quaternions; the solid is where the orbit stays bounded. The point (x, y,
//! z) is the quaternion x + y i + z j.
//!
//! Distance: half of |q| ln |q|/|q'| from the potential (Douady and Hubbard 1984; Hart et al. 1989, section 3), over a
//! slope. The square scales lengths by 2|q| at most, exactly that in the plane of q and the reals. Near q = 0 that
//! factor vanishes, and where the orbit of 0 escapes (the set is dust) the quotient has no bound there: it is a lower
//! bound of the distance for connected sets only. So the factor counts as one where it is less: the derivative is taken
//! as too large, and its change along the orbit stays bounded.
//!
//! Bounds: beyond R = (1 + √(1 + 4|c|))/2, where R² - |c| = R, every orbit escapes.
//!
//! Measured: slope of the potential's distance at most 1.07 with the defaults, 1.09 for |c| up to 0.75, then 1.42,
//! 1.60, 1.81, 1.96 and 2.05 for each further 0.25, by hill climbing from the steepest of 2.4 million random points,
//! over 3,000 random sets of parameters (`tests/fractals.rs`). It is divided by 1.2 (1 + (|c| - 0.75)), at least by
//! 1.2.
//!
//! Cost: about 20 operations and a root for each iteration until the orbit has escaped, one logarithm.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::orbit;
use crate::shapes::{ShapeDef, TRAPS};

pub(crate) struct Shape;

/// Largest number of iterations.
const LIMIT: u32 = 20;
/// Length at which an orbit ends: c is then lost in the rounding of q².
const ESCAPED: f32 = 1e4;
/// The quaternion (real, i, j, k), the inverse of the bound of its derivative, and 2^(k - N) ln R.
type State<N> = [N; 6];

#[derive(Clone, Copy)]
struct Map<N> {
    c: [N; 4],
    iterations: N,
    radius: N,
    /// Upper bound of the slope of the potential's distance.
    slope: N,
}

impl<N: Real> Map<N> {
    #[inline(always)]
    fn new([x, y, z, w, iterations]: [N; 5]) -> Self {
        let size = N::norm([x, y, z, w]);
        let slope = N::constant(1.2) * (N::one() + (size - N::constant(0.75)).max(N::zero()));
        Self { c: [x, y, z, w], iterations, radius: radius(size), slope }
    }
    #[inline(always)]
    fn start(&self, p: Vec3<N>, near: N::Mask) -> State<N> {
        let zero = N::zero();
        let [x, y, z] = [p.x, p.y, p.z].map(|v| N::select(near, v, zero));
        let offset = self.radius.ln() * (self.iterations.floor() * N::constant(-std::f32::consts::LN_2)).exp();
        [x, y, z, zero, N::one(), offset]
    }
    #[inline(always)]
    fn step(&self, [a, b, c, d, shrink, offset]: State<N>, near: N::Mask) -> (State<N>, N::Mask) {
        let two = N::constant(2.0);
        let factor = (two * N::norm([a, b, c, d])).max(N::one());
        let [ca, cb, cc, cd] = self.c;
        let twice = two * a;
        let next = [a * a - b * b - c * c - d * d + ca, twice * b + cb, twice * c + cc, twice * d + cd];
        let go_on = near & N::norm(next).lt(N::constant(ESCAPED));
        ([next[0], next[1], next[2], next[3], shrink / factor, offset * two], go_on)
    }
}

/// Radius beyond which every orbit escapes.
fn radius<N: Real>(size: N) -> N {
    (N::one() + (N::one() + N::constant(4.0) * size).sqrt()) * N::constant(0.5)
}

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "julia",
        "Slice of the quaternion Julia set of q² + c, the real axis along x.",
        "Norton 1982; Hart et al. 1989, section 3",
    )
    .inexact();
    const PARAMS: &'static [Param] = &[
        Param::between("x", -0.2, -1.0, 1.0, "Real part of c."),
        Param::between("y", 0.4, -1.0, 1.0, "Part of c along i."),
        Param::between("z", -0.4, -1.0, 1.0, "Part of c along j."),
        Param::between("w", -0.4, -1.0, 1.0, "Part of c along k."),
        Param::count("iterations", 10.0, 1.0, LIMIT as f32, "How often the square is taken."),
    ];
    type Params<N: Real> = [N; 5];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, params: [N; 5]) -> N {
        let map = Map::new(params);
        let bound = p.length() - map.radius;
        let near = orbit::is_near(bound, map.radius);
        let [a, b, c, d, shrink, offset] =
            N::iterate(map.iterations, LIMIT, map.start(p, near), |state| map.step(state, near));
        let estimate = orbit::from_potential(N::norm([a, b, c, d]), offset, shrink) * (N::one() / map.slope);
        orbit::within(estimate, bound, map.radius)
    }
    fn bounds([x, y, z, w, _]: [f32; 5]) -> Aabb {
        let radius = radius(f32::norm([x, y, z, w]));
        Aabb::centred(radius, radius, radius)
    }
    const ORBIT: bool = true;
    fn orbit<N: Real>(p: Vec3<N>, centre: Vec3<N>, params: [N; 5]) -> [N; TRAPS] {
        let map = Map::new(params);
        let near = orbit::is_near(p.length() - map.radius, map.radius);
        orbit::traps::<N, 6, 12>(centre, map.iterations, LIMIT, map.start(p, near), |state| map.step(state, near))
    }
}
