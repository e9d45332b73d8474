//! Half-space bounded by a plane through the origin: the height above it (Hart 1996, appendix A). Exact.
//!
//! `normal` turns the plane; it is part of the placement, so that a level floor costs nothing but `p.y`.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("plane", "Endless plane through the origin, solid below; faces +y.", "Hart 1996, appendix A").facing();
    const PARAMS: &'static [Param] = &[];
    type Params<N: Real> = [N; 0];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, []: [N; 0]) -> N {
        p.y
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, []: [N; 0]) -> RayInterval<N> {
        RayInterval::half_space(origin.y, direction.y)
    }
    fn bounds([]: [f32; 0]) -> Aabb {
        Aabb { max: [f32::INFINITY, 0.0, f32::INFINITY], ..Aabb::EVERYTHING }
    }
}
