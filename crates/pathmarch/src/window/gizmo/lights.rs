//! Handles of point and spot lights.

use super::dots::{Dot, DotId, Way};
use super::transform::{Transform, present_number, present_value, round_to};
use crate::window::open_scene::view_state::GizmoMode;
use crate::window::projection::Projection;
use egui::Color32;
use glam::{DQuat, DVec3};
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value};
use pathmarch_render::pathmarch_scene::light::spot_cosines;

/// Property keys of lights: position, the point that a spot shines at, its full angle, and its soft share.
const AT: &str = "at";
const TARGET: &str = "target";
const CONE: &str = "cone";
const BLEND: &str = "blend";
/// Largest half angle of a cone that is drawn, degrees: wider cones have no base.
pub(super) const WIDEST: f64 = 85.0;
/// Step of a cone's angle with Ctrl, degrees.
const SNAP_DEGREES: f64 = 5.0;
const COLOUR: Color32 = Color32::from_rgb(255, 220, 110);

/// Light that the gizmo changes.
#[derive(Clone, Copy)]
pub(super) enum LightHandles {
    /// Point light, which can be moved.
    Point,
    /// Spot light, which can be turned, too, and whose cone can be scaled.
    Spot(SpotCone),
}

/// Cone of a spot light.
#[derive(Clone, Copy)]
pub(super) struct SpotCone {
    /// Position, metres.
    at: DVec3,
    /// Unit vector along the axis.
    pub(super) direction: DVec3,
    /// Distance of the target, metres.
    pub(super) distance: f64,
    /// Full angle, degrees.
    pub(super) angle: f64,
    /// Soft share.
    blend: f64,
}

impl LightHandles {
    /// The light of a node, and its transform: a spot shines along -y, and its scale is the angle of its cone. `None` for other
    /// nodes.
    pub(super) fn of(document: &Document, path: &Path) -> Option<(Self, Transform)> {
        let triple = |key: &str| match present_value(document, path, key) {
            Some(Value::Triple(value)) => Some(DVec3::from_array(value.map(f64::from))),
            _ => None,
        };
        let number = |key: &str| present_number(document, path, key);
        let at = Transform { translation: triple(AT)?, ..Transform::IDENTITY };
        match document.item(path)?.kind {
            ItemKind::Point => Some((Self::Point, at)),
            ItemKind::Spot => {
                let axis = triple(TARGET)? - at.translation;
                let direction = axis.try_normalize().unwrap_or(DVec3::NEG_Y);
                let (angle, blend) = (number(CONE)?, number(BLEND)?);
                let distance = axis.length().max(1e-6);
                let cone = SpotCone { at: at.translation, direction, distance, angle, blend };
                let rotation = DQuat::from_rotation_arc(DVec3::NEG_Y, direction);
                Some((Self::Spot(cone), Transform { rotation, scale: cone.angle, ..at }))
            }
            _ => None,
        }
    }

    /// Mode of the gizmo for this light.
    pub(super) fn mode(self, mode: GizmoMode) -> GizmoMode {
        match self {
            Self::Point => GizmoMode::Move,
            Self::Spot(_) => mode,
        }
    }

    /// Property value that gives the light its new transform.
    pub(super) fn change(self, mode: GizmoMode, new: Transform) -> (&'static str, Value) {
        match (self, mode) {
            (Self::Spot(cone), GizmoMode::Rotate) => {
                (TARGET, triple(new.translation + new.rotation * (DVec3::NEG_Y * cone.distance)))
            }
            (Self::Spot(_), GizmoMode::Scale) => (CONE, Value::Number(round_to(new.scale.clamp(0.1, 180.0), 0.1))),
            _ => (AT, triple(new.translation)),
        }
    }
}

fn triple(v: DVec3) -> Value {
    Value::Triple(v.to_array().map(|v| round_to(v, 1e-3)))
}

impl SpotCone {
    /// Half angle up to which the light has its full intensity, radians.
    fn inner_angle(&self) -> f64 {
        let [_, inner] = spot_cosines(self.angle as f32, self.blend as f32);
        f64::from(inner.clamp(-1.0, 1.0)).acos()
    }

    /// Distance of a ray at this angle from the axis, in the plane through the target, metres.
    fn radius(&self, angle: f64) -> f64 {
        self.distance * angle.min(WIDEST.to_radians()).tan()
    }

    pub(super) fn inner_radius(&self) -> f64 {
        self.radius(self.inner_angle())
    }

    pub(super) fn outer_radius(&self) -> f64 {
        self.radius((0.5 * self.angle).to_radians())
    }

    /// Unit vector across the axis, to the right in the picture.
    fn across(&self, projection: &Projection) -> DVec3 {
        let right = projection.right - self.direction * projection.right.dot(self.direction);
        right.try_normalize().unwrap_or_else(|| self.direction.any_orthonormal_vector())
    }

    /// Dots of the target, of the edge of the cone, and on the other side of its soft part.
    pub(super) fn dots(&self, projection: &Projection) -> [Dot; 3] {
        let target = self.at + self.direction * self.distance;
        let across = self.across(projection);
        let dot = |id, at, way| Dot { id, at, way, colour: COLOUR };
        [
            dot(DotId::Target, target, Way::View),
            dot(DotId::Cone, target + across * self.outer_radius(), Way::Line(across)),
            dot(DotId::Blend, target - across * self.inner_radius(), Way::Line(across)),
        ]
    }

    /// Property and value with which a dot is at this point.
    pub(super) fn change(
        &self,
        id: DotId,
        at: DVec3,
        projection: &Projection,
        snapping: bool,
    ) -> (&'static str, Value) {
        let target = self.at + self.direction * self.distance;
        let out = (at - target).dot(self.across(projection));
        let half_angle = |radius: f64| (radius.max(0.0) / self.distance).atan().to_degrees();
        match id {
            DotId::Cone => {
                let angle = 2.0 * half_angle(out);
                let angle = if snapping { (angle / SNAP_DEGREES).round() * SNAP_DEGREES } else { angle };
                (CONE, Value::Number(round_to(angle.clamp(0.1, 180.0), 0.1)))
            }
            DotId::Blend => {
                let outer = (0.5 * self.angle).to_radians().cos();
                let inner = half_angle(-out).to_radians().cos();
                let blend = ((inner - outer) / (1.0 - outer).max(1e-9)).clamp(0.0, 1.0);
                (BLEND, Value::Number(round_to(blend, if snapping { 0.1 } else { 0.01 })))
            }
            _ => (TARGET, triple(at)),
        }
    }
}
