//! Points and vectors over any number type.

use super::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Point or vector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<N> {
    /// Component along x.
    pub x: N,
    /// Component along y, up.
    pub y: N,
    /// Component along z.
    pub z: N,
}

impl<N> Vec3<N> {
    /// Makes a vector of three components.
    pub const fn new(x: N, y: N, z: N) -> Self {
        Self { x, y, z }
    }
}

impl<N: Real> Vec3<N> {
    /// Makes a vector of three equal components.
    pub fn splat(value: N) -> Self {
        Self::new(value, value, value)
    }
    /// Makes a constant vector, the same in every lane.
    pub fn constant(value: [f32; 3]) -> Self {
        Self::new(N::constant(value[0]), N::constant(value[1]), N::constant(value[2]))
    }
    /// Dot product.
    pub fn dot(self, other: Self) -> N {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    /// Euclidean length.
    pub fn length(self) -> N {
        N::norm([self.x, self.y, self.z])
    }
    /// Vector of length one in its direction.
    pub fn normalized(self) -> Self {
        self * (N::one() / self.length())
    }
    /// Vector of length one in the direction of one whose length is one but for rounding: a step of Newton's method, which takes
    /// no root and no division.
    pub fn renormalized(self) -> Self {
        self * (N::constant(1.5) - N::constant(0.5) * self.dot(self))
    }
    /// Products of the components.
    pub fn times(self, other: Self) -> Self {
        Self::new(self.x * other.x, self.y * other.y, self.z * other.z)
    }
    /// Selects `yes` where the mask is true, else `no`.
    pub fn select(mask: N::Mask, yes: Self, no: Self) -> Self {
        Self::new(N::select(mask, yes.x, no.x), N::select(mask, yes.y, no.y), N::select(mask, yes.z, no.z))
    }
    /// Magnitude of each component.
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }
    /// Maximum of each component and `value`.
    pub fn max(self, value: N) -> Self {
        Self::new(self.x.max(value), self.y.max(value), self.z.max(value))
    }
    /// Largest component.
    pub fn largest(self) -> N {
        self.x.max(self.y.max(self.z))
    }
}

impl From<glam::Vec3> for Vec3<f32> {
    #[inline(always)]
    fn from(v: glam::Vec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Vec3<f32>> for glam::Vec3 {
    #[inline(always)]
    fn from(v: Vec3<f32>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<N: Real> Add for Vec3<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<N: Real> Sub for Vec3<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<N: Real> Mul<N> for Vec3<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: N) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<N: Real> Div<N> for Vec3<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: N) -> Self {
        Self::new(self.x / divisor, self.y / divisor, self.z / divisor)
    }
}

impl<N: Real> Neg for Vec3<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}
