//! Dragging a handle: from the ray through the pointer to a new transform.
//!
//! The result depends only on where the drag began and where the pointer is now, so that errors do not accumulate; only
//! full turns of a ring are counted on the way. If the ray is nearly parallel to the axis or plane, or hits it behind
//! the camera, the node keeps its transform.

use super::shape::{Axis, Gizmo, Handle, SIZE};
use super::transform::Transform;
use crate::window::projection::{Projection, Ray};
use egui::{Pos2, Vec2};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// Snapping steps with Ctrl: metres of a translation, radians of a rotation, factor of a scale.
const SNAP_METRES: f64 = 0.1;
const SNAP_RADIANS: f64 = PI / 36.0;
const SNAP_SCALE: f64 = 0.1;
/// Minimum scale factor.
const MIN_FACTOR: f64 = 1e-4;
/// Minimum sine of the angle between a ray and a plane or axis.
const MIN_SINE: f64 = 0.02;
/// Maximum cosine between a ring's normal and the view direction for which the ring is seen edge-on.
const EDGE_COSINE: f64 = 0.2;

/// A drag in progress.
#[derive(Clone, Debug)]
pub(super) struct Drag {
    pub(super) handle: Handle,
    /// World transform of the node when the drag began.
    start: Transform,
    grab: Grab,
    /// The pointer has moved since.
    moved: bool,
    /// Window point where the drag began.
    from: Pos2,
}

/// Grabbed point, by kind of handle.
#[derive(Clone, Copy, Debug)]
enum Grab {
    /// Position along a world axis, metres.
    Axis { direction: DVec3, along: f64 },
    /// A point on a plane through the node.
    Plane { plane: Plane, point: DVec3 },
    /// Angle in a plane about the node, radians: at the start, last, and in total.
    Turn { plane: Plane, first: f64, last: f64, total: f64 },
    /// Ring seen edge-on: `along` is the window direction in which its near side moves when it rotates about `normal`.
    Roll { normal: DVec3, along: Vec2, total: f64 },
    /// Distance from the node, window points.
    Scale { distance: f64 },
}

/// A plane through the node: two orthonormal vectors, and their cross product as normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) u: DVec3,
    pub(super) v: DVec3,
    pub(super) normal: DVec3,
}

impl Plane {
    fn across(axis: Axis) -> Self {
        let [u, v] = axis.others();
        Self { u, v, normal: axis.unit() }
    }

    /// Plane parallel to the image plane, facing the camera.
    pub(super) fn of_view(projection: &Projection) -> Self {
        Self { u: projection.right, v: projection.up, normal: -projection.forward }
    }

    /// Intersection of a ray with this plane through `origin`.
    pub(super) fn intersect(&self, origin: DVec3, ray: Ray) -> Option<DVec3> {
        let slope = ray.direction.dot(self.normal);
        if slope.abs() < MIN_SINE * ray.direction.length() {
            return None;
        }
        let depth = (origin - ray.origin).dot(self.normal) / slope;
        (depth > 0.0).then(|| ray.origin + ray.direction * depth)
    }

    /// Angle of a point about `origin`, from `u` to `v`, radians.
    fn angle(&self, origin: DVec3, point: DVec3) -> f64 {
        let out = point - origin;
        out.dot(self.v).atan2(out.dot(self.u))
    }
}

/// Position along an axis through `origin` where it is closest to a ray, metres.
pub(super) fn nearest_on_axis(origin: DVec3, direction: DVec3, ray: Ray) -> Option<f64> {
    let square = ray.direction.length_squared();
    let along = ray.direction.dot(direction);
    let sine_square = 1.0 - along * along / square;
    if sine_square < MIN_SINE * MIN_SINE {
        return None;
    }
    let from = origin - ray.origin;
    let metres = (along / square * ray.direction.dot(from) - direction.dot(from)) / sine_square;
    let depth = ray.direction.dot(from + direction * metres) / square;
    (depth > 0.0).then_some(metres)
}

