//! Handles in the picture that move, turn and scale what is selected.
//!
//! The handles are those of the crate transform-gizmo, which works in the world; placements of the scene language are
//! relative to the operators around them, so that what comes from the handles goes through their inverse.

use super::open::Handles;
use super::viewpoint::axes;
use egui::{Color32, Pos2, Rect};
use glam::{DMat4, DQuat, DVec3, EulerRot};
use pathmarch_render::pathmarch_scene::Camera;
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value, key};
use transform_gizmo::math::Transform;
use transform_gizmo::{EnumSet, Gizmo, GizmoConfig, GizmoInteraction, GizmoMode, GizmoOrientation, GizmoVisuals};

/// Where a node stands: uniform scale, then turn, then place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) scale: f64,
    pub(super) turn: DQuat,
    pub(super) at: DVec3,
}

impl Placed {
    const NOWHERE: Self = Self { scale: 1.0, turn: DQuat::IDENTITY, at: DVec3::ZERO };

    /// What `inner`, which stands in this, is in the world.
    fn around(self, inner: Self) -> Self {
        Self {
            scale: self.scale * inner.scale,
            turn: self.turn * inner.turn,
            at: self.at + self.turn * (self.scale * inner.at),
        }
    }

    /// What stands in this and is `world` in the world.
    fn inside(self, world: Self) -> Self {
        let back = self.turn.inverse();
        Self { scale: world.scale / self.scale, turn: back * world.turn, at: back * (world.at - self.at) / self.scale }
    }

    /// Degrees about the fixed x, then y, then z axis.
    pub(super) fn degrees(self) -> [f32; 3] {
        let (z, y, x) = self.turn.to_euler(EulerRot::ZYX);
        [x, y, z].map(|angle| tidy(angle.to_degrees(), 1e-3))
    }
}

/// A number without the dust of computing.
fn tidy(value: f64, step: f64) -> f32 {
    let value = (value / step).round() * step;
    // Not -0, and not 0.30000000000000004.
    (value + 0.0) as f32
}

/// What `key` of a node says.
fn given(document: &Document, path: &Path, key: &str) -> Option<Value> {
    document.control(path, key).map(|control| control.present)
}

fn own_placement(document: &Document, path: &Path) -> Placed {
    let mut placed = Placed::NOWHERE;
    if let Some(Value::Triple(at)) = given(document, path, key::AT) {
        placed.at = at.map(f64::from).into();
    }
    if let Some(Value::Triple(turn)) = given(document, path, key::ROTATE) {
        let [x, y, z] = turn.map(|angle| f64::from(angle).to_radians());
        placed.turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
    }
    if let Some(Value::Number(scale)) = given(document, path, key::SCALE) {
        placed.scale = f64::from(scale);
    }
    placed
}

/// The operators around a node, from the outside, as one placement.
fn placement_around(document: &Document, path: &Path) -> Placed {
    let mut ancestors = Vec::new();
    let mut at = path.parent();
    while let Some(path) = at {
        at = path.parent();
        ancestors.push(path);
    }
    ancestors.iter().rev().fold(Placed::NOWHERE, |outer, path| outer.around(own_placement(document, path)))
}

/// The node that handles act on: a shape, an operator, a light; of an object, its only shape.
pub(super) fn handled(document: &Document, selection: &Path) -> Option<Path> {
    let item = document.item(selection)?;
    match item.kind {
        kind if kind.is_solid() || kind == ItemKind::Point => Some(selection.clone()),
        ItemKind::Object if item.children.len() == 1 => Some(item.children[0].path.clone()),
        _ => None,
    }
}

/// Keys of a light that stands somewhere.
const LIGHT_AT: &str = "at";

#[derive(Default)]
pub(super) struct Handle {
    gizmo: Gizmo,
    /// The handles are held.
    pub(super) dragging: bool,
}

/// The pointer over the picture.
#[derive(Clone, Copy)]
pub(super) struct Pointer {
    pub(super) position: Pos2,
    pub(super) hovered: bool,
    pub(super) pressed: bool,
    pub(super) down: bool,
}

