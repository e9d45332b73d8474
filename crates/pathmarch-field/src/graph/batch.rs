//! The numbers that a field can be evaluated over on the CPU: one point, or eight at once.
//!
//! Shapes and operators are called by way of `dyn`, which has no generic methods: each number says which method it calls.

use crate::blend::Blend;
use crate::number::{Differentiable, Dual, Mask8, Vec3};
use crate::registry::{Combine, Modify, Shape, Span};
use wide::f32x8;

/// A number that a [`Field`](super::Field) can be evaluated over on the CPU.
pub trait Batch: Differentiable {
    /// One seed for each point.
    type Seeds: Copy;
    /// How many points.
    #[doc(hidden)]
    const LANES: usize;
    #[doc(hidden)]
    fn any(mask: Self::Mask) -> bool;
    #[doc(hidden)]
    fn lanes(self) -> [f32; 8];
    #[doc(hidden)]
    fn from_lanes(lanes: [f32; 8]) -> Self;
    #[doc(hidden)]
    fn shape_distance(shape: &dyn Shape, p: Vec3<Self>, params: &[f32]) -> Self;
    #[doc(hidden)]
    fn shape_gradient(shape: &dyn Shape, p: Vec3<Dual<Self>>, params: &[f32]) -> Dual<Self>;
    #[doc(hidden)]
    fn shape_ray(shape: &dyn Shape, origin: Vec3<Self>, direction: Vec3<Self>, params: &[f32]) -> Self;
    #[doc(hidden)]
    fn shape_span(shape: &dyn Shape, origin: Vec3<Self>, direction: Vec3<Self>, params: &[f32]) -> Span<Self>;
    #[doc(hidden)]
    fn modified_point(modifier: &dyn Modify, p: Vec3<Self>, place: Self, numbers: &[f32]) -> Vec3<Self>;
    #[doc(hidden)]
    fn modified_point_gradient(modifier: &dyn Modify, p: Vec3<Self>, place: Self, numbers: &[f32]) -> Vec3<Dual<Self>>;
    #[doc(hidden)]
    fn modified(modifier: &dyn Modify, p: Vec3<Self>, inside: Self, numbers: &[f32]) -> Self;
    #[doc(hidden)]
    fn modified_gradient(modifier: &dyn Modify, p: Vec3<Self>, inside: Dual<Self>, numbers: &[f32]) -> Dual<Self>;
    #[doc(hidden)]
    fn combined(operator: &dyn Combine, a: Self, b: Self, blend: Option<Blend>) -> Self;
    #[doc(hidden)]
    fn combined_gradient(operator: &dyn Combine, a: Dual<Self>, b: Dual<Self>, blend: Option<Blend>) -> Dual<Self>;
    #[doc(hidden)]
    fn weight(operator: &dyn Combine, a: Self, b: Self, blend: Option<Blend>) -> Self;
    /// A uniform number in 0..1 for the choice of this index at each point.
    #[doc(hidden)]
    fn choice(seeds: Self::Seeds, index: u32) -> Self;
}

/// The calls of an implementation of [`Batch`], given the methods of shapes, modifiers and operators for its numbers.
macro_rules! calls {
    ($distance:ident, $gradient:ident, $ray:ident, $span:ident, $point:ident, $point_gradient:ident, $weight:ident) => {
        fn shape_distance(shape: &dyn Shape, p: Vec3<Self>, params: &[f32]) -> Self {
            shape.$distance(p, params)
        }
        fn shape_gradient(shape: &dyn Shape, p: Vec3<Dual<Self>>, params: &[f32]) -> Dual<Self> {
            shape.$gradient(p, params)
        }
        fn shape_ray(shape: &dyn Shape, origin: Vec3<Self>, direction: Vec3<Self>, params: &[f32]) -> Self {
            shape.$ray(origin, direction, params)
        }
        fn shape_span(shape: &dyn Shape, origin: Vec3<Self>, direction: Vec3<Self>, params: &[f32]) -> Span<Self> {
            shape.$span(origin, direction, params)
        }
        fn modified_point(modifier: &dyn Modify, p: Vec3<Self>, place: Self, numbers: &[f32]) -> Vec3<Self> {
            modifier.$point(p, place, numbers)
        }
        fn modified_point_gradient(
            modifier: &dyn Modify,
            p: Vec3<Self>,
            place: Self,
            numbers: &[f32],
        ) -> Vec3<Dual<Self>> {
            modifier.$point_gradient(p, place, numbers)
        }
        fn modified(modifier: &dyn Modify, p: Vec3<Self>, inside: Self, numbers: &[f32]) -> Self {
            modifier.$distance(p, inside, numbers)
        }
        fn modified_gradient(modifier: &dyn Modify, p: Vec3<Self>, inside: Dual<Self>, numbers: &[f32]) -> Dual<Self> {
            modifier.$gradient(p, inside, numbers)
        }
        fn combined(operator: &dyn Combine, a: Self, b: Self, blend: Option<Blend>) -> Self {
            operator.$distance(a, b, blend)
        }
        fn combined_gradient(operator: &dyn Combine, a: Dual<Self>, b: Dual<Self>, blend: Option<Blend>) -> Dual<Self> {
            operator.$gradient(a, b, blend)
        }
        fn weight(operator: &dyn Combine, a: Self, b: Self, blend: Option<Blend>) -> Self {
            operator.$weight(a, b, blend)
        }
    };
}

impl Batch for f32 {
    type Seeds = u32;
    const LANES: usize = 1;
    calls!(distance, gradient, ray, span, point, point_gradient, weight);
    fn any(mask: bool) -> bool {
        mask
    }
    fn lanes(self) -> [f32; 8] {
        [self; 8]
    }
    fn from_lanes(lanes: [f32; 8]) -> f32 {
        lanes[0]
    }
    fn choice(seed: u32, index: u32) -> f32 {
        // PCG output hash (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"); the WGSL twin is in compose.rs.
        let state = (seed ^ index.wrapping_mul(0x9e37_79b9)).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
    }
}

impl Batch for f32x8 {
    type Seeds = [u32; 8];
    const LANES: usize = 8;
    calls!(distance_lanes, gradient_lanes, ray_lanes, span_lanes, point_lanes, point_gradient_lanes, weight_lanes);
    fn any(mask: Mask8) -> bool {
        mask.0.to_bitmask() != 0
    }
    fn lanes(self) -> [f32; 8] {
        self.to_array()
    }
    fn from_lanes(lanes: [f32; 8]) -> f32x8 {
        f32x8::from(lanes)
    }
    fn choice(seeds: [u32; 8], index: u32) -> f32x8 {
        f32x8::from(seeds.map(|seed| f32::choice(seed, index)))
    }
}
