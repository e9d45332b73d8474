//! Object-safe form of an operator: the trait behind which a field evaluates all operators.

use crate::blend::{Blend, BlendProfile};
use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Dual, Real};
use crate::parameter::Param;
use std::fmt::Debug;
use wide::f32x8;

/// Boolean operation on two solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boolean {
    /// Points in either.
    Union,
    /// Points in both.
    Intersection,
    /// Points in the first and not in the second.
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
    /// Parameters, in order; see [`OperatorDef::PARAMS`](super::OperatorDef::PARAMS).
    fn params(&self) -> &'static [Param];
    /// Reports whether it blends edges over a width.
    fn blends(&self) -> bool;
    /// Least and largest number of children.
    fn children(&self) -> (usize, usize);
    /// Boolean operation that the sharp operator is; see [`OperatorDef::BOOLEAN`](super::OperatorDef::BOOLEAN).
    fn boolean(&self) -> Option<Boolean>;
    /// Bounding box of the result.
    fn bounds(&self, a: Aabb, b: Aabb, blend: Option<Blend>) -> Aabb;
    /// WGSL function `NAME_distance`, sharp or with a blend profile.
    fn wgsl_distance(&self, profile: Option<BlendProfile>) -> String;
    /// WGSL function `NAME_gradient` over gradient (xyz) and distance (w), sharp or with a blend profile.
    fn wgsl_gradient(&self, profile: Option<BlendProfile>) -> String;
    /// WGSL function `NAME_weight`, sharp or with a blend profile.
    fn wgsl_weight(&self, profile: Option<BlendProfile>) -> String;
    /// Prefix of the names of its WGSL functions.
    fn wgsl_name(&self, profile: Option<BlendProfile>) -> String {
        let prefix = profile.filter(|_| self.blends()).map_or(String::new(), |profile| format!("{}_", profile.name()));
        format!("{prefix}{}", self.info().name)
    }
}

impl Debug for dyn Operator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.info().name)
    }
}