impl Handle {
    /// Draws the handles of what is selected into the picture; what they change of the document is in the values that
    /// come back. Says whether the pointer belongs to them.
    #[allow(clippy::too_many_arguments, reason = "each is another thing, and there is one caller")]
    pub(super) fn show(
        &mut self,
        ui: &egui::Ui,
        picture: Rect,
        camera: &Camera,
        document: &Document,
        selection: &Path,
        kind: Handles,
        pointer: Option<Pointer>,
    ) -> (bool, Vec<(Path, &'static str, Value)>) {
        let Some(path) = handled(document, selection) else {
            self.dragging = false;
            return (false, Vec::new());
        };
        let is_light = document.item(&path).is_some_and(|item| item.kind == ItemKind::Point);
        let outer = placement_around(document, &path);
        let mut own = own_placement(document, &path);
        if is_light && let Some(Value::Triple(at)) = given(document, &path, LIGHT_AT) {
            own.at = at.map(f64::from).into();
        }
        let world = outer.around(own);
        let modes = match kind {
            _ if is_light => GizmoMode::all_translate(),
            Handles::Move => GizmoMode::all_translate(),
            Handles::Turn => GizmoMode::all_rotate(),
            Handles::Scale => EnumSet::only(GizmoMode::ScaleUniform),
        };
        self.gizmo.update_config(configuration(ui, picture, camera, modes));
        let target = Transform::from_scale_rotation_translation(
            transform_gizmo::math::DVec3::splat(world.scale),
            transform_gizmo::math::DQuat::from_array(world.turn.to_array()),
            transform_gizmo::math::DVec3::from_array(world.at.to_array()),
        );
        let interaction = pointer.map_or_else(GizmoInteraction::default, |pointer| GizmoInteraction {
            cursor_pos: (pointer.position.x, pointer.position.y),
            hovered: pointer.hovered,
            drag_started: pointer.pressed && pointer.hovered,
            dragging: pointer.down,
        });
        let mut changes = Vec::new();
        let moved = self.gizmo.update(interaction, &[target]);
        self.dragging = moved.is_some();
        if let Some(new) = moved.and_then(|(_, transforms)| transforms.first().copied()) {
            let new = Placed {
                scale: new.scale.x.max(1e-4),
                turn: DQuat::from_xyzw(new.rotation.v.x, new.rotation.v.y, new.rotation.v.z, new.rotation.s),
                at: DVec3::new(new.translation.x, new.translation.y, new.translation.z),
            };
            let new = outer.inside(new);
            let step = 1e-4 * world.scale.max(1e-3);
            let at = Value::Triple(new.at.to_array().map(|v| tidy(v, step.min(1e-3))));
            match kind {
                _ if is_light => changes.push((path, LIGHT_AT, at)),
                Handles::Move => changes.push((path, key::AT, at)),
                Handles::Turn => changes.push((path, key::ROTATE, Value::Triple(new.degrees()))),
                Handles::Scale => changes.push((path, key::SCALE, Value::Number(tidy(new.scale, 1e-4).max(1e-4)))),
            }
        }
        draw(ui, picture, &self.gizmo);
        (self.dragging || self.gizmo.is_focused(), changes)
    }
}

/// Depth 0 to 1 from a millimetre to infinity.
fn perspective(fov: f64, aspect: f64) -> DMat4 {
    const NEAR: f64 = 1e-3;
    let y = 1.0 / (0.5 * fov).tan();
    DMat4::from_cols_array(&[y / aspect, 0.0, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, 0.0, -1.0, -1.0, 0.0, 0.0, -NEAR, 0.0])
}

fn configuration(ui: &egui::Ui, picture: Rect, camera: &Camera, modes: EnumSet<GizmoMode>) -> GizmoConfig {
    let axes = axes(camera);
    let [right, up, back] = [axes.right, axes.up, -axes.forward].map(|axis| axis.as_dvec3());
    let position = DVec3::from_array(camera.position.map(f64::from));
    let world_from_view = DMat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), position.extend(1.0));
    let aspect = f64::from(picture.width() / picture.height().max(1.0));
    let projection = perspective(f64::from(camera.fov).to_radians(), aspect);
    let matrix = |matrix: DMat4| transform_gizmo::math::DMat4::from_cols_array(&matrix.to_cols_array());
    let [min, max] = [picture.min, picture.max].map(|p| transform_gizmo::math::Pos2::new(p.x, p.y));
    GizmoConfig {
        view_matrix: matrix(world_from_view.inverse()).into(),
        projection_matrix: matrix(projection).into(),
        viewport: transform_gizmo::math::Rect::from_min_max(min, max),
        modes,
        orientation: GizmoOrientation::Global,
        snapping: ui.input(|input| input.modifiers.command),
        visuals: GizmoVisuals { gizmo_size: 75.0, stroke_width: 4.0, ..GizmoVisuals::default() },
        pixels_per_point: ui.ctx().pixels_per_point(),
        ..GizmoConfig::default()
    }
}

