//! Axis-aligned boxes.

use glam::Vec3;

/// Axis-aligned box; empty if a minimum exceeds its maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least corner.
    pub min: Vec3,
    /// Greatest corner.
    pub max: Vec3,
}

impl Bounds {
    /// Box without points.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Smallest box around some points.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, p| Self { min: bounds.min.min(p), max: bounds.max.max(p) })
    }

    /// Smallest box around two boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Reports a box without points.
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Edge lengths; zero for an empty box.
    pub fn size(self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// Middle of the box.
    pub fn centre(self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// The point of the box that is closest to another; not defined for an empty box.
    pub fn clamped(self, p: Vec3) -> Vec3 {
        p.max(self.min).min(self.max)
    }
}
