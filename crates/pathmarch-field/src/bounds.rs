//! Axis-aligned bounding boxes, possibly unbounded.

use crate::number::Vec3;

/// Axis-aligned box, metres; infinite along unbounded axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Corner of smallest coordinates.
    pub min: [f32; 3],
    /// Corner of largest coordinates.
    pub max: [f32; 3],
}

impl Aabb {
    /// All of space.
    pub const EVERYTHING: Self = Self { min: [f32::NEG_INFINITY; 3], max: [f32::INFINITY; 3] };
    /// Empty box.
    pub const NOTHING: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// Box centred at the origin with these half edges.
    pub fn centred(x: f32, y: f32, z: f32) -> Self {
        Self { min: [-x, -y, -z], max: [x, y, z] }
    }
    /// Reports whether every coordinate is finite.
    pub fn is_finite(&self) -> bool {
        self.min.iter().chain(&self.max).all(|v| v.is_finite())
    }
    /// Reports whether it contains no point.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|k| self.min[k] > self.max[k])
    }
    /// Smallest box that contains both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }
    /// Intersection of both.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].max(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].min(other.max[k])),
        }
    }
    /// Box grown by `margin` metres on every side.
    pub fn expanded(self, margin: f32) -> Self {
        Self { min: self.min.map(|v| v - margin), max: self.max.map(|v| v + margin) }
    }
    /// Reports whether the point is within `slack` metres of the box.
    pub fn contains(&self, p: Vec3<f32>, slack: f32) -> bool {
        [p.x, p.y, p.z].iter().enumerate().all(|(k, &v)| v >= self.min[k] - slack && v <= self.max[k] + slack)
    }
    /// Distance from the point to the box, metres; zero inside.
    pub fn distance(&self, p: [f32; 3]) -> f32 {
        let beyond = |k: usize| (self.min[k] - p[k]).max(p[k] - self.max[k]).max(0.0);
        let [x, y, z] = [0, 1, 2].map(beyond);
        (x * x + y * y + z * z).sqrt()
    }
    /// Eight corners.
    pub fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|i| std::array::from_fn(|k| if i >> k & 1 == 0 { self.min[k] } else { self.max[k] }))
    }
}
