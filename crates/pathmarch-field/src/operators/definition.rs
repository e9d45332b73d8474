//! Generic definition of an operator: what one file of `operators/` implements.

use super::dispatch::Boolean;
use crate::blend::{Blend, Blending};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::Real;
use crate::parameter::Param;

/// An operator that makes one solid of two, written once.
///
/// More than two children are folded from the first to the last. Implementations are unit structs named `Shape`'s twin
/// `Op`, one in each file of `operators/`.
pub trait OperatorDef: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// The parameters: none where it blends, one that is the [`Blend::amount`] where it does not.
    const PARAMS: &'static [Param] = &[];
    /// Whether it blends edges over a width, by any [`BlendProfile`].
    const BLENDS: bool = true;
    /// How many children it needs, and how many it may have.
    const CHILDREN: (usize, usize) = (1, usize::MAX);
    /// What it does to solids, where it is sharp, as an operation on truth values.
    const BOOLEAN: Option<Boolean> = None;
    /// The sharp result.
    fn sharp<N: Real>(a: N, b: N) -> N;
    /// The blended result.
    fn blended<N: Real>(a: N, b: N, blend: Blending<N>) -> N;
    /// How much of `b`'s material shows, 0..1, in the sharp result.
    fn sharp_weight<N: Real>(a: N, b: N) -> N;
    /// How much of `b`'s material shows, 0..1, in the blended result.
    fn blended_weight<N: Real>(a: N, b: N, blend: Blending<N>) -> N;
    /// A box that holds the result.
    fn bounds(a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb;
}
