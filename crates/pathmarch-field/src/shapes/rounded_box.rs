//! Box with round edges: the distance to a smaller box, less a radius (Quilez 2008, "Distance functions", round box).
//! Exact. The edge lengths are those of the outside: rounding takes away, so that the solid fits into the `box` of the
//! same size. A `radius` of more than half the shortest edge is taken as that half.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
            "rounded-box",
            "Box with rounded edges and corners, centred at the origin, its edges along the axes.",
            "Quilez 2008, round box",
        ).size_params(3);
    const PARAMS: &'static [Param] = &[
        Param::length("x", 1.0, "Size along x, rounding included."),
        Param::length("y", 1.0, "Size along y, rounding included."),
        Param::length("z", 1.0, "Size along z, rounding included."),
        Param::length_or_zero("radius", 0.1, "Radius of the edges; at most half of the smallest size."),
    ];
    type Params<N: Real> = [N; 4];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [x, y, z, radius]: [N; 4]) -> N {
        let half = Vec3::new(x, y, z) * N::constant(0.5);
        let radius = radius.min(half.x.min(half.y.min(half.z))).named("limited_radius");
        let core = half - Vec3::splat(radius);
        let excess = p.abs() - core;
        let outside = excess.max(N::zero()).length();
        let inside = excess.largest().min(N::zero());
        outside + inside - radius
    }
    fn bounds([x, y, z, _radius]: [f32; 4]) -> Aabb {
        Aabb::centred(0.5 * x, 0.5 * y, 0.5 * z)
    }
}
