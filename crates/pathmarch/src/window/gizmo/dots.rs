//! Dots: round handles at points of world space, such as the control points of a profile.

use super::drag::{Plane, nearest_on_axis};
use crate::window::projection::Projection;
use egui::{Color32, Painter, Pos2, Stroke, Vec2};
use glam::DVec3;
use pathmarch_render::pathmarch_scene::document::Path;

/// Radius of a dot, and distance at which the pointer picks it, points.
const RADIUS: f32 = 4.5;
const PICK_DISTANCE: f32 = 8.0;
/// Least cosine between a plane's normal and the view direction at which dots in it can be dragged.
const EDGE_ON: f64 = 0.06;

/// Meaning of a dot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DotId {
    /// Control point of a profile, by its index.
    ControlPoint(usize),
    /// Size of a shape, by the index of its parameter.
    Size(usize),
    /// Target of a spot light.
    Target,
    /// Edge of the cone of a spot light.
    Cone,
    /// Inner edge of the soft part of that cone.
    Blend,
}

/// Where a dot can be dragged to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Way {
    /// A plane through it.
    Plane(Plane),
    /// A line through it, along a unit vector.
    Line(DVec3),
    /// The plane through it that is parallel to the image plane.
    View,
}

/// A round handle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dot {
    pub(super) id: DotId,
    /// Position in world space, metres.
    pub(super) at: DVec3,
    pub(super) way: Way,
    pub(super) colour: Color32,
}

impl Dot {
    /// Point in the window; `None` behind the camera, and where a drag would lead nowhere.
    fn place(&self, projection: &Projection) -> Option<Pos2> {
        let to_camera = (projection.position - self.at).normalize_or_zero();
        let is_movable = match self.way {
            Way::Plane(plane) => plane.normal.dot(to_camera).abs() > EDGE_ON,
            Way::Line(direction) => direction.dot(to_camera).abs() < 1.0 - 0.5 * EDGE_ON * EDGE_ON,
            Way::View => true,
        };
        projection.project(self.at).filter(|_| is_movable)
    }
}

/// The dot nearest to a point of the window, if the pointer is on it there.
pub(super) fn pick(dots: &[Dot], projection: &Projection, at: Pos2) -> Option<Dot> {
    let near = dots.iter().filter_map(|dot| Some((dot.place(projection)?.distance(at), dot)));
    let (_, dot) = near.filter(|(distance, _)| *distance <= PICK_DISTANCE).min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(*dot)
}

/// Draws dots; the marked one is larger.
pub(super) fn draw(painter: &Painter, dots: &[Dot], projection: &Projection, marked: Option<DotId>) {
    for dot in dots {
        let Some(at) = dot.place(projection) else { continue };
        let is_marked = marked == Some(dot.id);
        let radius = if is_marked { RADIUS + 1.5 } else { RADIUS };
        painter.circle(at, radius, dot.colour, Stroke::new(1.5, Color32::from_black_alpha(190)));
    }
}

/// Draws a plus: a press there adds a point.
pub(super) fn draw_plus(painter: &Painter, at: Pos2) {
    painter.circle(at, RADIUS + 1.5, Color32::from_black_alpha(190), Stroke::new(1.0, Color32::WHITE));
    for arm in [Vec2::new(3.5, 0.0), Vec2::new(0.0, 3.5)] {
        painter.line_segment([at - arm, at + arm], Stroke::new(1.5, Color32::WHITE));
    }
}

/// A drag of a dot in progress.
#[derive(Clone, Debug)]
pub(super) struct DotDrag {
    /// Node whose dot it is, and the number of dots that the node has.
    pub(super) path: Path,
    pub(super) count: usize,
    pub(super) dot: Dot,
    /// The point, or the position along the line, that was grabbed.
    grabbed: DVec3,
    from: Pos2,
    moved: bool,
}

impl DotDrag {
    /// Begins a drag at a window point; `None` if its ray does not meet the plane or line.
    pub(super) fn begin(path: Path, count: usize, dot: Dot, projection: &Projection, at: Pos2) -> Option<Self> {
        let grabbed = on_way(&dot, projection, at)?;
        Some(Self { path, count, dot, grabbed, from: at, moved: false })
    }

    /// New position of the dot; `None` before the first movement, or where the ray does not meet its plane or line.
    pub(super) fn to(&mut self, projection: &Projection, at: Pos2) -> Option<DVec3> {
        self.moved |= at != self.from;
        if !self.moved {
            return None;
        }
        Some(self.dot.at + on_way(&self.dot, projection, at)? - self.grabbed)
    }
}

/// The point of a dot's plane or line under a window point.
fn on_way(dot: &Dot, projection: &Projection, at: Pos2) -> Option<DVec3> {
    projection.depth(dot.at)?;
    let ray = projection.ray_through(at);
    match dot.way {
        Way::Plane(plane) => plane.intersect(dot.at, ray),
        Way::View => Plane::of_view(projection).intersect(dot.at, ray),
        Way::Line(direction) => Some(dot.at + direction * nearest_on_axis(dot.at, direction, ray)?),
    }
}
