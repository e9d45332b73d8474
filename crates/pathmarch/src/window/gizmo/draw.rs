//! Drawing of the handles as egui shapes.

use super::drag::Drag;
use super::shape::{Axis, DISC_RADIUS, Gizmo, Handle, OUTER_RADIUS, SIZE, STROKE};
use crate::window::projection::Projection;
use egui::{Color32, Painter, Pos2, Shape, Stroke};
use glam::DVec3;

/// Opacity of a handle that the pointer is not on.
const IDLE: f32 = 0.7;
/// Length and half width of an arrow tip, points.
const TIP: [f32; 2] = [2.4 * STROKE as f32, 1.2 * STROKE as f32];
/// Angle covered by one triangle of a sector, radians.
const SECTOR_STEP: f64 = 0.1;

/// Draws all handles from back to front; during a drag, only the dragged one.
pub(super) fn draw(painter: &Painter, gizmo: &Gizmo, handles: &[Handle], hovered: Option<Handle>, held: Option<&Drag>) {
    let mut handles: Vec<Handle> =
        handles.iter().copied().filter(|handle| held.is_none_or(|drag| drag.handle == *handle)).collect();
    handles.sort_by(|a, b| depth_order(gizmo, *a).total_cmp(&depth_order(gizmo, *b)));
    for handle in handles {
        let strong = hovered == Some(handle) || held.is_some();
        let opacity = gizmo.opacity(handle) as f32 * if strong { 1.0 } else { IDLE };
        if opacity <= 0.0 {
            continue;
        }
        let colour = handle.colour().gamma_multiply(opacity);
        let stroke = Stroke::new(STROKE as f32, colour);
        match handle {
            Handle::Arrow(axis) => arrow(painter, gizmo, axis, stroke),
            Handle::PlaneSquare(axis) => {
                let corners: Option<Vec<Pos2>> =
                    gizmo.square(axis).into_iter().map(|corner| gizmo.projection.project(corner)).collect();
                if let Some(corners) = corners {
                    painter.add(Shape::convex_polygon(corners, colour, Stroke::NONE));
                }
            }
            Handle::Disc => {
                painter.circle_stroke(gizmo.middle, DISC_RADIUS as f32, stroke);
            }
            Handle::Ring(axis) => ring(painter, gizmo, axis, held.is_some(), stroke),
            Handle::ViewRing | Handle::ScaleRing => {
                painter.circle_stroke(gizmo.middle, OUTER_RADIUS as f32, stroke);
            }
        }
        if let Some(([u, v], first, turned)) = held.and_then(Drag::sector) {
            let radius = gizmo.metres_per_point * if handle == Handle::ViewRing { OUTER_RADIUS } else { SIZE };
            sector(painter, gizmo, [u * radius, v * radius], [first, turned], colour);
        }
    }
}

/// Draws the cone of a spot light from its position to its target, `axis` away, with its radii there: that of the edge, and
/// that up to which the light has its full intensity.
pub(super) fn draw_cone(painter: &Painter, projection: &Projection, apex: DVec3, axis: DVec3, radii: [f64; 2]) {
    const SEGMENTS: u32 = 48;
    let across = axis.normalize_or(DVec3::NEG_Y).any_orthonormal_vector();
    let beside = axis.normalize_or_zero().cross(across);
    let rim = |radius: f64, k: u32| {
        let (sine, cosine) = (f64::from(k) / f64::from(SEGMENTS) * std::f64::consts::TAU).sin_cos();
        projection.project(apex + axis + (across * cosine + beside * sine) * radius)
    };
    let line = |a: Option<Pos2>, b: Option<Pos2>, strength: f32| {
        if let (Some(a), Some(b)) = (a, b) {
            let stroke = Stroke::new(0.3 * STROKE as f32, Color32::WHITE.gamma_multiply(strength * IDLE));
            painter.line_segment([a, b], stroke);
        }
    };
    let [outer, inner] = radii;
    (0..SEGMENTS).for_each(|k| line(rim(outer, k), rim(outer, k + 1), 1.0));
    (0..SEGMENTS).for_each(|k| line(rim(inner, k), rim(inner, k + 1), 0.5));
    (0..4).for_each(|quarter| line(projection.project(apex), rim(outer, quarter * SEGMENTS / 4), 1.0));
    line(projection.project(apex), projection.project(apex + axis), 1.0);
}

