//! Sphere: the distance to a point, less the radius (Hart 1996, "Sphere tracing", appendix A). Exact.

use crate::bounds::Aabb;
use crate::number::{Real, Vec3};
use crate::registry::{Emitter, Info, NO_HIT, Param, Primitive};

pub(crate) struct Shape;

impl Primitive for Shape {
    const INFO: Info = Info::new("sphere", "Sphere centred at the origin.", "Hart 1996, appendix A");
    const PARAMS: &'static [Param] = &[Param::length("radius", 1.0, "Distance from the centre to the surface.")];
    type Params<N: Real> = [N; 1];

    #[inline(always)]
    fn distance<N: Real>(p: Vec3<N>, [radius]: [N; 1]) -> N {
        p.length() - radius
    }
    const CLOSED_FORM: bool = true;
    /// The quadratic in the form that does not cancel (Haines et al. 2019, "Precision Improvements for Ray/Sphere
    /// Intersection").
    #[inline(always)]
    fn ray<N: Real>(origin: Vec3<N>, direction: Vec3<N>, [radius]: [N; 1]) -> N {
        let along = origin.dot(direction).named("along");
        let across = origin - direction * along;
        let square = (radius * radius - across.dot(across)).named("square");
        let half_chord = square.max(N::zero()).sqrt();
        let q = (-along - half_chord * along.sign()).named("q");
        let other = (origin.dot(origin) - radius * radius) / q.divisor();
        let (near, far) = (q.min(other), q.max(other));
        let no_hit = N::constant(NO_HIT);
        let ahead = N::select(N::zero().lt(near), near, N::select(N::zero().lt(far), far, no_hit));
        N::select(N::zero().lt(square), ahead, no_hit)
    }
    fn emitter([radius]: [f32; 1]) -> Emitter {
        Emitter::Sphere(radius)
    }
    fn bounds([radius]: [f32; 1]) -> Aabb {
        Aabb::centred(radius, radius, radius)
    }
}
