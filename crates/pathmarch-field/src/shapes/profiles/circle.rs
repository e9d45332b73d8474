//! Circle in the xy plane (Quilez 2008, "2D distance functions", circle). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info =
        Info::new("circle", "Profile: a disc around the origin.", "Quilez 2008, circle").profile();
    const PARAMS: &'static [Param] = &[Param::length("radius", 0.5, "From the origin to the edge.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        p.x.hypot(p.y) - radius
    }
    fn bounds([radius]: [f32; 1]) -> Aabb {
        Aabb::centred(radius, radius, f32::INFINITY)
    }
}
