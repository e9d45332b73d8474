//! Regular octahedron: the points with |x| + |y| + |z| at most `radius`. Exact.
//!
//! Idea: its symmetries fold space onto coordinates a ≥ b ≥ c ≥ 0, where only one face, one edge and one corner can be
//! the nearest (Quilez 2008, "Distance functions", octahedron, distinguishes the edges instead of sorting). The foot on
//! the face's plane is on the face while c is at least a third of the excess a + b + c - radius; past that it is on the
//! edge while a - radius is at most b. The sum of the coordinates alone would be a bound of slope one too, but √3 too
//! short at the corners.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;

pub(crate) struct Shape;

const INVERSE_SQRT_2: f32 = 0.707_106_77;
const INVERSE_SQRT_3: f32 = 0.577_350_26;

/// The larger and the smaller of two, chosen by one mask so that their derivatives are of both where they are equal.
#[inline(always)]
fn sorted<N: Real>(a: N, b: N) -> (N, N) {
    let swap = a.lt(b);
    (N::select(swap, b, a), N::select(swap, a, b))
}

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "octahedron",
        "Regular octahedron centred at the origin, its corners on the axes.",
        "Quilez 2008, octahedron",
    );
    const PARAMS: &'static [Param] = &[Param::length("radius", 1.0, "From the centre to the corners.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        let q = p.abs();
        let (a, b) = sorted(q.x, q.y);
        let (b, c) = sorted(b, q.z);
        let (a, b) = sorted(a, b);
        let (a, b, c) = (a.named("a"), b.named("b"), c.named("c"));
        let past_corner = a - radius;
        let past_edge = past_corner + b;
        let excess = (past_edge + c).named("excess");
        let from_corner = Vec3::new(past_corner, b, c).length();
        let from_edge = (past_edge * N::constant(INVERSE_SQRT_2)).hypot(c);
        let from_face = excess * N::constant(INVERSE_SQRT_3);
        let past_face = (c * N::constant(3.0)).lt(excess);
        N::select(past_face, N::select(b.lt(past_corner), from_corner, from_edge), from_face)
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        let q = p.abs();
        (q.x + q.y + q.z - radius) * N::constant(INVERSE_SQRT_3)
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius]: [N; 1]) -> RayInterval<N> {
        let faces = |x: f32, z: f32| {
            let across = |v: Vec3<N>| v.x * N::constant(x) + v.y + v.z * N::constant(z);
            RayInterval::slab(across(origin), across(direction), radius)
        };
        faces(1.0, 1.0).intersection(faces(1.0, -1.0)).intersection(faces(-1.0, 1.0)).intersection(faces(-1.0, -1.0))
    }
    fn bounds([radius]: [f32; 1]) -> Aabb {
        Aabb::centred(radius, radius, radius)
    }
}
