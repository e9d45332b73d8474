//! Mandelbulb: z^n + p in spherical coordinates.
//!
//! Idea: White and Nylander 2009 raise a point to a power as polar coordinates suggest: its length to the power n, its
//! angle from the axis and its angle about the axis n times as large. The solid is where the orbit of z ← z^n + p stays
//! bounded. The axis is y.
//!
//! Both angles are multiplied by powers of complex numbers, (y + iρ)^n and ((x + iz)/ρ)^n with ρ the distance to the
//! axis, so there is no angle: (y + iρ)^k = a + iρb, with a and b polynomials in y and ρ². That is exact on the axis
//! too, where an angle has no derivative, and the same to the last bit in all numbers a field is written over. n is
//! whole: another power tears the solid where the angle jumps. Where n is known, the second power is one of
//! (x + iz)²/ρ², which needs no root, times ρb for an even n and (x + iz) b for an odd one.
//!
//! Distance: half of |z| ln |z|/|z'| from the potential (Douady and Hubbard 1984; Hart et al. 1989, section 3), over a
//! slope. The usual running derivative n |z|^(n-1) d + 1 is too small near the axis, as the power is not conformal:
//! about the axis it stretches by n |b| = n |z|^(n-1) |sin nθ / sin θ|, up to n times as much. The larger of both is
//! the norm of the power's derivative. Beyond |z^n| = 1 only the growth of |z| counts more and more, which is not
//! stretched, and |b| is divided by |z^n|. The factor counts as one where it is less, so that its change along the
//! orbit stays bounded.
//!
//! Bounds: |z^n| is |z|^n, so beyond R = 2^(1/(n-1)) every orbit escapes.
//!
//! Measured: slope of the potential's distance at most 2.05 for the power 8, 5.2 for 3, 2.5 for others up to 11, and
//! 3.6 for 16, by hill climbing from the steepest of 7 million random points, over 3,600 random sets of parameters
//! (`tests/fractals.rs`); with the usual running derivative it was 300 and more. It is divided by a quarter of the
//! power, at least by 2.4, and below the power 4 by 6.
//!
//! Cost: for the power 8 about 60 operations, two roots and two divisions for each iteration until the orbit has escaped,
//! one logarithm. Each power is a shape of its own ([`Shape`]): with all digits of any power in the code it was 110.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::entry::Entry;
use crate::shapes::orbit;
use crate::shapes::{ShapeDef, TRAPS};

/// Mandelbulb of any power or, if `POWER` is not zero, of that power alone, with less code.
pub(crate) struct Shape<const POWER: u32 = 0>;

/// Largest number of iterations.
const LIMIT: u32 = 12;
/// Binary digits of the power.
const DIGITS: usize = 5;
/// n-th power of the length at which an orbit ends: p is then lost in the rounding of z^n.
const ESCAPED: f32 = 1e8;
/// State: the point, the inverse of the bound of its derivative, and n^(k - N) ln R.
type State<N> = [N; 5];

#[derive(Clone, Copy)]
struct Map<N: Real, const POWER: u32> {
    /// Power that is known at run time; 0 if it is in `power` alone.
    known: u32,
    power: N,
    digits: [N::Mask; DIGITS],
    iterations: N,
    radius: N,
    escaped: N,
}