/// Sort key of a handle: its extent towards the camera.
fn depth_order(gizmo: &Gizmo, handle: Handle) -> f64 {
    match handle {
        Handle::Arrow(axis) => axis.unit().dot(gizmo.to_camera),
        Handle::PlaneSquare(axis) => axis.others().map(|other| 0.5 * other.dot(gizmo.to_camera)).iter().sum(),
        _ => 0.0,
    }
}

fn arrow(painter: &Painter, gizmo: &Gizmo, axis: Axis, stroke: Stroke) {
    let [Some(start), Some(end)] = gizmo.arrow(axis).map(|end| gizmo.projection.project(end)) else { return };
    let along = (end - start).normalized();
    // Shorten the tip of an arrow seen from its end.
    let [length, half] = [TIP[0].min((end - start).length()), TIP[1]];
    let (neck, side) = (end - along * length, along.rot90() * half);
    painter.line_segment([start, neck], stroke);
    painter.add(Shape::convex_polygon(vec![end, neck + side, neck - side], stroke.color, Stroke::NONE));
}

fn ring(painter: &Painter, gizmo: &Gizmo, axis: Axis, whole: bool, stroke: Stroke) {
    let mut line: Vec<Pos2> = Vec::new();
    let mut last: Option<DVec3> = None;
    let mut lines = Vec::new();
    for [from, to] in gizmo.ring(axis, whole) {
        let (Some(a), Some(b)) = (gizmo.projection.project(from), gizmo.projection.project(to)) else { continue };
        // Join consecutive segments to one line, so that its corners are drawn once.
        if last.is_none_or(|last| last.distance(from) > 1e-6 * gizmo.metres_per_point * SIZE) {
            lines.push(std::mem::replace(&mut line, vec![a]));
        }
        line.push(b);
        last = Some(to);
    }
    lines.push(line);
    // The visible part of a ring may begin in the middle of the list.
    if lines.len() > 2 && lines[1].first().zip(lines[lines.len() - 1].last()).is_some_and(|(a, b)| a.distance(*b) < 0.1)
    {
        let first = lines.remove(1);
        if let Some(last) = lines.last_mut() {
            last.extend(first.into_iter().skip(1));
        }
    }
    for line in lines.into_iter().filter(|line| line.len() > 1) {
        let closed = line.len() > 3 && line[0].distance(line[line.len() - 1]) < 0.1;
        let open = line.len() - usize::from(closed);
        let points = line[..open].to_vec();
        painter.add(if closed { Shape::closed_line(points, stroke) } else { Shape::line(points, stroke) });
    }
}

/// Draws the sector between the grabbed and the current angle of a ring.
fn sector(painter: &Painter, gizmo: &Gizmo, [u, v]: [DVec3; 2], [first, turned]: [f64; 2], colour: Color32) {
    let point = |angle: f64| gizmo.projection.project(gizmo.origin + u * angle.cos() + v * angle.sin());
    let Some((from, to)) = point(first).zip(point(first + turned)) else { return };
    let fill = colour.gamma_multiply(0.25);
    // A full turn or more covers the whole disc.
    let shown = turned.clamp(-std::f64::consts::TAU, std::f64::consts::TAU);
    let steps = (shown.abs() / SECTOR_STEP).ceil().max(1.0) as u32;
    let rim: Vec<Option<Pos2>> = (0..=steps).map(|k| point(first + shown * f64::from(k) / f64::from(steps))).collect();
    let mut mesh = egui::Mesh::default();
    mesh.colored_vertex(gizmo.middle, fill);
    for ends in rim.windows(2) {
        if let [Some(a), Some(b)] = ends {
            let at = mesh.vertices.len() as u32;
            mesh.colored_vertex(*a, fill);
            mesh.colored_vertex(*b, fill);
            mesh.add_triangle(0, at, at + 1);
        }
    }
    painter.add(mesh);
    let stroke = Stroke::new(0.5 * STROKE as f32, colour);
    painter.line_segment([gizmo.middle, from], stroke);
    painter.line_segment([gizmo.middle, to], stroke);
}
