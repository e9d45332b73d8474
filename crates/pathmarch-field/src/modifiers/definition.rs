//! Generic definition of a modifier: what one file of `modifiers/` implements.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Values, Vec3};
use crate::parameter::Param;

/// Rigid motion of a copy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Rotation about the y axis, radians, right-handed.
    pub turn: f32,
    /// Translation after the rotation, metres.
    pub offset: [f32; 3],
}

/// Definition of a modifier, which changes the domain or the distance of its child, e.g. twist, repeat, shell.
///
/// The child is one solid: the union of the modifier's children. Each file of `modifiers/` implements it for a unit struct
/// named `Op`.
pub trait ModifierDef: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// Parameters, in the order of positional arguments.
    const PARAMS: &'static [Param];
    /// Coefficients that the functions read: `[N; K]`.
    type Coefficients<N: Real>: Values<N>;
    /// True if the child must be bounded.
    const NEEDS_BOUNDS: bool = false;
    /// True if it makes solids of profiles, and of solids their slice at z = 0.
    const OF_PROFILES: bool = false;
    /// True if it moves points only in planes across z, so that its child may be a profile.
    const IN_PLANE: bool = true;

    /// Computes the coefficients, once, from the parameters and the child's bounding box.
    fn coefficients(params: &[f32], inside: Aabb) -> Self::Coefficients<f32>;
    /// Number of domain copies to evaluate; [`point`](Self::point) takes the index of one.
    fn copies(_params: &[f32], _inside: Aabb) -> u32 {
        1
    }
    /// Rigid motions of all copies of its child, if it does nothing but copy it, and there are at most `most`.
    fn motions(_params: &[f32], _inside: Aabb, _most: usize) -> Option<Vec<Motion>> {
        None
    }
    /// Point `p` in the child's space, for the domain copy of this index, from 0.
    fn point<N: Real>(p: Vec3<N>, _place: N, _numbers: Self::Coefficients<N>) -> Vec3<N> {
        p
    }
    /// Distance of the result at `p`, given the child's least distance over all copies.
    fn distance<N: Real>(_p: Vec3<N>, inside: N, _numbers: Self::Coefficients<N>) -> N {
        inside
    }
    /// Distance from its surface within which the child must be exact, metres, if the result has to be exact within `margin` of
    /// its own. Elsewhere both may be nearer to zero. `None` if there is no such distance.
    fn inner_margin(_params: &[f32], _inside: Aabb, margin: f32) -> Option<f32> {
        Some(margin)
    }
    /// Bounding box of the result.
    fn bounds(params: &[f32], inside: Aabb) -> Aabb;
}
