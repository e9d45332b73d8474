//! Generic definition of a shape: what one file of `shapes/` implements.

use super::dispatch::{Emitter, Shape, TRAPS};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Values, Vec3};
use crate::parameter::Param;
use crate::ray_interval::RayInterval;

/// Definition of a shape, written once for all number types.
///
/// Each file of `shapes/` implements it for a unit struct named `Shape`.
pub trait ShapeDef: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// Parameters, in the order of positional arguments.
    const PARAMS: &'static [Param];
    /// Parameter values: `[N; K]` for `K` parameters.
    type Params<N: Real>: Values<N>;

    /// Signed distance from `p` to the surface, metres, negative inside; a lower bound of it where it is not exact.
    fn distance<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N;
    /// The same distance, equal to the last bit, in little code: for gradients and for recording. A shape with many
    /// [variants](Self::variant) has one function here for all of them.
    #[inline(always)]
    fn distance_compact<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N {
        Self::distance(p, params)
    }
    /// Distance to the face or curved side that an analytic hit `p` is on: [`distance`](Self::distance) in less code, and only
    /// there. On an edge it is that of either face.
    #[inline(always)]
    fn distance_at_hit<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N {
        Self::distance_compact(p, params)
    }
    /// Bounding box of the solid.
    fn bounds(params: Self::Params<f32>) -> Aabb;
    /// Lipschitz constant: an upper bound of |∇distance|.
    fn lipschitz(_params: Self::Params<f32>) -> f32 {
        1.0
    }
    /// Surface on which a light of this shape is sampled.
    fn emitter(_params: Self::Params<f32>) -> Emitter {
        Emitter::Bounded
    }
    /// Area of the surface, of a sheet that of one side, square metres; `None` where there is no formula.
    fn area(_params: Self::Params<f32>) -> Option<f32> {
        None
    }
    /// True if the solid is convex and [`interval`](Self::interval) is implemented.
    const CONVEX: bool = false;
    /// Interval of a line inside a convex solid, metres from `origin` along the unit vector `direction`.
    fn interval<N: Real>(_origin: Vec3<N>, _direction: Vec3<N>, _params: Self::Params<N>) -> RayInterval<N> {
        RayInterval::empty()
    }
    /// True if rays intersect it analytically: [`interval`](Self::interval) or [`ray`](Self::ray) is implemented.
    const ANALYTIC: bool = Self::CONVEX;
    /// Metres from `origin` along the unit vector `direction` to the first hit, from outside or inside; [`T_MAX`](crate::T_MAX) if the ray
    /// misses.
    #[inline(always)]
    fn ray<N: Real>(origin: Vec3<N>, direction: Vec3<N>, params: Self::Params<N>) -> N {
        Self::interval(origin, direction, params).first_hit()
    }
    /// Number of a [`variant`](Self::variant) among shapes of the same name; 0 for the registered one.
    const VARIANT: u32 = 0;
    /// Faster variant of the shape with some parameters fixed at compile time.
    fn variant(_params: Self::Params<f32>) -> Option<&'static dyn Shape> {
        None
    }
    /// True for a fractal, which implements [`orbit`](Self::orbit).
    const ORBIT: bool = false;
    /// Orbit traps of `p` about `centre`: the least distances of its orbit to the centre, the line through it along y, the
    /// plane through it across y and the unit sphere about it; the largest distance to the centre; and the fraction of
    /// iterations before it escaped, 0..1.
    fn orbit<N: Real>(_p: Vec3<N>, _centre: Vec3<N>, _params: Self::Params<N>) -> [N; TRAPS] {
        [N::zero(); TRAPS]
    }
}
