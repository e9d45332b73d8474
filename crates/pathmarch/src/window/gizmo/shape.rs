//! Shapes of the handles, and picking.
//!
//! Sizes are in window points, as handles have a constant size on screen; only directions and depths come from world
//! space. An arrow seen from its end, or a square seen edge-on, fades out and cannot be picked: its axis or plane is
//! nearly parallel to the pointer rays.

use crate::window::open_scene::view_state::GizmoMode;
use crate::window::projection::Projection;
use egui::{Color32, Pos2, Vec2};
use glam::DVec3;
use std::f64::consts::TAU;

/// Length of the handles, points.
pub(super) const SIZE: f64 = 75.0;
/// Line width, points.
pub(super) const STROKE: f64 = 4.0;
/// Radius of the centre disc, points.
pub(super) const DISC_RADIUS: f64 = 0.2 * SIZE;
/// Radius of the outer ring, points.
pub(super) const OUTER_RADIUS: f64 = SIZE + STROKE + 5.0;
/// Start and end of an arrow, points from the centre.
const ARROW: [f64; 2] = [DISC_RADIUS + 0.5 * STROKE, SIZE - 2.0 * STROKE];
/// Distance of a square's centre along both of its axes, and half its side, points.
const SQUARE: [f64; 2] = [0.5 * SIZE, 0.5 * (0.1 * SIZE + 2.0 * STROKE)];
/// Maximum distance at which a handle is picked, points.
const PICK_DISTANCE: f32 = 5.0;
/// Handles whose distances differ by less than this, points, count as equally close.
const PICK_TOLERANCE: f32 = 2.0;
/// Segments of a ring.
const SEGMENTS: u32 = 64;
/// Cosine of the angle between arrow and view direction at which the arrow begins to fade, and at which it is
/// invisible.
const ARROW_FADE: [f64; 2] = [0.95, 0.99];
/// Cosine of the angle between a square's normal and the view direction at which it is invisible, and from which it is
/// opaque.
const SQUARE_FADE: [f64; 2] = [0.14, 0.3];
/// Fraction of a ring's radius that is drawn behind its centre; seen from the front, the whole ring is drawn.
const RING_BACK: f64 = 0.1;

/// A world axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    pub(super) fn unit(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }

    /// The other two axes, ordered so that their cross product is this one.
    pub(super) fn others(self) -> [DVec3; 2] {
        match self {
            Self::X => [DVec3::Y, DVec3::Z],
            Self::Y => [DVec3::Z, DVec3::X],
            Self::Z => [DVec3::X, DVec3::Y],
        }
    }

    fn colour(self) -> Color32 {
        match self {
            Self::X => Color32::from_rgb(255, 0, 125),
            Self::Y => Color32::from_rgb(0, 255, 125),
            Self::Z => Color32::from_rgb(0, 125, 255),
        }
    }
}

/// A handle of the gizmo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Handle {
    /// Moves along an axis.
    Arrow(Axis),
    /// Moves in the plane perpendicular to an axis.
    PlaneSquare(Axis),
    /// Moves in the view plane.
    Disc,
    /// Rotates about an axis.
    Ring(Axis),
    /// Rotates about the view axis.
    ViewRing,
    /// Scales.
    ScaleRing,
}

impl Handle {
    /// Handles of a mode.
    pub(super) fn of(kind: GizmoMode) -> &'static [Self] {
        use Axis::{X, Y, Z};
        match kind {
            GizmoMode::Move => &[
                Self::Arrow(X),
                Self::Arrow(Y),
                Self::Arrow(Z),
                Self::PlaneSquare(X),
                Self::PlaneSquare(Y),
                Self::PlaneSquare(Z),
                Self::Disc,
            ],
            GizmoMode::Rotate => &[Self::Ring(X), Self::Ring(Y), Self::Ring(Z), Self::ViewRing],
            GizmoMode::Scale => &[Self::ScaleRing],
        }
    }

    pub(super) fn colour(self) -> Color32 {
        match self {
            Self::Arrow(axis) | Self::PlaneSquare(axis) | Self::Ring(axis) => axis.colour(),
            Self::Disc | Self::ViewRing | Self::ScaleRing => Color32::WHITE,
        }
    }
}

/// The gizmo at a point in front of the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gizmo {
    pub(super) projection: Projection,
    /// Centre in world space, metres.
    pub(super) origin: DVec3,
    /// Centre in the window.
    pub(super) middle: Pos2,
    /// World-space size of a window point at the depth of the centre, metres.
    pub(super) metres_per_point: f64,
    /// Unit vector from the centre to the camera.
    pub(super) to_camera: DVec3,
}

impl Gizmo {
    /// Places the gizmo; `None` if its centre is behind the camera.
    pub(super) fn new(projection: Projection, origin: DVec3) -> Option<Self> {
        let depth = projection.depth(origin)?;
        let middle = projection.project(origin)?;
        let to_camera = (projection.position - origin).normalize_or_zero();
        Some(Self { projection, origin, middle, metres_per_point: depth / projection.scale, to_camera })
    }

    /// Opacity of a handle; at 0 it is neither drawn nor picked.
    pub(super) fn opacity(&self, handle: Handle) -> f64 {
        let faded = |value: f64, [gone, whole]: [f64; 2]| ((value - gone) / (whole - gone)).clamp(0.0, 1.0);
        match handle {
            Handle::Arrow(axis) => {
                let [begins, gone] = ARROW_FADE;
                faded(axis.unit().dot(self.to_camera).abs(), [gone, begins])
            }
            Handle::PlaneSquare(axis) => faded(axis.unit().dot(self.to_camera).abs(), SQUARE_FADE),
            _ => 1.0,
        }
    }

