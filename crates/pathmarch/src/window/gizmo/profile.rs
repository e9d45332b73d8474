//! Control points of a profile, dragged in its plane.
//!
//! **Idea.** A profile that is turned about an axis looks the same from all sides, so its points are shown in the half
//! plane that faces the camera, where they are on the silhouette. Those of an extruded profile are shown on the end that
//! faces the camera.

use super::dots::{Dot, DotId, Way};
use super::drag::Plane;
use super::transform::{Transform, local_transform, present_number, round_to};
use crate::window::projection::Projection;
use egui::{Color32, Painter, Pos2, Stroke};
use glam::{DQuat, DVec3};
use pathmarch_render::pathmarch_field::outline::{Cubic, SplinePoint, through};
use pathmarch_render::pathmarch_field::{Outline, registry};
use pathmarch_render::pathmarch_scene::document::{ControlPoint, Document, ItemKind, Path};

/// Segments that a piece of a curve is drawn with.
const STEPS: usize = 16;
/// Distance from the outline at which the pointer adds a point, points.
const PICK_DISTANCE: f32 = 5.0;
/// Size of a step with Ctrl, window points, at least.
const SNAP_POINTS: f64 = 8.0;

/// Outline of the selected profile.
pub(super) struct Profile {
    pub(super) path: Path,
    points: Vec<ControlPoint>,
    /// Pieces of the outline, and the index that a point added on each would have.
    pieces: Vec<(Cubic, usize)>,
    /// From the plane of the profile, z = 0, to world space.
    to_world: Transform,
    /// Least x coordinate, at the axis of a turned profile.
    least_x: f64,
}

impl Profile {
    /// The profile of a selected shape, or the only one in a selected operator or object.
    pub(super) fn of(document: &Document, selection: &Path, camera: DVec3) -> Option<Self> {
        let mut item = document.item(selection)?;
        while let (ItemKind::Operator | ItemKind::Object, [only]) = (item.kind, &item.children[..]) {
            item = only;
        }
        let path = item.path.clone();
        let points = document.control_points(&path);
        if points.len() < 2 {
            return None;
        }
        let is_area = registry::solid(&item.word)?.info().outline? == Outline::Points;
        let filled = is_area || present_number(document, &path, "width").is_none_or(|width| width <= 0.0);
        let closed = filled || points.len() > 3 && points[0].at == points[points.len() - 1].at;
        let (to_world, least_x) = plane(document, &path, camera);
        Some(Self { path, pieces: pieces(&points, closed), points, to_world, least_x })
    }

    pub(super) fn point(&self, index: usize) -> Option<&ControlPoint> {
        self.points.get(index)
    }

    fn world(&self, [x, y]: [f32; 2]) -> DVec3 {
        let Transform { scale, rotation, translation } = self.to_world;
        translation + rotation * (scale * DVec3::new(f64::from(x), f64::from(y), 0.0))
    }

    /// Coordinates in the plane of the profile, rounded to what a pixel resolves; with `snapping`, to a round step.
    pub(super) fn coordinates(&self, point: DVec3, projection: &Projection, snapping: bool) -> [f32; 2] {
        let Transform { scale, rotation, translation } = self.to_world;
        let local = rotation.inverse() * (point - translation) / scale;
        let depth = projection.depth(point).unwrap_or(1.0);
        let pixel = (depth / projection.scale / scale).max(1e-9);
        let step = match snapping {
            false => 10_f64.powf(pixel.log10().floor()).max(1e-6),
            true => 10_f64.powf((SNAP_POINTS * pixel).log10().ceil()),
        };
        [round_to(local.x.max(self.least_x), step), round_to(local.y, step)]
    }

