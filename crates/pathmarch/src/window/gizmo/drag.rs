//! What a handle does while it is held: from the ray through the pointer to a new placement.
//!
//! A result always comes from where the handle was caught and where the pointer is now, not from steps between, so that
//! nothing drifts; only whole turns of a ring are counted as they come. Where the ray is almost parallel to the axis or the
//! plane, or meets it behind the camera, there is no result and the node stays as it is.

use super::shape::{Axis, Gizmo, Handle, SIZE};
use super::transform::Transform;
use crate::window::camera::projection::{Projection, Ray};
use egui::{Pos2, Vec2};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// With Ctrl: metres of a move, radians of a turn, and the factor of a scale go in these steps.
const SNAP_METRES: f64 = 0.1;
const SNAP_RADIANS: f64 = PI / 36.0;
const SNAP_SCALE: f64 = 0.1;
/// The smallest factor of a scale.
const MIN_FACTOR: f64 = 1e-4;
/// A ray meets no plane to which it makes an angle of a smaller sine than this, and no axis either.
const MIN_SINE: f64 = 0.02;
/// A ring whose normal makes an angle of a smaller cosine than this with the view is seen from its edge.
const EDGE_COSINE: f64 = 0.2;

/// A handle that is held.
#[derive(Clone, Debug)]
pub(super) struct Drag {
    pub(super) handle: Handle,
    /// Placement of the node in the world when the handle was caught.
    start: Transform,
    grab: Grab,
    /// The pointer has moved since.
    moved: bool,
    /// Where it was caught, in the window.
    from: Pos2,
}

/// Where a handle was caught.
#[derive(Clone, Copy, Debug)]
enum Grab {
    /// Metres along an axis of the world.
    Axis { direction: DVec3, along: f64 },
    /// A point of a plane through the node.
    Plane { plane: Plane, point: DVec3 },
    /// An angle in a plane about the node, radians: at the start, the last one, and the turn in all.
    Turn { plane: Plane, first: f64, last: f64, total: f64 },
    /// A ring seen from its edge: a direction of the window in which the near side of it goes when it turns about `normal`.
    Roll { normal: DVec3, along: Vec2, total: f64 },
    /// A distance from the node in the window, points.
    Scale { distance: f64 },
}

/// A plane, by two unit vectors in it that are at right angles, and the normal that is their cross product.
#[derive(Clone, Copy, Debug)]
struct Plane {
    u: DVec3,
    v: DVec3,
    normal: DVec3,
}

impl Plane {
    fn across(axis: Axis) -> Self {
        let [u, v] = axis.others();
        Self { u, v, normal: axis.unit() }
    }

    /// Parallel to the picture, its normal to_camera the camera.
    fn of_view(projection: &Projection) -> Self {
        Self { u: projection.right, v: projection.up, normal: -projection.forward }
    }

    /// Where a ray meets this plane through `origin`.
    fn intersect(&self, origin: DVec3, ray: Ray) -> Option<DVec3> {
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

/// Metres along an axis through `origin` at which it comes nearest to a ray.
fn nearest_on_axis(origin: DVec3, direction: DVec3, ray: Ray) -> Option<f64> {
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
    /// Catches a handle at a point of the window. None where the ray through it does not meet the axis or plane.
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
                // The near side of the ring goes this way.
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

    /// The placement for a pointer that is here now; none where it has not moved yet, or where there is no result.
    pub(super) fn to(&mut self, projection: &Projection, at: Pos2, snapping: bool) -> Option<Transform> {
        self.moved |= at != self.from;
        if !self.moved {
            return None;
        }
        // The camera may have passed it meanwhile.
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
                // The shorter way round.
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

    /// Sector of a plane that a ring has been turned through: two axes, the first angle and how far it went, radians.
    pub(super) fn sector(&self) -> Option<([DVec3; 2], f64, f64)> {
        match self.grab {
            Grab::Turn { plane, first, total, .. } => Some(([plane.u, plane.v], first, total)),
            _ => None,
        }
    }
}