    /// World-space point at a distance in window points from the centre.
    fn at(&self, direction: DVec3, points: f64) -> DVec3 {
        self.origin + direction * (points * self.metres_per_point)
    }

    /// Start and end of an arrow.
    pub(super) fn arrow(&self, axis: Axis) -> [DVec3; 2] {
        ARROW.map(|points| self.at(axis.unit(), points))
    }

    /// Corners of a square.
    pub(super) fn square(&self, axis: Axis) -> [DVec3; 4] {
        let [u, v] = axis.others();
        let [middle, half] = SQUARE;
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[a, b]| self.origin + (u * (middle + a * half) + v * (middle + b * half)) * self.metres_per_point)
    }

    /// Segments of a ring; without the far half unless `whole` or seen from the front.
    pub(super) fn ring(&self, axis: Axis, whole: bool) -> Vec<[DVec3; 2]> {
        let [u, v] = axis.others();
        let out = |k: u32| {
            let (sin, cos) = (f64::from(k) / f64::from(SEGMENTS) * TAU).sin_cos();
            u * cos + v * sin
        };
        let segments = (0..SEGMENTS).map(|k| [out(k), out(k + 1)]);
        let seen = segments.filter(|[a, b]| whole || (*a + *b).dot(self.to_camera) * 0.5 > -RING_BACK);
        seen.map(|ends| ends.map(|out| self.at(out, SIZE))).collect()
    }

    /// Picks the closest handle at a window point; of equally close ones, the one in front.
    pub(super) fn pick(&self, handles: &[Handle], at: Pos2) -> Option<Handle> {
        let visible = handles.iter().filter(|handle| self.opacity(**handle) > 0.0);
        let near = visible.filter_map(|handle| Some((*handle, self.distance(*handle, at)?)));
        let caught: Vec<_> = near.filter(|(_, near)| near.distance <= PICK_DISTANCE).collect();
        let least = caught.iter().map(|(_, near)| near.distance).fold(f32::INFINITY, f32::min);
        let nearest = caught.into_iter().filter(|(_, near)| near.distance <= least + PICK_TOLERANCE);
        nearest.min_by(|(_, a), (_, b)| a.depth.total_cmp(&b.depth)).map(|(handle, _)| handle)
    }

    /// Distance of a handle from a window point; `None` if it is entirely behind the camera.
    fn distance(&self, handle: Handle, at: Pos2) -> Option<Near> {
        let depth = self.metres_per_point * self.projection.scale;
        let from_middle = at.distance(self.middle);
        let round = |distance: f32| Some(Near { distance: distance.max(0.0), depth });
        let line = |segments: &[[DVec3; 2]]| {
            let near = segments.iter().filter_map(|ends| self.distance_to_segment(*ends, at));
            let nearest = near.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
            Some(Near { distance: (nearest.distance - 0.5 * STROKE as f32).max(0.0), ..nearest })
        };
        match handle {
            Handle::Disc => round(from_middle - DISC_RADIUS as f32),
            Handle::ViewRing | Handle::ScaleRing => {
                round((from_middle - OUTER_RADIUS as f32).abs() - 0.5 * STROKE as f32)
            }
            Handle::Arrow(axis) => line(&[self.arrow(axis)]),
            Handle::Ring(axis) => line(&self.ring(axis, false)),
            Handle::PlaneSquare(axis) => {
                let corners = self.square(axis);
                let edges: [_; 4] = std::array::from_fn(|k| [corners[k], corners[(k + 1) % 4]]);
                let near = line(&edges)?;
                let places = corners.map(|corner| self.projection.project(corner));
                let inside =
                    places.iter().all(Option::is_some) && is_inside(&places.map(Option::unwrap_or_default), at);
                Some(if inside { Near { distance: 0.0, ..near } } else { near })
            }
        }
    }

    /// Distance of a segment from a window point; `None` if one end is behind the camera.
    fn distance_to_segment(&self, ends: [DVec3; 2], at: Pos2) -> Option<Near> {
        let [Some(a), Some(b)] = ends.map(|end| self.projection.project(end)) else { return None };
        let [Some(depth_a), Some(depth_b)] = ends.map(|end| self.projection.depth(end)) else { return None };
        let along = b - a;
        let share = ((at - a).dot(along) / along.length_sq().max(1e-12)).clamp(0.0, 1.0);
        // In perspective, 1/depth is linear along a projected segment.
        let depth = 1.0 / egui::lerp(1.0 / depth_a..=1.0 / depth_b, f64::from(share));
        Some(Near { distance: at.distance(a + along * share), depth })
    }
}

/// Distance between handle and pointer.
#[derive(Clone, Copy, Debug)]
struct Near {
    /// Distance from the handle's edge, window points; 0 inside.
    distance: f32,
    /// Depth of the closest point, metres.
    depth: f64,
}

/// Returns true if a point is inside a convex polygon.
fn is_inside(corners: &[Pos2], at: Pos2) -> bool {
    let cross = |a: Vec2, b: Vec2| a.x * b.y - a.y * b.x;
    let next = corners.iter().cycle().skip(1);
    let mut sides = corners.iter().zip(next).map(|(a, b)| cross(*b - *a, at - *a));
    let Some(first) = sides.next() else { return false };
    sides.all(|side| side * first >= 0.0)
}
