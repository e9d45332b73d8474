//! Local coordinates: placements composed to one similarity, which transforms points, lengths and boxes.

use crate::bounds::Aabb;
use crate::number::{Dual, Real, Vec3};
use glam::{EulerRot, Mat3, Quat};

/// Placement of a node: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Direction to which the shape's +y is turned first; any length above zero.
    pub normal: Option<[f32; 3]>,
    /// Uniform scale, above zero.
    pub scale: Option<f32>,
    /// Rotation about the fixed x, then y, then z axis, degrees, right-handed.
    pub rotate: Option<[f32; 3]>,
    /// Translation, metres.
    pub at: Option<[f32; 3]>,
}

impl Placement {
    /// Local coordinates of the node.
    pub fn pose(&self) -> Pose {
        Frame::WORLD.inside(self).pose()
    }
}

/// Rotation and scale of local coordinates, which decide on the printed code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Turn {
    /// No rotation or scale.
    None,
    /// Scale only.
    Scaled,
    /// Rotation, perhaps with scale.
    Turned,
}

/// Local coordinates of a shape, in the world or in the space of the modifier around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// True if any placement translates it.
    pub moved: bool,
    /// Rotation and scale by its placements.
    pub turn: Turn,
    /// Origin of the local coordinates, metres.
    pub at: [f32; 3],
    /// Size of a local unit, metres.
    pub scale: f32,
    /// Local axes x, y, z in the world, unit vectors.
    pub axes: [[f32; 3]; 3],
}

impl Pose {
    /// Rows of the matrix from world offsets to local coordinates.
    pub fn local_from_world(&self) -> [[f32; 3]; 3] {
        self.axes.map(|axis| axis.map(|v| v / self.scale))
    }

    /// Axis of the world along which each local axis points, and 1 or -1 where it points the other way; `None` if one of
    /// them lies between the axes of the world.
    pub(crate) fn signed_axes(&self) -> Option<[(usize, f32); 3]> {
        let is_along = |axis: [f32; 3], k: usize| (0..3).all(|other| axis[other].abs() == f32::from(other == k));
        let [x, y, z] = self.axes.map(|axis| (0..3).find(|&k| is_along(axis, k)).map(|k| (k, axis[k])));
        Some([x?, y?, z?])
    }

    #[inline]
    pub(super) fn local<N: Real>(&self, p: Vec3<N>) -> Vec3<N> {
        let offset = if self.moved { p - Vec3::constant(self.at) } else { p };
        match self.turn {
            Turn::None => offset,
            Turn::Scaled => offset * N::constant(1.0 / self.scale),
            Turn::Turned => {
                let inverse = N::constant(1.0 / self.scale);
                let [x, y, z] = self.axes.map(|axis| Vec3::constant(axis).dot(offset) * inverse);
                Vec3::new(x, y, z)
            }
        }
    }

    /// Direction in local axes, of the same length.
    #[inline]
    pub(super) fn turned<N: Real>(&self, direction: Vec3<N>) -> Vec3<N> {
        if self.turn != Turn::Turned {
            return direction;
        }
        let [x, y, z] = self.axes.map(|axis| Vec3::constant(axis).dot(direction));
        Vec3::new(x, y, z)
    }

    /// Converts a length from local coordinates to the world.
    #[inline]
    pub(super) fn length<N: Real>(&self, local: N) -> N {
        if self.turn == Turn::None { local } else { local * N::constant(self.scale) }
    }

    /// Converts a distance and its gradient from local coordinates to the world.
    #[inline]
    pub(super) fn world<N: Real>(&self, local: Dual<N>) -> Dual<N> {
        let value = self.length(local.value);
        if self.turn != Turn::Turned {
            return Dual { value, gradient: local.gradient };
        }
        let [x, y, z] = self.axes.map(Vec3::constant);
        let g = local.gradient;
        Dual { value, gradient: x * g.x + y * g.y + z * g.z }
    }

