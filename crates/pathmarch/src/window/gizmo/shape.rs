//! Shapes of the handles, and which of them is under the pointer.
//!
//! Everything is in points of the window, for handles have the same size however far they are; only directions and depths
//! come from the world. A handle that is seen from its end (an arrow) or from its edge (a square) fades away and cannot be
//! caught, for there its axis or plane is almost parallel to the rays of the pointer.

use crate::window::camera::projection::Projection;
use crate::window::open_scene::view_state::GizmoMode;
use egui::{Color32, Pos2, Vec2};
use glam::DVec3;
use std::f64::consts::TAU;

/// Length of the handles, points.
pub(super) const SIZE: f64 = 75.0;
/// Width of lines, points.
pub(super) const STROKE: f64 = 4.0;
/// Radius of the disc in the middle, points.
pub(super) const DISC_RADIUS: f64 = 0.2 * SIZE;
/// Radius of the ring around everything, points.
pub(super) const OUTER_RADIUS: f64 = SIZE + STROKE + 5.0;
/// An arrow from its start to its end, points from the middle.
const ARROW: [f64; 2] = [DISC_RADIUS + 0.5 * STROKE, SIZE - 2.0 * STROKE];
/// Distance of a square's middle along both of its axes, and half its side, points.
const SQUARE: [f64; 2] = [0.5 * SIZE, 0.5 * (0.1 * SIZE + 2.0 * STROKE)];
/// A handle is caught this far from its line, points.
const PICK_DISTANCE: f32 = 5.0;
/// GizmoMode whose distances from the pointer differ by less than this, points, count as equally near.
const PICK_TOLERANCE: f32 = 2.0;
/// Segments of a ring.
const SEGMENTS: u32 = 64;
/// Cosine of the angle between an arrow and the view at which it begins to fade, and at which it is gone.
const ARROW_FADE: [f64; 2] = [0.95, 0.99];
/// Cosine of the angle between a square's normal and the view at which it is gone, and above which it is whole.
const SQUARE_FADE: [f64; 2] = [0.14, 0.3];
/// Handle of a ring's radius by which what is drawn of it reaches behind its middle: all of it, seen from the front.
const RING_BACK: f64 = 0.1;

/// An axis of the world.
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

    /// The two others, in an order in which their cross product is this one.
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

/// One handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Handle {
    /// Moves along an axis.
    Arrow(Axis),
    /// Moves in the plane across an axis.
    PlaneSquare(Axis),
    /// Moves in the plane of the picture.
    Disc,
    /// Turns about an axis.
    Ring(Axis),
    /// Turns about the axis of the camera.
    ViewRing,
    /// Scales.
    ScaleRing,
}

impl Handle {
    /// The handles of a kind.
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

/// The handles of a point that is before the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gizmo {
    pub(super) projection: Projection,
    /// The middle, in the world.
    pub(super) origin: DVec3,
    /// The middle, in the window.
    pub(super) middle: Pos2,
    /// Metres of the world for a point of the window, at the depth of the middle.
    pub(super) metres_per_point: f64,
    /// Unit vector from the middle to the camera.
    pub(super) to_camera: DVec3,
}

impl Gizmo {
    /// None where the middle is not before the camera.
    pub(super) fn new(projection: Projection, origin: DVec3) -> Option<Self> {
        let depth = projection.depth(origin)?;
        let middle = projection.project(origin)?;
        let to_camera = (projection.position - origin).normalize_or_zero();
        Some(Self { projection, origin, middle, metres_per_point: depth / projection.scale, to_camera })
    }

    /// Opacity of a handle; one of 0 is neither drawn nor caught.
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

    /// A point of the world beside the middle, by points of the window along a unit vector.
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

    /// Segments of a ring; of those behind its middle only where `whole` or seen from the front.
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

    /// The handle under a point of the window: the nearest within a few points, and of those that are equally near the
    /// one in front.
    pub(super) fn pick(&self, handles: &[Handle], at: Pos2) -> Option<Handle> {
        let visible = handles.iter().filter(|handle| self.opacity(**handle) > 0.0);
        let near = visible.filter_map(|handle| Some((*handle, self.distance(*handle, at)?)));
        let caught: Vec<_> = near.filter(|(_, near)| near.distance <= PICK_DISTANCE).collect();
        let least = caught.iter().map(|(_, near)| near.distance).fold(f32::INFINITY, f32::min);
        let nearest = caught.into_iter().filter(|(_, near)| near.distance <= least + PICK_TOLERANCE);
        nearest.min_by(|(_, a), (_, b)| a.depth.total_cmp(&b.depth)).map(|(handle, _)| handle)
    }

    /// How near a handle comes to a point of the window; none where nothing of it is before the camera.
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

    /// How near a segment comes in the window; none where an end of it is not before the camera.
    fn distance_to_segment(&self, ends: [DVec3; 2], at: Pos2) -> Option<Near> {
        let [Some(a), Some(b)] = ends.map(|end| self.projection.project(end)) else { return None };
        let [Some(depth_a), Some(depth_b)] = ends.map(|end| self.projection.depth(end)) else { return None };
        let along = b - a;
        let share = ((at - a).dot(along) / along.length_sq().max(1e-12)).clamp(0.0, 1.0);
        // In a perspective picture the reciprocal of the depth is linear.
        let depth = 1.0 / egui::lerp(1.0 / depth_a..=1.0 / depth_b, f64::from(share));
        Some(Near { distance: at.distance(a + along * share), depth })
    }
}

/// How near a handle comes to the pointer.
#[derive(Clone, Copy, Debug)]
struct Near {
    /// From its edge, in points of the window; 0 on it.
    distance: f32,
    /// Depth of its nearest point, metres.
    depth: f64,
}

/// Whether a point is inside a convex polygon.
fn is_inside(corners: &[Pos2], at: Pos2) -> bool {
    let cross = |a: Vec2, b: Vec2| a.x * b.y - a.y * b.x;
    let next = corners.iter().cycle().skip(1);
    let mut sides = corners.iter().zip(next).map(|(a, b)| cross(*b - *a, at - *a));
    let Some(first) = sides.next() else { return false };
    sides.all(|side| side * first >= 0.0)
}