fn draw(ui: &egui::Ui, picture: Rect, gizmo: &Gizmo) {
    let drawn = gizmo.draw();
    let vertex = |(position, colour): (&[f32; 2], &[f32; 4])| egui::epaint::Vertex {
        pos: Pos2::from(*position),
        uv: egui::epaint::WHITE_UV,
        color: Color32::from(egui::Rgba::from_rgba_premultiplied(colour[0], colour[1], colour[2], colour[3])),
    };
    let vertices = drawn.vertices.iter().zip(&drawn.colors).map(vertex).collect();
    let mesh = egui::Mesh { indices: drawn.indices, vertices, ..egui::Mesh::default() };
    ui.painter_at(picture).add(mesh);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_through_an_operator_comes_back() {
        let outer = Placed {
            scale: 2.0,
            turn: DQuat::from_euler(EulerRot::ZYX, 0.3, -0.7, 1.1),
            at: DVec3::new(1.0, 2.0, 3.0),
        };
        let inner = Placed {
            scale: 0.5,
            turn: DQuat::from_euler(EulerRot::ZYX, -1.3, 0.2, 0.4),
            at: DVec3::new(-4.0, 0.0, 1.0),
        };
        let back = outer.inside(outer.around(inner));
        assert!(back.at.distance(inner.at) < 1e-12 && (back.scale - inner.scale).abs() < 1e-12);
        assert!(back.turn.dot(inner.turn).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn degrees_turn_about_fixed_axes() {
        let [x, y, z] = [20.0_f64, -35.0, 70.0].map(f64::to_radians);
        let turn = DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x);
        assert_eq!(Placed { turn, ..Placed::NOWHERE }.degrees(), [20.0, -35.0, 70.0]);
        assert_eq!(tidy(-1e-9, 1e-3).to_bits(), 0.0_f32.to_bits());
    }

    #[test]
    fn handles_are_where_the_field_is() {
        let text = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nobject \"a\" {\n union {\n  at 1 2 3\n  \
                    rotate 10 20 30\n  scale 2\n  sphere 1 { at 0.5 0 0; rotate 0 90 0 }\n box 1 } }\n\
                    point { at 4 5 6; intensity 1 }";
        let document = Document::new("test.kdl", text);
        let scene = document.scene().expect("a scene");
        let path = document.path_of_leaf(0).expect("the sphere");
        let world = placement_around(&document, &path).around(own_placement(&document, &path));
        let leaf = &scene.field.leaves()[0];
        assert!(world.at.as_vec3().distance(leaf.pose.at.into()) < 1e-5, "{world:?} {leaf:?}");
        assert!((world.scale as f32 - leaf.pose.scale).abs() < 1e-6);
        for (axis, expected) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(leaf.pose.axes) {
            assert!((world.turn * axis).as_vec3().distance(expected.into()) < 1e-5);
        }
    }
}
