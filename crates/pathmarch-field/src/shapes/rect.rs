//! Rectangle: the distance to a flat sheet (Quilez 2008, "Distance functions", a box without height). Exact and nowhere
//! negative: a rectangle has two sides and no inside.
//!
//! Over the rectangle the distance is |y| and not the root of y², so that the gradient has length one on the sheet
//! itself.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::{Emitter, ShapeDef};
use crate::ray_interval::T_MAX;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("rect", "Rectangular sheet without thickness in the plane y = 0; faces +y.", "Quilez 2008, box").sheet().facing().size_params(2);
    const PARAMS: &'static [Param] =
        &[Param::length("x", 1.0, "Edge length along x."), Param::length("z", 1.0, "Edge length along z.")];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [x, z]: [N; 2]) -> N {
        let past_x = p.x.abs() - x * N::constant(0.5);
        let past_z = p.z.abs() - z * N::constant(0.5);
        let beside = Vec3::new(past_x.max(N::zero()), p.y, past_z.max(N::zero())).length();
        N::select(N::zero().lt(past_x.max(past_z)), beside, p.y.abs())
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, _: [N; 2]) -> N {
        p.y.abs()
    }
    const ANALYTIC: bool = true;
    #[inline(always)]
    fn ray<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [x, z]: [N; 2]) -> N {
        let t = (-origin.y / direction.y.divisor()).named("t");
        let past_x = (origin.x + direction.x * t).abs() - x * N::constant(0.5);
        let past_z = (origin.z + direction.z * t).abs() - z * N::constant(0.5);
        N::select(N::zero().lt(t) & past_x.max(past_z).lt(N::zero()), t, N::constant(T_MAX))
    }
    fn emitter([x, z]: [f32; 2]) -> Emitter {
        Emitter::Rect([x, z])
    }
    fn area([x, z]: [f32; 2]) -> Option<f32> {
        Some(x * z)
    }
    fn bounds([x, z]: [f32; 2]) -> Aabb {
        Aabb::centred(0.5 * x, 0.0, 0.5 * z)
    }
}
