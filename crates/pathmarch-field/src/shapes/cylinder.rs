//! Cylinder about y: in the half-plane through the axis it is a rectangle, so the distance is that of a box in the
//! coordinates (distance from the axis, height) (Quilez 2008, "Distance functions", capped cylinder). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info =
        Info::new("cylinder", "Capped cylinder about the y axis, centred at the origin.", "Quilez 2008, capped cylinder");
    const PARAMS: &'static [Param] = &[
        Param::length("radius", 0.5, "Distance from the axis to the side."),
        Param::length("height", 1.0, "Length along y, from cap to cap."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        let side = (p.x.hypot(p.z) - radius).named("side");
        let ends = (p.y.abs() - height * N::constant(0.5)).named("ends");
        side.max(N::zero()).hypot(ends.max(N::zero())) + side.max(ends).min(N::zero())
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        (p.x.hypot(p.z) - radius).max(p.y.abs() - height * N::constant(0.5))
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius, height]: [N; 2]) -> RayInterval<N> {
        let a = direction.x * direction.x + direction.z * direction.z;
        let b = origin.x * direction.x + origin.z * direction.z;
        let c = (origin.x * origin.x + origin.z * origin.z - radius * radius).named("c");
        let moment = origin.x * direction.z - origin.z * direction.x;
        let side = RayInterval::quadric(a, b, c, radius * radius * a - moment * moment);
        // Along the axis, it is inside all along or not at all.
        let parallel = a.lt(N::constant(1e-12));
        let within = RayInterval::half_space(c, N::zero());
        let side = RayInterval {
            enter: N::select(parallel, within.enter, side.enter),
            leave: N::select(parallel, within.leave, side.leave),
        };
        side.intersection(RayInterval::slab(origin.y, direction.y, height * N::constant(0.5)))
    }
    fn area([radius, height]: [f32; 2]) -> Option<f32> {
        Some(2.0 * PI * radius * (radius + height))
    }
    fn bounds([radius, height]: [f32; 2]) -> Aabb {
        Aabb::centred(radius, 0.5 * height, radius)
    }
}
