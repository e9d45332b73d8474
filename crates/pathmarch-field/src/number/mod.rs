//! Number types over which fields are written.
//!
//! Idea: a distance is one Rust function generic over [`Real`]. With `f32` or [`Lanes`](wide::f32x8) it computes on
//! the CPU, with [`Dual`] numbers it gives the exact gradient (forward-mode automatic differentiation; Griewank and
//! Walther, "Evaluating Derivatives", 2008, ch. 3), and with [`Expr`](crate::wgsl::Expr) it records itself to be printed as
//! WGSL. Cost: none at run time for `f32` and lanes (everything is inlined), four components for duals.

mod dual;
mod lanes;
mod scalar;
mod unit_circle;
mod values;
mod vec3;

pub use dual::Dual;
pub use lanes::Mask8;
pub use unit_circle::unit_circle;
pub use values::Values;
pub(crate) use values::values;
pub use vec3::Vec3;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Result of a comparison of [`Real`]s: one truth value, or one for each lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {}

impl<T: Copy + BitAnd<Output = T> + BitOr<Output = T> + Not<Output = T>> Mask for T {}

/// Real number as fields use it: arithmetic, a few functions, comparison and selection instead of branches, and one structured
/// loop.
///
/// Functions follow IEEE arithmetic where defined. `sqrt` of a negative number is not a number; its derivative at zero
/// is taken as finite, so that gradients of lengths stay finite.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self> + 'static
{
    /// Result of a comparison.
    type Mask: Mask;

    /// Constant, the same in every lane.
    fn constant(value: f32) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Minimum of two.
    fn min(self, other: Self) -> Self;
    /// Maximum of two.
    fn max(self, other: Self) -> Self;
    /// Largest integer not above `self`; its derivative is zero.
    fn floor(self) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Angle of the point (`x`, `self`), radians in -π..π.
    fn atan2(self, x: Self) -> Self;
    /// e to the power `self`.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Comparison `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Constant truth value, the same in every lane.
    fn truth(value: bool) -> Self::Mask;
    /// Selects `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Bounded loop over a state of `K` numbers.
    ///
    /// Runs `body` at most `min(count, limit)` times. `body` returns the next state, which is always kept, and the mask of lanes to
    /// go on. Lanes that have stopped keep their state. `count` must be the same in every lane.
    fn iterate<const K: usize>(
        count: Self,
        limit: u32,
        state: [Self; K],
        body: impl Fn([Self; K]) -> ([Self; K], Self::Mask),
    ) -> [Self; K];

    /// Vector `index` of a table of four numbers each; an index out of range returns any of them. Printed code reads the table in
    /// the field's parameters instead.
    fn vector(table: &[f32], index: Self) -> [Self; 4];

    /// [`vector`](Self::vector) of this index and of the next one.
    fn vectors(table: &[f32], index: Self) -> [[Self; 4]; 2] {
        [Self::vector(table, index), Self::vector(table, index + Self::one())]
    }

    /// Names this value in printed code; no effect elsewhere.
    fn named(self, _name: &'static str) -> Self {
        self
    }

    /// Power of `self`; defined for positive `self`.
    fn pow(self, exponent: Self) -> Self {
        (self.ln() * exponent).exp()
    }
    /// Clamps `self` to `low..=high`.
    fn clamp(self, low: Self, high: Self) -> Self {
        self.max(low).min(high)
    }
    /// Square.
    fn squared(self) -> Self {
        self * self
    }
    /// Sign: -1 below zero, else 1.
    fn sign(self) -> Self {
        Self::select(self.lt(Self::zero()), Self::constant(-1.0), Self::one())
    }
    /// Divisor whose quotients stay finite: `self`, or 1e-12 if it is nearer to zero than that.
    fn divisor(self) -> Self {
        let least = Self::constant(1e-12);
        Self::select(self.abs().lt(least), least, self)
    }
    /// Zero.
    fn zero() -> Self {
        Self::constant(0.0)
    }
    /// One.
    fn one() -> Self {
        Self::constant(1.0)
    }
    /// Euclidean norm of `K` components.
    fn norm<const K: usize>(components: [Self; K]) -> Self {
        let square = components.map(Self::squared).into_iter().reduce(|a, b| a + b);
        square.map_or(Self::zero(), Self::sqrt)
    }
    /// Length of the plane vector (`self`, `other`).
    fn hypot(self, other: Self) -> Self {
        Self::norm([self, other])
    }
}

/// Number type over which dual numbers exist.
///
/// It adds the loop over duals, which cannot be derived from [`Real::iterate`] because its state is four times as long.
pub trait Differentiable: Real {
    /// [`Real::iterate`] over dual numbers of this base.
    fn iterate_dual<const K: usize>(
        count: Dual<Self>,
        limit: u32,
        state: [Dual<Self>; K],
        body: impl Fn([Dual<Self>; K]) -> ([Dual<Self>; K], Self::Mask),
    ) -> [Dual<Self>; K];
}
