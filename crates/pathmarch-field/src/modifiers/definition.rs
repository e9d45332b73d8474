//! Generic definition of a modifier: what one file of `modifiers/` implements.

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Real, Values, Vec3};
use crate::parameter::Param;

/// An operator that changes the space in which what it holds stands, or its distance, written once.
///
/// What it holds is one solid: the union of its children. Implementations are unit structs named `Op`, one in each file of
/// `modifiers/`.
pub trait ModifierDef: Send + Sync + 'static {
    /// Name, documentation, source.
    const INFO: Info;
    /// The parameters, in the order of positional arguments.
    const PARAMS: &'static [Param];
    /// The coefficients that the functions below read: `[N; K]`.
    type Coefficients<N: Real>: Values<N>;
    /// Whether it needs what it holds to have an end.
    const NEEDS_BOUNDS: bool = false;
    /// Whether it makes solids of profiles, and of solids their slice at z = 0.
    const OF_PROFILES: bool = false;
    /// Whether it moves points only within planes across z, so that it may hold profiles.
    const IN_PLANE: bool = true;

    /// The coefficients, found once of the parameters and of the box that holds what it holds.
    fn coefficients(params: &[f32], inside: Aabb) -> Self::Coefficients<f32>;
    /// In how many copies what it holds must be looked for; [`point`](Self::point) tells them apart.
    fn copies(_params: &[f32], _inside: Aabb) -> u32 {
        1
    }
    /// Where `p` is in the space of what it holds; `copy` counts from 0.
    fn point<N: Real>(p: Vec3<N>, _place: N, _numbers: Self::Coefficients<N>) -> Vec3<N> {
        p
    }
    /// The distance at `p`, given the least one of what it holds at the points of `p`.
    fn distance<N: Real>(_p: Vec3<N>, inside: N, _numbers: Self::Coefficients<N>) -> N {
        inside
    }
    /// A box that holds the result.
    fn bounds(params: &[f32], inside: Aabb) -> Aabb;
}