    /// World bounds of a local box.
    pub(super) fn world_bounds(&self, local: Aabb) -> Aabb {
        if self.turn != Turn::Turned {
            let place = |v: [f32; 3]| std::array::from_fn(|k| v[k] * self.scale + self.at[k]);
            return Aabb { min: place(local.min), max: place(local.max) };
        }
        // Each edge of the box spans an interval along each axis of the world; one across that axis does not reach along it.
        let mut bounds = Aabb { min: self.at, max: self.at };
        for (axis, k) in (0..3).flat_map(|axis| (0..3).map(move |k| (axis, k))) {
            let along = self.scale * self.axes[axis][k];
            if along != 0.0 {
                let (a, b) = (along * local.min[axis], along * local.max[axis]);
                bounds.min[k] += a.min(b);
                bounds.max[k] += a.max(b);
            }
        }
        bounds
    }
}

/// Placement composed with those of its parents: a similarity of the world, and the parts that were written.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    at: glam::Vec3,
    turn: Quat,
    pub(super) scale: f32,
    moved: bool,
    kind: Turn,
}

impl Frame {
    pub(super) const WORLD: Self =
        Self { at: glam::Vec3::ZERO, turn: Quat::IDENTITY, scale: 1.0, moved: false, kind: Turn::None };

    pub(super) fn inside(self, placement: &Placement) -> Self {
        let mut frame = self;
        if let Some(at) = placement.at {
            frame.at += self.turn * (glam::Vec3::from(at) * self.scale);
            frame.moved = true;
        }
        if let Some([x, y, z]) = placement.rotate {
            // Fixed axes x, then y, then z: the matrix is Rz·Ry·Rx.
            let turn = Quat::from_euler(EulerRot::ZYX, z.to_radians(), y.to_radians(), x.to_radians());
            frame.turn = (frame.turn * turn).normalize();
            frame.kind = Turn::Turned;
        }
        if let Some(scale) = placement.scale {
            frame.scale *= scale;
            if frame.kind == Turn::None {
                frame.kind = Turn::Scaled;
            }
        }
        if let Some(normal) = placement.normal {
            let normal = glam::Vec3::from(normal).normalize_or(glam::Vec3::Y);
            frame.turn = (frame.turn * Quat::from_rotation_arc(glam::Vec3::Y, normal)).normalize();
            frame.kind = Turn::Turned;
        }
        frame
    }

    pub(super) fn pose(self) -> Pose {
        let axes = Mat3::from_quat(self.turn);
        let axes = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| on_world_axis(axis).into());
        Pose { moved: self.moved, turn: self.kind, at: self.at.into(), scale: self.scale, axes }
    }
}

/// The nearest axis of the world, in either direction, if a unit vector differs from it by rounding alone.
fn on_world_axis(axis: glam::Vec3) -> glam::Vec3 {
    const ROUNDING: f32 = 4.0 * f32::EPSILON;
    let rounded = axis.round();
    if (axis - rounded).abs().max_element() <= ROUNDING { rounded } else { axis }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_along_the_axes_of_the_world_and_small_ones_are_not() {
        let axes = |rotate: Option<[f32; 3]>, normal: Option<[f32; 3]>| {
            Placement { rotate, normal, scale: Some(1.5), at: None }.pose().signed_axes()
        };
        let turned = |x, y, z| axes(Some([x, y, z]), None);
        assert_eq!(turned(0.0, 90.0, 0.0), Some([(2, -1.0), (1, 1.0), (0, 1.0)]));
        assert_eq!(turned(90.0, 0.0, 180.0), Some([(0, -1.0), (2, 1.0), (1, 1.0)]));
        assert_eq!(axes(None, Some([-2.0, 0.0, 0.0])).map(|axes| axes[1]), Some((0, -1.0)));
        for small in [5e-4, 5e-3, 1.0, 45.0] {
            assert_eq!(turned(0.0, small, 0.0), None, "{small}");
        }
    }
}
