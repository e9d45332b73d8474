//! [`Real`] for `f32`: one point.

use super::{Differentiable, Dual, Real};

impl Real for f32 {
    type Mask = bool;

    #[inline(always)]
    fn constant(value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self < other { other } else { self }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        f32::floor(self)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        f32::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        f32::cos(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        f32::atan2(self, x)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        f32::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        f32::ln(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn truth(value: bool) -> bool {
        value
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn vector(table: &[f32], index: Self) -> [Self; 4] {
        let last = (table.len() / 4).saturating_sub(1);
        let start = 4 * (index as usize).min(last);
        table.get(start..start + 4).map_or([0.0; 4], |vector| [vector[0], vector[1], vector[2], vector[3]])
    }
    #[inline(always)]
    fn iterate<const K: usize>(
        count: Self,
        limit: u32,
        mut state: [Self; K],
        body: impl Fn([Self; K]) -> ([Self; K], bool),
    ) -> [Self; K] {
        for _ in 0..(count as u32).min(limit) {
            let (next, go_on) = body(state);
            state = next;
            if !go_on {
                break;
            }
        }
        state
    }
}

impl Differentiable for f32 {
    #[inline(always)]
    fn iterate_dual<const K: usize>(
        count: Dual<Self>,
        limit: u32,
        mut state: [Dual<Self>; K],
        body: impl Fn([Dual<Self>; K]) -> ([Dual<Self>; K], bool),
    ) -> [Dual<Self>; K] {
        for _ in 0..(count.value as u32).min(limit) {
            let (next, go_on) = body(state);
            state = next;
            if !go_on {
                break;
            }
        }
        state
    }
}
