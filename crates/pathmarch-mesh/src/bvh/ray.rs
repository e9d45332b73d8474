//! Rays, and what intersection precomputes of them.

use glam::Vec3;
use wide::f32x8;

/// Ray with a range of its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start.
    pub origin: Vec3,
    /// Direction, of any length but zero.
    pub direction: Vec3,
    /// Hits are beyond this multiple of the direction.
    pub t_min: f32,
    /// Hits are before this multiple of the direction.
    pub t_max: f32,
}

impl Ray {
    /// Ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// Point at a parameter.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

/// Ray whose direction is sheared to an axis (Woop et al. 2013).
pub(super) struct ShearedRay {
    origin: [f32x8; 3],
    /// The two other axes, then that along which the direction is longest.
    axes: [usize; 3],
    shear: [f32x8; 3],
}

impl ShearedRay {
    pub fn new(ray: &Ray) -> Self {
        let long = ray.direction.abs().max_position();
        let axes = [(long + 1) % 3, (long + 2) % 3, long];
        let [x, y, z] = axes.map(|axis| ray.direction[axis]);
        let origin = axes.map(|axis| f32x8::splat(ray.origin[axis]));
        Self { origin, axes, shear: [x / z, y / z, 1.0 / z].map(f32x8::splat) }
    }

    /// A corner relative to the origin, sheared; its depth is in units of the ray's parameter.
    #[inline(always)]
    pub fn shear(&self, corner: &[f32x8; 3]) -> [f32x8; 3] {
        let [x, y, z] = [0, 1, 2].map(|k| corner[self.axes[k]] - self.origin[k]);
        [x - self.shear[0] * z, y - self.shear[1] * z, self.shear[2] * z]
    }
}

/// Ray for the test of eight boxes by their slabs (Kay and Kajiya 1986).
pub(super) struct SlabRay {
    origin: [f32x8; 3],
    inverse: [f32x8; 3],
    is_negative: [bool; 3],
}

/// Makes a box test conservative: the relative error of three rounded operations, twice (Ize 2013).
const ROUNDING: f32 = 1.0 + 4.0 * 1.5 * f32::EPSILON;
/// Least component of a direction; smaller ones would give 0 times infinity.
const LEAST_DIRECTION: f32 = 1e-30;

impl SlabRay {
    pub fn new(ray: &Ray) -> Self {
        let along = |axis: usize| {
            let component = ray.direction[axis];
            if component.abs() < LEAST_DIRECTION { LEAST_DIRECTION.copysign(component) } else { component }
        };
        Self {
            origin: [0, 1, 2].map(|axis| f32x8::splat(ray.origin[axis])),
            inverse: [0, 1, 2].map(|axis| f32x8::splat(1.0 / along(axis))),
            is_negative: [0, 1, 2].map(|axis| along(axis) < 0.0),
        }
    }

    /// Parameters at which the ray enters and leaves eight boxes, given the planes of least and greatest coordinates.
    #[inline(always)]
    pub fn slabs(&self, min: &[f32x8; 3], max: &[f32x8; 3], t_min: f32, t_max: f32) -> (f32x8, f32x8) {
        let (mut enter, mut leave) = (f32x8::splat(t_min), f32x8::splat(t_max));
        for axis in 0..3 {
            let (near, far) = if self.is_negative[axis] { (max, min) } else { (min, max) };
            enter = enter.fast_max((near[axis] - self.origin[axis]) * self.inverse[axis]);
            leave = leave.fast_min((far[axis] - self.origin[axis]) * self.inverse[axis] * f32x8::splat(ROUNDING));
        }
        (enter, leave)
    }
}
