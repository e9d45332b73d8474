//! Disc: the distance to a flat round sheet (Quilez 2008, "Distance functions", a capped cylinder without height).
//! Exact and nowhere negative: a disc has two sides and no inside.
//!
//! Over the disc the distance is |y| and not the root of y², so that the gradient has length one on the sheet itself.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::{Emitter, ShapeDef};
use crate::ray_interval::T_MAX;
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("disc", "Round sheet without thickness in the plane y = 0; faces +y.", "Quilez 2008, capped cylinder").sheet().facing();
    const PARAMS: &'static [Param] = &[Param::length("radius", 1.0, "Distance from the centre to the rim.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        let past_rim = (p.x.hypot(p.z) - radius).named("past_rim");
        N::select(N::zero().lt(past_rim), past_rim.hypot(p.y), p.y.abs())
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, _: [N; 1]) -> N {
        p.y.abs()
    }
    const ANALYTIC: bool = true;
    #[inline(always)]
    fn ray<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius]: [N; 1]) -> N {
        let t = (-origin.y / direction.y.divisor()).named("t");
        let past_rim = (origin.x + direction.x * t).hypot(origin.z + direction.z * t) - radius;
        N::select(N::zero().lt(t) & past_rim.lt(N::zero()), t, N::constant(T_MAX))
    }
    fn emitter([radius]: [f32; 1]) -> Emitter {
        Emitter::Disc(radius)
    }
    fn area([radius]: [f32; 1]) -> Option<f32> {
        Some(PI * radius * radius)
    }
    fn bounds([radius]: [f32; 1]) -> Aabb {
        Aabb::centred(radius, 0.0, radius)
    }
}