impl Drag {
    /// Begins a drag at a window point; `None` if its ray does not hit the axis or plane.
    pub(super) fn begin(gizmo: &Gizmo, handle: Handle, start: Transform, at: Pos2) -> Option<Self> {
        let Gizmo { projection, to_camera, .. } = gizmo;
        let ray = projection.ray_through(at);
        let on_plane = |plane: Plane| Some(Grab::Plane { plane, point: plane.intersect(start.translation, ray)? });
        let turn = |plane: Plane| {
            let first = plane.angle(start.translation, plane.intersect(start.translation, ray)?);
            Some(Grab::Turn { plane, first, last: first, total: 0.0 })
        };
        let grab = match handle {
            Handle::Arrow(axis) => {
                let direction = axis.unit();
                Some(Grab::Axis { direction, along: nearest_on_axis(start.translation, direction, ray)? })
            }
            Handle::PlaneSquare(axis) => on_plane(Plane::across(axis)),
            Handle::Disc => on_plane(Plane::of_view(projection)),
            Handle::Ring(axis) if axis.unit().dot(*to_camera).abs() < EDGE_COSINE => {
                let normal = axis.unit();
                // Direction in which the near side of the ring moves.
                let way = normal.cross(*to_camera);
                let along = Vec2::new(way.dot(projection.right) as f32, -way.dot(projection.up) as f32).normalized();
                Some(Grab::Roll { normal, along, total: 0.0 })
            }
            Handle::Ring(axis) => turn(Plane::across(axis)),
            Handle::ViewRing => turn(Plane::of_view(projection)),
            Handle::ScaleRing => Some(Grab::Scale { distance: f64::from(at.distance(gizmo.middle)).max(1.0) }),
        };
        Some(Self { handle, start, grab: grab?, moved: false, from: at })
    }

    /// New transform for the current pointer; `None` before the first movement, or without an intersection.
    pub(super) fn to(&mut self, projection: &Projection, at: Pos2, snapping: bool) -> Option<Transform> {
        self.moved |= at != self.from;
        if !self.moved {
            return None;
        }
        // The camera may have passed the node meanwhile.
        projection.depth(self.start.translation)?;
        let snapped = |value: f64, step: f64| if snapping { (value / step).round() * step } else { value };
        let (start, ray) = (self.start, projection.ray_through(at));
        let turned = |normal: DVec3, angle: f64| {
            let turn = DQuat::from_axis_angle(normal, snapped(angle, SNAP_RADIANS));
            Some(Transform { rotation: (turn * start.rotation).normalize(), ..start })
        };
        match &mut self.grab {
            Grab::Axis { direction, along } => {
                let metres = nearest_on_axis(start.translation, *direction, ray)? - *along;
                Some(Transform { translation: start.translation + *direction * snapped(metres, SNAP_METRES), ..start })
            }
            Grab::Plane { plane, point } => {
                let by = plane.intersect(start.translation, ray)? - *point;
                let [u, v] = [plane.u, plane.v].map(|axis| axis * snapped(by.dot(axis), SNAP_METRES));
                Some(Transform { translation: start.translation + u + v, ..start })
            }
            Grab::Turn { plane, last, total, .. } => {
                let angle = plane.angle(start.translation, plane.intersect(start.translation, ray)?);
                // Take the shorter way round.
                *total += (angle - *last + PI).rem_euclid(TAU) - PI;
                *last = angle;
                turned(plane.normal, *total)
            }
            Grab::Roll { normal, along, total } => {
                *total = f64::from((at - self.from).dot(*along)) / SIZE;
                turned(*normal, *total)
            }
            Grab::Scale { distance } => {
                let now = f64::from(at.distance(projection.project(start.translation)?));
                let least = if snapping { SNAP_SCALE } else { MIN_FACTOR };
                let factor = snapped(now / *distance, SNAP_SCALE).max(least);
                Some(Transform { scale: start.scale * factor, ..start })
            }
        }
    }

    /// Sector that a ring has been rotated through: axes of its plane, first angle and total angle, radians.
    pub(super) fn sector(&self) -> Option<([DVec3; 2], f64, f64)> {
        match self.grab {
            Grab::Turn { plane, first, total, .. } => Some(([plane.u, plane.v], first, total)),
            _ => None,
        }
    }
}
