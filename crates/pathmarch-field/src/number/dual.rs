//! Dual numbers: a value and its three partial derivatives.
//!
//! Forward-mode automatic differentiation (Griewank and Walther 2008, ch. 3). At a kink (`min`, `max`, `abs`) the
//! derivative is that of the side taken, which is the one-sided normal a ray sees.

use super::{Differentiable, Real, Vec3};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value with its derivatives along x, y and z of the point.
#[derive(Clone, Copy, Debug)]
pub struct Dual<N> {
    /// Value.
    pub value: N,
    /// Partial derivatives along x, y, z.
    pub gradient: Vec3<N>,
}

/// Least square root in the divisor of its derivative, so that 0/0 becomes 0.
const SMALLEST_ROOT: f32 = 1e-18;

impl<N: Real> Dual<N> {
    /// Makes the point `p` the variables of differentiation.
    pub fn variables(p: Vec3<N>) -> Vec3<Self> {
        let (zero, one) = (N::zero(), N::one());
        Vec3::new(
            Self { value: p.x, gradient: Vec3::new(one, zero, zero) },
            Self { value: p.y, gradient: Vec3::new(zero, one, zero) },
            Self { value: p.z, gradient: Vec3::new(zero, zero, one) },
        )
    }
    /// Makes a number that does not depend on the point.
    #[inline(always)]
    pub fn independent(value: N) -> Self {
        Self { value, gradient: Vec3::splat(N::zero()) }
    }
    /// Chain rule: value `f`, outer derivative `slope`.
    #[inline(always)]
    fn chain(self, f: N, slope: N) -> Self {
        Self { value: f, gradient: self.gradient * slope }
    }
    #[inline(always)]
    fn choose(mask: N::Mask, yes: Self, no: Self) -> Self {
        Self {
            value: N::select(mask, yes.value, no.value),
            gradient: Vec3::new(
                N::select(mask, yes.gradient.x, no.gradient.x),
                N::select(mask, yes.gradient.y, no.gradient.y),
                N::select(mask, yes.gradient.z, no.gradient.z),
            ),
        }
    }
}

impl<N: Real> Vec3<Dual<N>> {
    /// Values of the point.
    pub fn values(self) -> Vec3<N> {
        Vec3::new(self.x.value, self.y.value, self.z.value)
    }
    /// Pulls a gradient at this point back to the variables of differentiation (chain rule).
    pub fn pulled_back(self, gradient: Vec3<N>) -> Vec3<N> {
        self.x.gradient * gradient.x + self.y.gradient * gradient.y + self.z.gradient * gradient.z
    }
}

impl<N: Real> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, gradient: self.gradient + other.gradient }
    }
}

impl<N: Real> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, gradient: self.gradient - other.gradient }
    }
}

impl<N: Real> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, gradient: self.gradient * other.value + other.gradient * self.value }
    }
}

impl<N: Real> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self { value, gradient: (self.gradient - other.gradient * value) / other.value }
    }
}

impl<N: Real> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, gradient: -self.gradient }
    }
}

impl<N: Differentiable> Real for Dual<N> {
    type Mask = N::Mask;

    #[inline(always)]
    fn constant(value: f32) -> Self {
        Self::independent(N::constant(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, N::constant(0.5) / root.max(N::constant(SMALLEST_ROOT)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.sign())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        let chosen = Self::choose(other.value.lt(self.value), other, self);
        Self { value: self.value.min(other.value), ..chosen }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let chosen = Self::choose(self.value.lt(other.value), other, self);
        Self { value: self.value.max(other.value), ..chosen }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self::independent(self.value.floor())
    }
    #[inline(always)]
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }
    #[inline(always)]
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        let square = (self.value * self.value + x.value * x.value).max(N::constant(f32::MIN_POSITIVE));
        Self {
            value: self.value.atan2(x.value),
            gradient: (self.gradient * x.value - x.gradient * self.value) / square,
        }
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), N::one() / self.value)
    }
    #[inline(always)]
    fn squared(self) -> Self {
        self.chain(self.value.squared(), N::constant(2.0) * self.value)
    }
    /// The gradient of a length is the vector over its length, turned by the components' own gradients.
    #[inline(always)]
    fn norm<const K: usize>(components: [Self; K]) -> Self {
        let value = N::norm(components.map(|c| c.value));
        let gradient = components.into_iter().fold(Vec3::splat(N::zero()), |sum, c| sum + c.gradient * c.value);
        Self { value, gradient: gradient / value.max(N::constant(SMALLEST_ROOT)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> N::Mask {
        self.value.lt(other.value)
    }
    #[inline(always)]
    fn truth(value: bool) -> N::Mask {
        N::truth(value)
    }
    #[inline(always)]
    fn select(mask: N::Mask, yes: Self, no: Self) -> Self {
        Self::choose(mask, yes, no)
    }
    #[inline(always)]
    fn vector(table: &[f32], index: Self) -> [Self; 4] {
        N::vector(table, index.value).map(Self::independent)
    }
    #[inline(always)]
    fn vectors(table: &[f32], index: Self) -> [[Self; 4]; 2] {
        N::vectors(table, index.value).map(|vector| vector.map(Self::independent))
    }
    #[inline(always)]
    fn iterate<const K: usize>(
        count: Self,
        limit: u32,
        state: [Self; K],
        body: impl Fn([Self; K]) -> ([Self; K], N::Mask),
    ) -> [Self; K] {
        N::iterate_dual(count, limit, state, body)
    }
    fn named(self, name: &'static str) -> Self {
        Self { value: self.value.named(name), gradient: self.gradient }
    }
}
