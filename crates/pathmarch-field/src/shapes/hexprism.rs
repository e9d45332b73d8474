//! Hexagonal prism: the plane is folded onto the sector of one edge, where the distance is that to a segment; extruded
//! along y (Quilez 2008, "2D distance functions", hexagon, and "extrusion"). Exact.
//!
//! `radius` is the circumradius, which is also the edge length: the corners lie at distance `radius` from the axis, two
//! of them on the x axis; the sides at `radius`·√3/2, two of them facing ±z.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;

pub(crate) struct Shape;

const HALF_SQRT_3: f32 = 0.866_025_4;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "hexprism",
        "Regular hexagon in xz, two corners on the x axis, extruded along y; centred at the origin.",
        "Quilez 2008, hexagon and extrusion",
    );
    const PARAMS: &'static [Param] = &[
        Param::length("radius", 0.5, "From the axis to the corners; also the edge length of the hexagon."),
        Param::length("height", 1.0, "Length along y."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        let (zero, half, half_root) = (N::zero(), N::constant(0.5), N::constant(HALF_SQRT_3));
        // Fold onto the edge that faces +z: mirror in x and z, then across the line to the corner at 60°.
        let (x, z) = (p.x.abs(), p.z.abs());
        let twice_beyond = ((half_root * x - half * z).max(zero) * N::constant(2.0)).named("twice_beyond");
        let folded_x = x - half_root * twice_beyond;
        let folded_z = z + half * twice_beyond;
        let past_corner = (folded_x.abs() - half * radius).max(zero).named("past_corner");
        let side = (folded_z - half_root * radius).named("side");
        let ends = (p.y.abs() - half * height).named("ends");
        let inside = side.max(ends);
        let outside = Vec3::new(past_corner, side.max(zero), ends.max(zero)).length();
        N::select(zero.lt(inside.max(past_corner)), outside, inside)
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        let (half, half_root) = (N::constant(0.5), N::constant(HALF_SQRT_3));
        let slanted = half_root * p.x.abs() + half * p.z.abs();
        (p.z.abs().max(slanted) - half_root * radius).max(p.y.abs() - half * height)
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius, height]: [N; 2]) -> RayInterval<N> {
        let (half, half_root) = (N::constant(0.5), N::constant(HALF_SQRT_3));
        let inner = radius * half_root;
        let faces = |sign: f32| {
            let across = |v: Vec3<N>| v.x * half_root * N::constant(sign) + v.z * half;
            RayInterval::slab(across(origin), across(direction), inner)
        };
        let ends = RayInterval::slab(origin.y, direction.y, height * half);
        faces(1.0).intersection(faces(-1.0)).intersection(RayInterval::slab(origin.z, direction.z, inner)).intersection(ends)
    }
    fn bounds([radius, height]: [f32; 2]) -> Aabb {
        Aabb::centred(radius, 0.5 * height, HALF_SQRT_3 * radius)
    }
}
