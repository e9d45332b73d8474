//! [`Real`] for `f32x8`: one lane for each of eight points.

use super::{Differentiable, Dual, Real};
use std::ops::{BitAnd, BitOr, Not};
use wide::{Select, f32x8};

/// Eight truth values: all bits of a lane set, or none.
#[derive(Clone, Copy)]
pub struct Mask8(pub f32x8);

impl BitAnd for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask8 {
    #[inline(always)]
    fn all_true() -> Self {
        Self(f32x8::splat(0.0).simd_lt(f32x8::splat(1.0)))
    }
}

impl Real for f32x8 {
    type Mask = Mask8;

    #[inline(always)]
    fn constant(value: f32) -> Self {
        f32x8::splat(value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x8::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32x8::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        f32x8::fast_min(self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        f32x8::fast_max(self, other)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f32x8::floor(self)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        f32x8::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        f32x8::cos(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        f32x8::atan2(self, x)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f32x8::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f32x8::ln(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask8 {
        Mask8(self.simd_lt(other))
    }
    #[inline(always)]
    fn truth(value: bool) -> Mask8 {
        let all = Mask8::all_true();
        if value { all } else { !all }
    }
    #[inline(always)]
    fn select(mask: Mask8, yes: Self, no: Self) -> Self {
        Select::select(mask.0, yes, no)
    }
    #[inline(always)]
    fn vector(table: &[f32], index: Self) -> [Self; 4] {
        let vectors = index.to_array().map(|index| f32::vector(table, index));
        std::array::from_fn(|k| f32x8::from(vectors.map(|vector| vector[k])))
    }
    #[inline(always)]
    fn vectors(table: &[f32], index: Self) -> [[Self; 4]; 2] {
        let last = (table.len() / 4).saturating_sub(2);
        let indices = index.to_array();
        let mut rows = [f32x8::ZERO; 8];
        for (row, index) in rows.iter_mut().zip(indices) {
            let start = 4 * (index as usize).min(last);
            if let Some(numbers) = table.get(start..).and_then(<[f32]>::first_chunk::<8>) {
                *row = f32x8::from(*numbers);
            }
        }
        let [a, b, c, d, e, f, g, h] = f32x8::transpose(rows);
        [[a, b, c, d], [e, f, g, h]]
    }
    #[inline(always)]
    fn iterate<const K: usize>(
        count: Self,
        limit: u32,
        mut state: [Self; K],
        body: impl Fn([Self; K]) -> ([Self; K], Mask8),
    ) -> [Self; K] {
        let mut active = Mask8::all_true();
        for _ in 0..(count.to_array()[0] as u32).min(limit) {
            let (next, go_on) = body(state);
            state = std::array::from_fn(|k| <Self as Real>::select(active, next[k], state[k]));
            active = active & go_on;
            if !active.0.any() {
                break;
            }
        }
        state
    }
}

impl Differentiable for f32x8 {
    #[inline(always)]
    fn iterate_dual<const K: usize>(
        count: Dual<Self>,
        limit: u32,
        mut state: [Dual<Self>; K],
        body: impl Fn([Dual<Self>; K]) -> ([Dual<Self>; K], Mask8),
    ) -> [Dual<Self>; K] {
        let mut active = Mask8::all_true();
        for _ in 0..(count.value.to_array()[0] as u32).min(limit) {
            let (next, go_on) = body(state);
            state = std::array::from_fn(|k| Real::select(active, next[k], state[k]));
            active = active & go_on;
            if !active.0.any() {
                break;
            }
        }
        state
    }
}