impl<N: Real, const POWER: u32> Map<N, POWER> {
    #[inline(always)]
    fn new([power, iterations]: [N; 2], known: u32) -> Self {
        let known = if POWER > 0 { POWER } else { known };
        let power = if known > 0 { N::constant(known as f32) } else { power.floor() };
        let half = N::constant(0.5);
        let mut rest = power;
        let digits = std::array::from_fn(|_| {
            let halved = (rest * half).floor();
            let digit = half.lt(rest - halved - halved);
            rest = halved;
            digit
        });
        let [radius, escaped] = if known > 0 {
            [radius(known as f32), escaped(known as f32)].map(N::constant)
        } else {
            [radius(power), escaped(power)]
        };
        Self { known, power, digits, iterations, radius, escaped }
    }
    /// Power known at compile time or run time; 0 for a recorded number.
    #[inline(always)]
    fn known(&self) -> u32 {
        if POWER > 0 { POWER } else { self.known }
    }
    /// Power of a complex number under the product `times`; zero for zero.
    #[inline(always)]
    fn raised(&self, base: [N; 2], times: impl Fn([N; 2], [N; 2]) -> [N; 2]) -> [N; 2] {
        if self.known() > 0 {
            return known_power(self.known(), base, times);
        }
        let (mut square, mut result) = (base, [N::one(), N::zero()]);
        for (k, &digit) in self.digits.iter().enumerate() {
            if k > 0 {
                square = times(square, square);
            }
            let product = times(result, square);
            result = std::array::from_fn(|part| N::select(digit, product[part], result[part]));
        }
        result
    }
    /// Lengths of z^n and z^(n-1), given the length of z and the two parts of z^n.
    #[inline(always)]
    fn lengths(&self, length: N, a: N, radial: N) -> [N; 2] {
        if self.known() > 1 {
            let [along] = known_power(self.known() - 1, [length], |[u], [v]| [u * v]);
            return [along * length, along];
        }
        let raised = a.hypot(radial).named("raised");
        [raised, raised / length.max(N::constant(1e-12))]
    }
    /// ρb, and its parts along x and z where the angle about the axis is n times that of x + iz.
    #[inline(always)]
    fn about_axis(&self, [x, z]: [N; 2], across_square: N, b: N) -> [N; 3] {
        let times = |u: [N; 2], v: [N; 2]| [u[0] * v[0] - u[1] * v[1], u[0] * v[1] + u[1] * v[0]];
        let across = across_square.sqrt().named("across");
        let radial = across * b;
        let power = self.known();
        if power < 2 {
            let inverse = N::one() / across.max(N::constant(1e-12));
            let [cos, sin] = self.raised([x * inverse, z * inverse], times);
            return [radial, radial * cos, radial * sin];
        }
        // Of length one, or zero on the axis.
        let inverse = N::one() / across_square.max(N::constant(1e-24));
        let square = [(x * x - z * z) * inverse, (x + x) * z * inverse];
        let [cos, sin] = known_power(power / 2, square, times);
        let [along_x, along_z] = match power % 2 {
            0 => [radial * cos, radial * sin],
            _ => times([x * b, z * b], [cos, sin]),
        };
        [radial, along_x, along_z]
    }
    #[inline(always)]
    fn start(&self, p: Vec3<N>) -> State<N> {
        let logarithm = self.power.ln() * self.iterations.floor();
        [p.x, p.y, p.z, N::one(), self.radius.ln() * (-logarithm).exp()]
    }
    #[inline(always)]
    fn step(&self, [x, y, z, shrink, offset]: State<N>, p: Vec3<N>, near: N::Mask) -> (State<N>, N::Mask) {
        let across_square = (x * x + z * z).named("across_square");
        let length = (across_square + y * y).sqrt();
        // From the axis: a + iρb.
        let [a, b] =
            self.raised([y, N::one()], |u, v| [u[0] * v[0] - across_square * (u[1] * v[1]), u[0] * v[1] + u[1] * v[0]]);
        let [radial, along_x, along_z] = self.about_axis([x, z], across_square, b);
        let [raised, along] = self.lengths(length, a, radial);
        // The factor of the derivative is n max(along, |b| / scale), at least one; all of it times the scale, there is one
        // division.
        let scale = raised.max(N::one());
        let factor = (self.power * (along * scale).max(b.abs())).max(scale);
        let scaled = shrink * scale;
        let next = Vec3::new(along_x, a, along_z) + p;
        let go_on = near & next.dot(next).lt(self.escaped * self.escaped);
        ([next.x, next.y, next.z, scaled / (factor + scaled), offset * self.power], go_on)
    }
}

/// Known power, with as few products as its binary digits need.
#[inline(always)]
fn known_power<V: Copy>(power: u32, base: V, times: impl Fn(V, V) -> V) -> V {
    let (mut square, mut result) = (base, base);
    // A fixed number of passes, so that the loop is unrolled and its conditions vanish if the power is a constant.
    for k in 0..DIGITS as u32 {
        if power >> k == 0 {
            break;
        }
        if k > 0 {
            square = times(square, square);
        }
        if power >> k & 1 == 1 {
            let is_first = power & ((1 << k) - 1) == 0;
            result = if is_first { square } else { times(result, square) };
        }
    }
    result
}

