//! Sphere: the distance to a point, less the radius (Hart 1996, "Sphere tracing", appendix A). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::{Emitter, ShapeDef};
use crate::ray_interval::RayInterval;
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("sphere", "Sphere centred at the origin.", "Hart 1996, appendix A");
    const PARAMS: &'static [Param] = &[Param::length("radius", 1.0, "Distance from the centre to the surface.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        p.length() - radius
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius]: [N; 1]) -> RayInterval<N> {
        let along = origin.dot(direction).named("along");
        let across = origin - direction * along;
        let square = (radius * radius - across.dot(across)).named("square");
        RayInterval::quadric(N::one(), along, origin.dot(origin) - radius * radius, square)
    }
    fn emitter([radius]: [f32; 1]) -> Emitter {
        Emitter::Sphere(radius)
    }
    fn area([radius]: [f32; 1]) -> Option<f32> {
        Some(4.0 * PI * radius * radius)
    }
    fn bounds([radius]: [f32; 1]) -> Aabb {
        Aabb::centred(radius, radius, radius)
    }
}
