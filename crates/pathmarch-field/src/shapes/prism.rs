//! Triangular prism: the plane is folded onto the sector of one edge, where the distance is that to a segment; extruded
//! along z (Quilez 2008, "2D distance functions", equilateral triangle, and "extrusion"). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;

pub(crate) struct Shape;

const SQRT_3: f32 = 1.732_050_8;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "prism",
        "Equilateral triangle in xy, a corner up, its centroid at the origin, extruded along z.",
        "Quilez 2008, equilateral triangle and extrusion",
    );
    const PARAMS: &'static [Param] = &[
        Param::length("side", 1.0, "Edge length of the triangle."),
        Param::length("depth", 1.0, "Length along z."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [side, depth]: [N; 2]) -> N {
        let (zero, half, root) = (N::zero(), N::constant(0.5), N::constant(SQRT_3));
        // Fold onto the bottom edge: mirror in x, then across the line from the centroid to the lower right corner.
        let half_side = side * half;
        let x = p.x.abs() - half_side;
        let y = p.y + half_side / root;
        let beyond = zero.lt(x + root * y);
        let folded_x = N::select(beyond, (x - root * y) * half, x);
        let folded_y = N::select(beyond, (-root * x - y) * half, y);
        let past_corner = ((folded_x + half_side).abs() - half_side).max(zero).named("past_corner");
        let below = (-folded_y).named("below");
        let ends = (p.z.abs() - depth * half).named("ends");
        let inside = below.max(ends);
        let outside = Vec3::new(past_corner, below.max(zero), ends.max(zero)).length();
        N::select(zero.lt(inside.max(past_corner)), outside, inside)
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [side, depth]: [N; 2]) -> N {
        let half = N::constant(0.5);
        let slanted = (N::constant(SQRT_3) * p.x.abs() + p.y) * half;
        let sides = (-p.y).max(slanted) - side * N::constant(0.5 / SQRT_3);
        sides.max(p.z.abs() - depth * half)
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [side, depth]: [N; 2]) -> RayInterval<N> {
        let (half, inner) = (N::constant(0.5), side * N::constant(0.5 / SQRT_3));
        let slope = N::constant(0.5 * SQRT_3);
        let face = |sign: f32| {
            let across = |v: Vec3<N>| v.x * slope * N::constant(sign) + v.y * half;
            RayInterval::half_space(across(origin) - inner, across(direction))
        };
        let below = RayInterval::half_space(-origin.y - inner, -direction.y);
        face(1.0).intersection(face(-1.0)).intersection(below).intersection(RayInterval::slab(origin.z, direction.z, depth * half))
    }
    fn bounds([side, depth]: [f32; 2]) -> Aabb {
        let (half, inner) = (0.5 * side, 0.5 * side / SQRT_3);
        Aabb { min: [-half, -inner, -0.5 * depth], max: [half, 2.0 * inner, 0.5 * depth] }
    }
}
