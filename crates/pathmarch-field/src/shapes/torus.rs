//! Torus about y: in the half-plane through the axis it is a circle (Hart 1996, appendix A). Exact.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;
use std::f32::consts::PI;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info =
        Info::new("torus", "Ring about the y axis, centred at the origin.", "Hart 1996, appendix A");
    const PARAMS: &'static [Param] = &[
        Param::length("major", 1.0, "Radius of the ring, from the axis to the middle of the tube."),
        Param::length("minor", 0.25, "Radius of the tube."),
    ];
    type Params<N: Real> = [N; 2];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [major, minor]: [N; 2]) -> N {
        let from_ring = (p.x.hypot(p.z) - major).named("from_ring");
        from_ring.hypot(p.y) - minor
    }
    fn area([major, minor]: [f32; 2]) -> Option<f32> {
        // A ring that overlaps itself has no formula.
        (minor <= major).then_some(4.0 * PI * PI * major * minor)
    }
    fn bounds([major, minor]: [f32; 2]) -> Aabb {
        Aabb::centred(major + minor, minor, major + minor)
    }
}