    fn plane(&self) -> Plane {
        let [u, v, normal] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.to_world.rotation * axis);
        Plane { u, v, normal }
    }

    /// The dot of a control point at this place.
    pub(super) fn dot(&self, index: usize, at: [f32; 2]) -> Dot {
        let is_corner = self.points.get(index).is_some_and(|point| point.is_corner);
        let colour = if is_corner { Color32::from_rgb(255, 170, 60) } else { Color32::WHITE };
        Dot { id: DotId::ControlPoint(index), at: self.world(at), way: Way::Plane(self.plane()), colour }
    }

    pub(super) fn dots(&self) -> Vec<Dot> {
        self.points.iter().enumerate().map(|(index, point)| self.dot(index, point.at)).collect()
    }

    /// Segments of the outline in front of the camera: piece, step within it, and ends in the window.
    fn segments(&self, projection: &Projection) -> impl Iterator<Item = (&(Cubic, usize), usize, [Pos2; 2])> {
        let all = self.pieces.iter().flat_map(|piece| (0..STEPS).map(move |step| (piece, step)));
        all.filter_map(|(piece, step)| {
            let end = |k: usize| projection.project(self.world(curve_point(&piece.0, k as f32 / STEPS as f32)));
            Some((piece, step, [end(step)?, end(step + 1)?]))
        })
    }

    /// The point of the outline under a window point: the index that a control point added there would have, its
    /// coordinates, and its place in the window.
    pub(super) fn on_outline(&self, projection: &Projection, at: Pos2) -> Option<(usize, [f32; 2], Pos2)> {
        let mut nearest: Option<(f32, usize, [f32; 2], Pos2)> = None;
        for ((cubic, index), step, [a, b]) in self.segments(projection) {
            let along = b - a;
            let share = ((at - a).dot(along) / along.length_sq().max(1e-9)).clamp(0.0, 1.0);
            let distance = at.distance(a + along * share);
            if distance <= PICK_DISTANCE && nearest.is_none_or(|(least, ..)| distance < least) {
                let parameter = (step as f32 + share) / STEPS as f32;
                nearest = Some((distance, *index, curve_point(cubic, parameter), a + along * share));
            }
        }
        nearest.map(|(_, index, point, place)| (index, point, place))
    }

    /// Draws the outline.
    pub(super) fn draw(&self, painter: &Painter, projection: &Projection) {
        for (.., ends) in self.segments(projection) {
            painter.line_segment(ends, Stroke::new(3.0, Color32::from_black_alpha(110)));
            painter.line_segment(ends, Stroke::new(1.5, Color32::WHITE));
        }
    }
}

/// Transform from the plane of a profile to world space, and the least x in it.
fn plane(document: &Document, path: &Path, camera: DVec3) -> (Transform, f64) {
    let mut around: Vec<Path> = std::iter::successors(Some(path.clone()), Path::parent).collect();
    around.reverse();
    let (mut world, mut least_x) = (Transform::IDENTITY, f64::NEG_INFINITY);
    for path in around {
        let own = local_transform(document, &path);
        world = world.then_local(own);
        // What is between axis and profile moves the axis in its coordinates.
        least_x = match own.rotation.is_near_identity() {
            true => (least_x - own.translation.x) / own.scale,
            false => f64::NEG_INFINITY,
        };
        let number = |key: &str| present_number(document, &path, key).unwrap_or(0.0);
        let to_camera = Transform::IDENTITY.to_local(world).rotation.inverse() * (camera - world.translation);
        match document.item(&path).map(|item| item.word.as_str()) {
            Some("revolve") => {
                let rotation = DQuat::from_rotation_y(to_camera.x.atan2(to_camera.z));
                let offset = number("offset");
                let translation = rotation * (DVec3::X * offset);
                world = world.then_local(Transform { rotation, translation, scale: 1.0 });
                least_x = -offset;
            }
            Some("extrude") => {
                let translation = DVec3::Z * (0.5 * number("height") * to_camera.z.signum());
                world = world.then_local(Transform { translation, ..Transform::IDENTITY });
            }
            _ => {}
        }
    }
    (world, least_x)
}

/// Pieces of an outline, and the index that a point added on each would have.
fn pieces(points: &[ControlPoint], closed: bool) -> Vec<(Cubic, usize)> {
    let spline: Vec<SplinePoint> =
        points.iter().map(|point| SplinePoint { at: point.at, is_corner: point.is_corner }).collect();
    // A point that repeats the one before it ends no piece.
    let last_of_equal =
        (0..points.len()).filter(|k| points.get(k + 1).is_none_or(|next| next.at != points[*k].at)).map(|k| k + 1);
    through(&spline, closed).into_iter().zip(last_of_equal).collect()
}

/// Point of a Bézier curve at a parameter from 0 to 1.
fn curve_point(Cubic([a, b, c, d]): &Cubic, t: f32) -> [f32; 2] {
    let s = 1.0 - t;
    [0, 1].map(|k| s * s * s * a[k] + 3.0 * s * s * t * b[k] + 3.0 * s * t * t * c[k] + t * t * t * d[k])
}
