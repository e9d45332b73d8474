//! Parameter values of a fixed number, converted to the number type that a function is evaluated with.

use super::Real;

/// List of parameter values of a fixed length; arrays implement it.
pub trait Values<N>: AsRef<[N]> + Copy {
    /// Makes the list from the value at each index.
    fn from_fn(value: impl FnMut(usize) -> N) -> Self;
}

impl<N: Copy, const K: usize> Values<N> for [N; K] {
    #[inline(always)]
    fn from_fn(value: impl FnMut(usize) -> N) -> Self {
        std::array::from_fn(value)
    }
}

/// Converts `f32` values to constants of the number type `N`.
#[inline(always)]
pub(crate) fn values<N: Real, V: Values<N>>(params: &[f32]) -> V {
    V::from_fn(|k| N::constant(params[k]))
}
