//! Rectangle in the xy plane, with optional round corners (Quilez 2008, "2D distance functions", box and rounded
//! box). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new("rectangle", "Profile: a rectangle around the origin.", "Quilez 2008, rounded box").profile().size_params(2);
    const PARAMS: &'static [Param] = &[
        Param::length("x", 1.0, "Edge length along x."),
        Param::length("y", 1.0, "Edge length along y."),
        Param::length_or_zero("radius", 0.0, "Radius of the corners, at most half of the smaller edge."),
    ];
    type Params<N: Real> = [N; 3];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [x, y, radius]: [N; 3]) -> N {
        let half = N::constant(0.5);
        let radius = radius.min(half * x.min(y)).named("radius");
        let past_x = (p.x.abs() - half * x + radius).named("past_x");
        let past_y = (p.y.abs() - half * y + radius).named("past_y");
        past_x.max(N::zero()).hypot(past_y.max(N::zero())) + past_x.max(past_y).min(N::zero()) - radius
    }
    fn bounds([x, y, _]: [f32; 3]) -> Aabb {
        Aabb::centred(0.5 * x, 0.5 * y, f32::INFINITY)
    }
}
