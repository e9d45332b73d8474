//! Object-safe form of a modifier: the trait behind which a field evaluates all modifiers.

use super::definition::Motion;
use crate::bounds::Aabb;
use crate::expression::identifier;
use crate::info::Info;
use crate::number::{Dual, Real, Vec3};
use crate::parameter::Param;
use std::fmt::Debug;
use wide::f32x8;

/// Functions of a modifier over one number type: `f32` for one point, `f32x8` for eight.
pub trait EvalModifier<N: Real> {
    /// Point `p` in the child's space, for the domain copy of this index.
    fn point(&self, p: Vec3<N>, copy: N, coefficients: &[f32]) -> Vec3<N>;
    /// The same point with its derivatives over `p`.
    fn point_gradient(&self, p: Vec3<N>, copy: N, coefficients: &[f32]) -> Vec3<Dual<N>>;
    /// Distance of the result, metres.
    fn distance(&self, p: Vec3<N>, inside: N, coefficients: &[f32]) -> N;
    /// Distance and gradient of the result.
    fn gradient(&self, p: Vec3<N>, inside: Dual<N>, coefficients: &[f32]) -> Dual<N>;
}

/// A modifier as a field evaluates it: object-safe, with all its number types.
///
/// Registered modifiers get it from their [`ModifierDef`](super::ModifierDef). Code that is generic over the number type calls
/// [`Batch::modifier`](crate::graph::Batch::modifier).
pub trait Modifier: EvalModifier<f32x8> + EvalModifier<f32> + Send + Sync {
    /// Name, documentation, source.
    fn info(&self) -> &'static Info;
    /// Parameters, in order.
    fn params(&self) -> &'static [Param];
    /// Reports whether the child must be bounded.
    fn needs_bounds(&self) -> bool;
    /// Reports whether it makes solids of profiles.
    fn of_profiles(&self) -> bool;
    /// Reports whether the child may be a profile.
    fn in_plane(&self) -> bool;
    /// Coefficients that the functions read, computed once from the parameters and the child's bounding box.
    fn coefficients(&self, params: &[f32], inside: Aabb) -> Vec<f32>;
    /// Number of domain copies to evaluate.
    fn copies(&self, params: &[f32], inside: Aabb) -> u32;
    /// Rigid motions of all copies of its child, if it does nothing but copy it, and there are at most `most`.
    fn motions(&self, params: &[f32], inside: Aabb, most: usize) -> Option<Vec<Motion>>;
    /// Distance from its surface within which the child must be exact, metres; see
    /// [`ModifierDef::inner_margin`](super::ModifierDef::inner_margin).
    fn inner_margin(&self, params: &[f32], inside: Aabb, margin: f32) -> Option<f32>;
    /// Bounding box of the result.
    fn bounds(&self, params: &[f32], inside: Aabb) -> Aabb;
    /// WGSL functions `NAME_point`, `NAME_pull` (pulls a gradient back through it), `NAME_distance` and `NAME_gradient`.
    fn wgsl(&self) -> String;
    /// Prefix of the names of its WGSL functions.
    fn wgsl_name(&self) -> String {
        identifier(&self.info().name).trim_end_matches('_').to_owned()
    }
}

impl Debug for dyn Modifier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.info().name)
    }
}
