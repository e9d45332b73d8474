//! Capsule about y: the distance to the segment between its two cap centres, less the radius (Quilez 2008, "Distance
//! functions", capsule). Exact. `height` is the length of that segment, as in common tools: the whole is
//! `height + 2 radius` long.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::RayInterval;
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "capsule",
        "Cylinder about the y axis with half spheres for ends, centred at the origin.",
        "Quilez 2008, capsule",
    );
    const PARAMS: &'static [Param] = &[
        Param::length("radius", 0.25, "Radius of the side and of the ends."),
        Param::length_or_zero("height", 1.0, "Length of the straight part, between the centres of the two ends."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        let past_end = (p.y.abs() - height * N::constant(0.5)).max(N::zero()).named("past_end");
        Vec3::new(p.x, past_end, p.z).length() - radius
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius, height]: [N; 2]) -> RayInterval<N> {
        let half = height * N::constant(0.5);
        let cylinder = super::cylinder::Shape::interval(origin, direction, [radius, height]);
        let end = |y: N| super::sphere::Shape::interval(Vec3::new(origin.x, origin.y - y, origin.z), direction, [radius]);
        cylinder.union(end(half)).union(end(-half))
    }
    fn area([radius, height]: [f32; 2]) -> Option<f32> {
        Some(2.0 * PI * radius * (height + 2.0 * radius))
    }
    fn bounds([radius, height]: [f32; 2]) -> Aabb {
        Aabb::centred(radius, 0.5 * height + radius, radius)
    }
}
