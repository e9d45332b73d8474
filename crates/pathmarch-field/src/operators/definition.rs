//! Generic definition of an operator: what one file of `operators/` implements.

use super::dispatch::Boolean;
use crate::blend::{Blend, Blending};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::Real;
use crate::parameter::Param;

/// Definition of an operator, which combines two solids, written once for all number types.
///
/// More than two children are folded from the first to the last. Each file of `operators/` implements it for a unit struct
/// named `Op`.
pub trait OperatorDef: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// Parameters: none if it blends, else one, which is the [`Blend::amount`].
    const PARAMS: &'static [Param] = &[];
    /// True if it blends edges over a width, with any [`BlendProfile`](crate::BlendProfile).
    const BLENDS: bool = true;
    /// Least and largest number of children.
    const CHILDREN: (usize, usize) = (1, usize::MAX);
    /// Boolean operation on solids that the sharp operator is.
    const BOOLEAN: Option<Boolean> = None;
    /// Distance of the sharp result.
    fn sharp<N: Real>(a: N, b: N) -> N;
    /// Distance of the blended result.
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N;
    /// Weight of `b`'s material in the sharp result, 0..1.
    fn sharp_weight<N: Real>(a: N, b: N) -> N;
    /// Weight of `b`'s material in the blended result, 0..1.
    fn blended_weight<N: Real>(a: N, b: N, blend: Blending<N>) -> N;
    /// Bounding box of the result.
    fn bounds(a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb;
}
