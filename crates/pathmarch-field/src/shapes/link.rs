//! Chain link: a torus cut in half and pulled apart along y. Between the halves space is folded flat, which leaves the
//! torus's distance (Quilez 2008, "Distance functions", link). Exact. `length` is that of the straight parts, as the
//! height of a capsule: the whole is `length + 2 (major + minor)` long. Quilez's is half of it.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Vec3};
use crate::parameter::Param;
use crate::shapes::ShapeDef;

pub(crate) struct Shape;

impl ShapeDef for Shape {
    const INFO: Info = Info::new(
        "link",
        "Chain link in the plane z = 0, long along y, centred at the origin.",
        "Quilez 2008, link",
    );
    const PARAMS: &'static [Param] = &[
        Param::length_or_zero("length", 0.5, "Length of the straight parts."),
        Param::length("major", 0.3, "Radius of the half rings, to the middle of the tube."),
        Param::length("minor", 0.1, "Radius of the tube."),
    ];
    type Params<N: Real> = [N; 3];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [length, major, minor]: [N; 3]) -> N {
        let past_straight = (p.y.abs() - length * N::constant(0.5)).max(N::zero()).named("past_straight");
        let from_ring = (p.x.hypot(past_straight) - major).named("from_ring");
        from_ring.hypot(p.z) - minor
    }
    fn bounds([length, major, minor]: [f32; 3]) -> Aabb {
        Aabb::centred(major + minor, 0.5 * length + major + minor, minor)
    }
}
