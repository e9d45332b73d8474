//! Menger's sponge in the cube of edge 2. Outside the distance is exact to rounding, inside it is a bound.
//!
//! Idea: the cube is cut into 27, the seven that touch no edge of it are taken away, and so on with the 20 that are
//! left (Menger 1926). The sponge has the symmetries of the cube: taking magnitudes and sorting them folds space onto
//! one of 48 equal wedges, x ≥ y ≥ z ≥ 0, in which only the cubes at (2, 2, 2)/3 and (2, 2, 0)/3 lie. They are each
//! other's mirror image in z = 1/3, so one more reflection leaves one cube, which 3z makes the whole one again
//! (kaleidoscopic iterated function systems: Knighty 2010, after Hutchinson 1981).
//!
//! Distance outside: N such steps, then the distance to the cube, over 3^N. Nothing of the solid in another wedge is
//! nearer than its image in the wedge of the point, because mirroring both points into one wedge never moves them
//! apart, so this is the true distance. Inside it would be zero on the faces at which two small cubes touch. There the
//! sponge is the cube without the bars of square section of every level (Quilez 2011), and the nearest of those gives
//! the distance: in the wedge of level k, the bar is y < 1/3, and (1/3 - y)/3^k its depth.
//!
//! Measured: slope 1.0000 over 200,000 random points and hill climbing (`tests/fractals.rs`), as derived. Cost: about
//! 25 operations for each iteration, no root but in the last one's cube.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::orbit;
use crate::shapes::{ShapeDef, TRAPS};

pub(crate) struct Shape;

/// Largest number of iterations; the smallest cubes are then 0.3 mm wide.
const LIMIT: u32 = 8;

/// State: the point, 3^-k, and the largest of the distances that keep the point off the inside: to the cube, and the depths in
/// the bars.
type State<N> = [N; 5];

fn start<N: Real>(p: Vec3<N>) -> State<N> {
    [p.x, p.y, p.z, N::one(), p.abs().largest() - N::one()]
}

#[inline(always)]
fn step<N: Real>([x, y, z, shrink, outside]: State<N>) -> (State<N>, N::Mask) {
    let third = N::constant(1.0 / 3.0);
    let (three, two) = (N::constant(3.0), N::constant(2.0));
    let Vec3 { x, y, z } = orbit::descending([x.abs(), y.abs(), z.abs()]);
    let outside = outside.max((third - y) * shrink);
    let z = (z - third).abs() - third;
    ([x * three - two, y * three - two, z * three, shrink * third, outside], N::truth(true))
}

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "menger",
        "Menger's sponge in the cube of edge 2 centred at the origin.",
        "Menger 1926; Knighty 2010; Quilez 2011",
    );
    const PARAMS: &'static [Param] =
        &[Param::count("iterations", 4.0, 1.0, LIMIT as f32, "How often each cube is replaced by twenty.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [iterations]: [N; 1]) -> N {
        let (zero, one) = (N::zero(), N::one());
        let [x, y, z, shrink, outside] = N::iterate(iterations, LIMIT, start(p), step);
        let off = Vec3::new(x.abs() - one, y.abs() - one, z.abs() - one);
        let cube = off.max(zero).length() * shrink;
        N::select(zero.lt(outside), cube, outside)
    }
    fn bounds(_: [f32; 1]) -> Aabb {
        Aabb::centred(1.0, 1.0, 1.0)
    }
    const ORBIT: bool = true;
    fn orbit<N: Real>(p: Vec3<N>, centre: Vec3<N>, [iterations]: [N; 1]) -> [N; TRAPS] {
        orbit::traps::<N, 5, 11>(centre, iterations, LIMIT, start(p), step)
    }
}
