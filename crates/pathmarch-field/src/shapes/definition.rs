//! Generic definition of a shape: what one file of `shapes/` implements.

use super::dispatch::{Emitter, Shape, TRAPS};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Values, Vec3};
use crate::parameter::Param;
use crate::ray_interval::RayInterval;

/// A shape, written once.
///
/// Implementations are unit structs named `Shape`, one in each file of `shapes/`.
pub trait ShapeDef: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// The parameters, in the order of positional arguments.
    const PARAMS: &'static [Param];
    /// As many numbers as there are parameters: `[N; K]`.
    type Params<N: Real>: Values<N>;

    /// Signed distance from `p` to the surface, metres, negative inside; a lower bound of it where not exact.
    fn distance<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N;
    /// The same distance, to the last bit, where little code matters more than speed: for gradients and for recording. A shape
    /// of many [variants](Self::variant) has one function here for all of them.
    #[inline(always)]
    fn distance_compact<N: Real>(p: Vec3<N>, params: Self::Params<N>) -> N {
        Self::distance(p, params)
    }
    /// A box that holds the solid.
    fn bounds(params: Self::Params<f32>) -> Aabb;
    /// An upper bound of |∇distance|.
    fn lipschitz(_params: Self::Params<f32>) -> f32 {
        1.0
    }
    /// What a light of this shape is sampled as.
    fn emitter(_params: Self::Params<f32>) -> Emitter {
        Emitter::Bounded
    }
    /// Whether the solid is convex and [`interval`](Self::interval) is written.
    const CONVEX: bool = false;
    /// Where a line is inside a convex solid, metres from `origin` along the unit vector `direction`.
    fn interval<N: Real>(_origin: Vec3<N>, _direction: Vec3<N>, _params: Self::Params<N>) -> RayInterval<N> {
        RayInterval::nowhere()
    }
    /// Whether where a ray meets this shape is known in closed form: [`interval`](Self::interval) or [`ray`](Self::ray) is written.
    const ANALYTIC: bool = Self::CONVEX;
    /// Metres from `origin` along the unit vector `direction` to the first point of the surface ahead, from outside or
    /// inside; [`T_MAX`] where there is none.
    #[inline(always)]
    fn ray<N: Real>(origin: Vec3<N>, direction: Vec3<N>, params: Self::Params<N>) -> N {
        Self::interval(origin, direction, params).ahead()
    }
    /// Tells apart the shapes that [`variant`](Self::variant) gives, which have this one's name; 0 for the one of the list.
    const VARIANT: u32 = 0;
    /// The same shape with some of its numbers fixed in its code, which then is faster.
    fn variant(_params: Self::Params<f32>) -> Option<&'static dyn Shape> {
        None
    }
    /// Whether [`orbit`](Self::orbit) is written: the shape is a fractal, which follows the orbit of a point.
    const ORBIT: bool = false;
    /// What the orbit of `p` comes near to: its least distance to the origin, to the y axis, to the plane y = 0 and to the
    /// unit sphere, and the share of the iterations that were done before it escaped, 0..1.
    fn orbit<N: Real>(_p: Vec3<N>, _params: Self::Params<N>) -> [N; TRAPS] {
        [N::zero(); TRAPS]
    }
}
