//! Number types with which the CPU evaluates a field: `f32` for one point, `f32x8` for eight.
//!
//! Shapes, operators and modifiers are `dyn`, which have no generic methods. Each number type converts them to the trait
//! object of its own functions.

use crate::modifiers::{EvalModifier, Modifier};
use crate::number::{Differentiable, Mask8};
use crate::operators::{EvalOperator, Operator};
use crate::shapes::{EvalShape, Shape};
use wide::f32x8;

/// Number type with which the CPU evaluates a [`Field`](super::Field).
pub trait Batch: Differentiable {
    /// One random seed for each point.
    type Seeds: Copy;
    /// Number of points.
    #[doc(hidden)]
    const LANES: usize;
    /// A bit for each point.
    #[doc(hidden)]
    fn bits(mask: Self::Mask) -> u32;
    #[doc(hidden)]
    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        Self::bits(mask) != 0
    }
    #[doc(hidden)]
    fn lanes(self) -> [f32; 8];
    #[doc(hidden)]
    fn from_lanes(lanes: [f32; 8]) -> Self;
    /// Functions of a shape over this number type.
    fn shape(shape: &dyn Shape) -> &dyn EvalShape<Self>;
    /// Functions of an operator over this number type.
    fn operator(operator: &'static dyn Operator) -> &'static dyn EvalOperator<Self>;
    /// Functions of a modifier over this number type.
    fn modifier(modifier: &'static dyn Modifier) -> &'static dyn EvalModifier<Self>;
    /// Uniform number in 0..1 for the choice of this index at each point.
    #[doc(hidden)]
    fn choice(seeds: Self::Seeds, index: u32) -> Self;
}

/// Conversions to the functions of one number type, the same text for every implementation of [`Batch`].
macro_rules! upcasts {
    () => {
        #[inline(always)]
        fn shape(shape: &dyn Shape) -> &dyn EvalShape<Self> {
            shape
        }
        #[inline(always)]
        fn operator(operator: &'static dyn Operator) -> &'static dyn EvalOperator<Self> {
            operator
        }
        #[inline(always)]
        fn modifier(modifier: &'static dyn Modifier) -> &'static dyn EvalModifier<Self> {
            modifier
        }
    };
}

impl Batch for f32 {
    type Seeds = u32;
    const LANES: usize = 1;
    upcasts!();
    #[inline(always)]
    fn bits(mask: bool) -> u32 {
        u32::from(mask)
    }
    #[inline(always)]
    fn lanes(self) -> [f32; 8] {
        [self; 8]
    }
    #[inline(always)]
    fn from_lanes(lanes: [f32; 8]) -> f32 {
        lanes[0]
    }
    fn choice(seed: u32, index: u32) -> f32 {
        // PCG output hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"); its WGSL is in compose.rs.
        let state = (seed ^ index.wrapping_mul(0x9e37_79b9)).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
    }
}

impl Batch for f32x8 {
    type Seeds = [u32; 8];
    const LANES: usize = 8;
    upcasts!();
    #[inline(always)]
    fn bits(mask: Mask8) -> u32 {
        mask.0.to_bitmask()
    }
    #[inline(always)]
    fn lanes(self) -> [f32; 8] {
        self.to_array()
    }
    #[inline(always)]
    fn from_lanes(lanes: [f32; 8]) -> f32x8 {
        f32x8::from(lanes)
    }
    fn choice(seeds: [u32; 8], index: u32) -> f32x8 {
        f32x8::from(seeds.map(|seed| f32::choice(seed, index)))
    }
}
