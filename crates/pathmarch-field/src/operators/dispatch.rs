//! Object-safe form of an operator: the trait behind which a field evaluates all operators.

use crate::blend::{Blend, BlendProfile};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Dual, Real};
use crate::parameter::Param;
use std::fmt::Debug;
use wide::f32x8;

/// An operation on truth values: what two solids hold together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boolean {
    /// Either.
    Union,
    /// Both.
    Intersection,
    /// The first, without the second.
    Difference,
}

/// Functions of an operator over one number type: `f32` for one point, `f32x8` for eight.
///
/// The result is sharp without `blend`.
pub trait EvalOperator<N: Real> {
    /// Distance of the result, metres.
    fn distance(&self, a: N, b: N, blend: Option<Blend>) -> N;
    /// Distance and gradient of the result.
    fn gradient(&self, a: Dual<N>, b: Dual<N>, blend: Option<Blend>) -> Dual<N>;
    /// Weight of `b`'s material, 0..1.
    fn weight(&self, a: N, b: N, blend: Option<Blend>) -> N;
}

/// An operator as a field evaluates it: object-safe, with all its number types.
///
/// Registered operators get it from their [`OperatorDef`](super::OperatorDef). Code that is generic over the number type calls
/// [`Batch::operator`](crate::graph::Batch::operator).
pub trait Operator: EvalOperator<f32x8> + EvalOperator<f32> + Send + Sync {
    /// Name, documentation, source.
    fn info(&self) -> &'static Info;
    /// The parameters, in order; see [`OperatorDef::PARAMS`](super::OperatorDef::PARAMS).
    fn params(&self) -> &'static [Param];
    /// Whether it blends edges over a width.
    fn blends(&self) -> bool;
    /// How many children it needs, and how many it may have.
    fn children(&self) -> (usize, usize);
    /// What it does to solids; see [`OperatorDef::BOOLEAN`](super::OperatorDef::BOOLEAN).
    fn boolean(&self) -> Option<Boolean>;
    /// A box that holds the result.
    fn bounds(&self, a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb;
    /// `NAME_distance`, sharp or of a profile, as a WGSL function.
    fn wgsl_distance(&self, profile: Option<BlendProfile>) -> String;
    /// `NAME_gradient`, sharp or of a profile, as a WGSL function over (xyz gradient, w distance).
    fn wgsl_gradient(&self, profile: Option<BlendProfile>) -> String;
    /// `NAME_weight`, sharp or of a profile, as a WGSL function.
    fn wgsl_weight(&self, profile: Option<BlendProfile>) -> String;
    /// What its WGSL functions' names begin with.
    fn wgsl_name(&self, profile: Option<BlendProfile>) -> String {
        let prefix = profile.filter(|_| self.blends()).map_or(String::new(), |profile| format!("{}_", profile.name()));
        format!("{prefix}{}", self.info().name)
    }
}

impl Debug for dyn Operator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.info().name)
    }
}
