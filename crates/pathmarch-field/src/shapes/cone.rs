//! Cone about y: in the half-plane through the axis it is a right triangle (Quilez 2008, "Distance functions", cone).
//! Exact.
//!
//! Inside, the solid is convex, so its distance is the larger of the heights over base and side. Outside it is the
//! smaller of the distances to the base's disc and to the slanted segment. Both are measured by unclamped and clamped
//! coordinates rather than by a signed square root, so that the gradient has length one on the surface too.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use crate::ray_interval::{T_MAX, RayInterval};
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "cone",
        "Cone about the y axis, its base at -height/2 and its apex at +height/2.",
        "Quilez 2008, cone",
    );
    const PARAMS: &'static [Param] = &[
        Param::length("radius", 0.5, "Radius of the base."),
        Param::length("height", 1.0, "From the base to the apex."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        let zero = N::zero();
        let slant = radius.hypot(height).named("slant");
        // Measured from the rim: outwards, upwards, and below the base.
        let outwards = (p.x.hypot(p.z) - radius).named("outwards");
        let below = (-p.y - height * N::constant(0.5)).named("below");
        // In the frame of the slanted segment: off it, and along it from the rim.
        let side = ((outwards * height - below * radius) / slant).named("side");
        let along = ((-outwards * radius - below * height) / slant).named("along");
        let past_segment = (along - slant).max(-along).max(zero);
        let from_segment = side.hypot(past_segment);
        let from_base = below.hypot(outwards.max(zero));
        let inside = side.max(below).named("inside");
        N::select(zero.lt(inside), from_segment.min(from_base), inside)
    }
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, [radius, height]: [N; 2]) -> N {
        let outwards = p.x.hypot(p.z) - radius;
        let below = -p.y - height * N::constant(0.5);
        ((outwards * height - below * radius) / radius.hypot(height)).max(below)
    }
    const CONVEX: bool = true;
    #[inline(always)]
    fn interval<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius, height]: [N; 2]) -> RayInterval<N> {
        // From the apex downwards, x² + z² ≤ (slope·depth)².
        let (half, slope) = (height * N::constant(0.5), radius / height);
        let depth = half - origin.y;
        let (rise, start) = (slope * -direction.y, slope * depth);
        let flat = direction.x * direction.x + direction.z * direction.z;
        let a = (flat - rise * rise).named("a");
        let b = (origin.x * direction.x + origin.z * direction.z - start * rise).named("b");
        let c = (origin.x * origin.x + origin.z * origin.z - start * start).named("c");
        let root = (b * b - a * c).max(N::zero()).sqrt().named("root");
        let q = (-b - root * b.sign()).named("q");
        let (one, other) = (q / a.divisor(), c / q.divisor());
        let (first, last) = (one.min(other), one.max(other));
        // A steep line is inside both nappes but for what is between: of those, the one below counts.
        let steep = a.lt(N::zero());
        let downwards = N::zero().lt(rise);
        let between = RayInterval { enter: first, leave: last };
        let missed = !steep & (b * b - a * c).lt(N::zero());
        let nowhere = RayInterval::empty();
        let side = RayInterval {
            enter: N::select(steep, N::select(downwards, last, N::constant(-T_MAX)), between.enter),
            leave: N::select(steep, N::select(downwards, N::constant(T_MAX), first), between.leave),
        };
        let side = RayInterval {
            enter: N::select(missed, nowhere.enter, side.enter),
            leave: N::select(missed, nowhere.leave, side.leave),
        };
        side.intersection(RayInterval::slab(origin.y, direction.y, half))
    }
    fn area([radius, height]: [f32; 2]) -> Option<f32> {
        Some(PI * radius * (radius + radius.hypot(height)))
    }
    fn bounds([radius, height]: [f32; 2]) -> Aabb {
        Aabb::centred(radius, 0.5 * height, radius)
    }
}