/// Length at which an orbit ends.
fn escaped<N: Real>(power: N) -> N {
    (N::constant(ESCAPED.ln()) / power).exp()
}

/// Radius beyond which every orbit escapes.
fn radius<N: Real>(power: N) -> N {
    (N::constant(std::f32::consts::LN_2) / (power - N::one())).exp()
}

/// Upper bound of the slope of the potential's distance.
fn slope<N: Real>(power: N) -> N {
    let usual = (power * N::constant(0.25)).max(N::constant(2.4));
    N::select(power.lt(N::constant(3.5)), N::constant(6.0), usual)
}

/// Zero where the estimate is not used, so that no power overflows.
fn kept<N: Real>(p: Vec3<N>, near: N::Mask) -> Vec3<N> {
    let [x, y, z] = [p.x, p.y, p.z].map(|v| N::select(near, v, N::zero()));
    Vec3::new(x, y, z)
}

/// Distance with the power `POWER`, or `known`, or of the parameters.
#[inline(always)]
fn distance<N: Real, const POWER: u32>(p: Vec3<N>, params: [N; 2], known: u32) -> N {
    let map = Map::<N, POWER>::new(params, known);
    let bound = p.length() - map.radius;
    let near = orbit::is_near(bound, map.radius);
    let p = kept(p, near);
    let [x, y, z, shrink, offset] = N::iterate(map.iterations, LIMIT, map.start(p), |state| map.step(state, p, near));
    let estimate = orbit::from_potential(Vec3::new(x, y, z).length(), offset, shrink) * (N::one() / slope(map.power));
    orbit::within(estimate, bound, map.radius)
}

/// Distance as [`distance`], in one function for all powers.
#[inline(never)]
fn distance_of_any<N: Real>(p: Vec3<N>, params: [N; 2], known: u32) -> N {
    distance::<N, 0>(p, params, known)
}

/// The traps with a power of `known`, or of the parameters.
#[inline(never)]
fn orbit_of_any<N: Real>(p: Vec3<N>, centre: Vec3<N>, params: [N; 2], known: u32) -> [N; TRAPS] {
    let map = Map::<N, 0>::new(params, known);
    let near = orbit::is_near(p.length() - map.radius, map.radius);
    let p = kept(p, near);
    orbit::traps::<N, 5, 11>(centre, map.iterations, LIMIT, map.start(p), |state| map.step(state, p, near))
}

impl<const POWER: u32> ShapeDef for Shape<POWER> {
    const INFO: Info = Info::new(
        "mandelbulb",
        "Mandelbulb centred at the origin, its axis along y.",
        "White and Nylander 2009; Hart et al. 1989, section 3",
    )
    .inexact();
    const PARAMS: &'static [Param] = &[
        Param::count("power", 8.0, 2.0, 16.0, "The power that points are raised to."),
        Param::count("iterations", 8.0, 1.0, LIMIT as f32, "How often the power is taken."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, params: [N; 2]) -> N {
        distance::<N, POWER>(p, params, POWER)
    }
    fn distance_compact<N: Real>(p: Vec3<N>, params: [N; 2]) -> N {
        distance_of_any(p, params, POWER)
    }
    fn bounds([power, _]: [f32; 2]) -> Aabb {
        let radius = radius(power.floor());
        Aabb::centred(radius, radius, radius)
    }
    const VARIANT: u32 = POWER;
    fn variant([power, _]: [f32; 2]) -> Option<&'static dyn crate::shapes::Shape> {
        macro_rules! of_power {
            ($($known:literal)*) => {
                match power as u32 {
                    $($known => Some(const { &Entry::<Shape<$known>>::new() }),)*
                    _ => None,
                }
            };
        }
        if POWER > 0 { None } else { of_power!(2 3 4 5 6 7 8 9 10 11 12 13 14 15 16) }
    }
    const ORBIT: bool = true;
    fn orbit<N: Real>(p: Vec3<N>, centre: Vec3<N>, params: [N; 2]) -> [N; TRAPS] {
        orbit_of_any(p, centre, params, POWER)
    }
}
