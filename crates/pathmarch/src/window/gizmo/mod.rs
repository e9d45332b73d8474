//! Gizmo: handles in the viewport that move, rotate and scale the selected node.
//!
//! **Idea.** Handles have a constant size on screen and are drawn by egui. A drag intersects the ray through the
//! pointer with the axis or plane of the handle in world space ([`drag`]). Transforms in the scene language are
//! relative to the parent operators, so the result is multiplied by their inverse ([`transform`]).
//!
//! **Where we differ.** Axes are always those of world space. Angles accumulate over several turns of a ring. A ring
//! seen nearly edge-on rotates by the distance that the pointer moves along it.

mod drag;
mod draw;
mod shape;
mod sun;
#[cfg(test)]
mod tests;
mod transform;

use crate::window::open_scene::view_state::GizmoMode;
use crate::window::projection::Projection;
use drag::Drag;
use egui::{Pos2, Rect, Vec2};
use glam::{DQuat, DVec3};
use pathmarch_render::pathmarch_scene::Camera;
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value, key};
use shape::{Gizmo, Handle};
use sun::{SkyMap, Sun};
use transform::{Transform, local_transform, parent_transform, present_value, round_to};

/// Node that the gizmo changes: a shape, an operator, a point or a spot light; for an object, its only shape.
pub(crate) fn target_node(document: &Document, selection: &Path) -> Option<Path> {
    let item = document.item(selection)?;
    match item.kind {
        kind if kind.is_solid() || matches!(kind, ItemKind::Point | ItemKind::Spot) => Some(selection.clone()),
        ItemKind::Object if item.children.len() == 1 => Some(item.children[0].path.clone()),
        _ => None,
    }
}

/// Position of a node relative to its parent, after a movement in world space by `by` metres.
pub(crate) fn moved_by(document: &Document, path: &Path, by: [f64; 3]) -> [f32; 3] {
    let outer = parent_transform(document, path);
    let mut world = outer.then_local(local_transform(document, path));
    world.translation += DVec3::from_array(by);
    outer.to_local(world).translation.to_array().map(|v| round_to(v, 1e-4))
}

/// Light that the gizmo changes.
#[derive(Clone, Copy)]
enum LightHandles {
    /// Point light, which can be moved.
    Point,
    /// Spot light, which can be turned, too, and whose cone can be scaled.
    Spot(SpotCone),
}

/// Cone of a spot light.
#[derive(Clone, Copy)]
struct SpotCone {
    /// Unit vector along the axis.
    direction: DVec3,
    /// Distance of the target, metres.
    distance: f64,
    /// Full angle, degrees.
    angle: f64,
}

impl LightHandles {
    /// The light of a node, and its transform: a spot shines along -y, and its scale is the angle of its cone. `None` for other
    /// nodes.
    fn of(document: &Document, path: &Path) -> Option<(Self, Transform)> {
        let triple = |key: &str| match present_value(document, path, key) {
            Some(Value::Triple(value)) => Some(DVec3::from_array(value.map(f64::from))),
            _ => None,
        };
        let at = Transform { translation: triple(LIGHT_AT)?, ..Transform::IDENTITY };
        match document.item(path)?.kind {
            ItemKind::Point => Some((Self::Point, at)),
            ItemKind::Spot => {
                let axis = triple(LIGHT_TARGET)? - at.translation;
                let Some(Value::Number(angle)) = present_value(document, path, LIGHT_CONE) else { return None };
                let direction = axis.try_normalize().unwrap_or(DVec3::NEG_Y);
                let cone = SpotCone { direction, distance: axis.length().max(1e-6), angle: f64::from(angle) };
                let rotation = DQuat::from_rotation_arc(DVec3::NEG_Y, direction);
                Some((Self::Spot(cone), Transform { rotation, scale: cone.angle, ..at }))
            }
            _ => None,
        }
    }

    /// Mode of the gizmo for this light.
    fn mode(self, mode: GizmoMode) -> GizmoMode {
        match self {
            Self::Point => GizmoMode::Move,
            Self::Spot(_) => mode,
        }
    }

    /// Property value that gives the light its new transform.
    fn change(self, path: Path, mode: GizmoMode, new: Transform) -> (Path, &'static str, Value) {
        let triple = |v: DVec3| Value::Triple(v.to_array().map(|v| round_to(v, 1e-3)));
        match (self, mode) {
            (Self::Spot(cone), GizmoMode::Rotate) => {
                let target = new.translation + new.rotation * (DVec3::NEG_Y * cone.distance);
                (path, LIGHT_TARGET, triple(target))
            }
            (Self::Spot(_), GizmoMode::Scale) => {
                (path, LIGHT_CONE, Value::Number(round_to(new.scale.clamp(0.1, 180.0), 0.1)))
            }
            _ => (path, LIGHT_AT, triple(new.translation)),
        }
    }
}

/// Property key of a light's position.
const LIGHT_AT: &str = "at";
/// Property key of the point that a spot light shines at.
const LIGHT_TARGET: &str = "target";
/// Property key of the angle of a spot light.
const LIGHT_CONE: &str = "cone";

/// State of the gizmo between frames.
#[derive(Default)]
pub(crate) struct GizmoState {
    /// Node and drag in progress.
    held: Option<(Path, Drag)>,
    /// Sun that is dragged, and its place relative to the pointer.
    held_sun: Option<(Path, Vec2)>,
}

/// The pointer over the viewport.
#[derive(Clone, Copy)]
pub(crate) struct Pointer {
    pub(crate) position: Pos2,
    /// The pointer may grab a handle.
    pub(crate) hovered: bool,
    /// Position of the press, in the frame in which the primary button is pressed.
    pub(crate) pressed_at: Option<Pos2>,
    /// The primary button is down.
    pub(crate) down: bool,
}

impl GizmoState {
    /// Draws the gizmo of the selected node. Returns true if it uses the pointer, and the changed properties.
    #[allow(clippy::too_many_arguments, reason = "each is another thing, and there is one caller")]
    pub(crate) fn show(
        &mut self,
        ui: &egui::Ui,
        picture: Rect,
        camera: &Camera,
        document: &Document,
        selection: &Path,
        kind: GizmoMode,
        pointer: Option<Pointer>,
    ) -> (bool, Vec<(Path, &'static str, Value)>) {
        if let Some(sun) = Sun::of(document, selection) {
            self.held = None;
            let map = SkyMap::new(&Projection::new(camera, picture), picture);
            return self.show_sun(ui, picture, &map, sun, selection, pointer);
        }
        self.held_sun = None;
        let Some(path) = target_node(document, selection) else {
            self.held = None;
            return (false, Vec::new());
        };
        let light = LightHandles::of(document, &path);
        let kind = light.map_or(kind, |(light, _)| light.mode(kind));
        let outer = parent_transform(document, &path);
        let own = light.map_or_else(|| local_transform(document, &path), |(_, transform)| transform);
        let world = outer.then_local(own);
        let projection = Projection::new(camera, picture);
        let (handles, gizmo) = (Handle::of(kind), Gizmo::new(projection, world.translation));
        let snapping = ui.input(|input| input.modifiers.command);

        let hovered = self.follow(handles, gizmo.as_ref(), &path, world, pointer);
        let moved = match (&mut self.held, pointer) {
            (Some((_, drag)), Some(pointer)) => drag.to(&projection, pointer.position, snapping),
            _ => None,
        };
        let changes = moved.map(|new| match light {
            Some((light, _)) => light.change(path, kind, new),
            None => change(path, kind, outer, world, new),
        });
        let drag = self.held.as_ref().map(|(_, drag)| drag);
        if let Some((LightHandles::Spot(SpotCone { direction, distance, angle }), _)) = light {
            draw::draw_cone(&ui.painter_at(picture), &projection, world.translation, direction * distance, angle);
        }
        if let Some(gizmo) = &gizmo {
            draw::draw(&ui.painter_at(picture), gizmo, handles, hovered, drag);
        }
        (drag.is_some() || hovered.is_some(), changes.into_iter().collect())
    }

    /// Draws the handle of a sun, which is dragged on a map of all directions.
    fn show_sun(
        &mut self,
        ui: &egui::Ui,
        picture: Rect,
        map: &SkyMap,
        sun: Sun,
        path: &Path,
        pointer: Option<Pointer>,
    ) -> (bool, Vec<(Path, &'static str, Value)>) {
        self.held_sun =
            self.held_sun.take().filter(|(of, _)| of == path && pointer.is_some_and(|pointer| pointer.down));
        let at = pointer.map(|pointer| pointer.pressed_at.unwrap_or(pointer.position));
        let hovered =
            pointer.is_some_and(|pointer| pointer.hovered) && at.is_some_and(|at| map.is_on(sun.direction, at));
        if let Some(pressed) = pointer.and_then(|pointer| pointer.pressed_at).filter(|_| hovered) {
            self.held_sun = Some((path.clone(), map.place(sun.direction) - pressed));
        }
        let snapping = ui.input(|input| input.modifiers.command);
        let mut direction = sun.direction;
        let mut changes = Vec::new();
        if let (Some((_, offset)), Some(pointer)) = (&self.held_sun, pointer) {
            let moved = map.direction(pointer.position + *offset, snapping);
            if map.place(moved).distance(map.place(sun.direction)) > 0.5 {
                direction = moved;
                changes = sun.changes(path, moved);
            }
        }
        map.draw(&ui.painter_at(picture), direction, hovered || self.held_sun.is_some());
        (hovered || self.held_sun.is_some(), changes)
    }

    /// Begins and ends drags; returns the handle under the pointer.
    fn follow(
        &mut self,
        handles: &[Handle],
        gizmo: Option<&Gizmo>,
        path: &Path,
        world: Transform,
        pointer: Option<Pointer>,
    ) -> Option<Handle> {
        let Some(pointer) = pointer else {
            self.held = None;
            return None;
        };
        // Selection and gizmo mode may change during a drag.
        let goes_on = |(of, drag): &(Path, Drag)| pointer.down && of == path && handles.contains(&drag.handle);
        self.held = self.held.take().filter(goes_on);
        let gizmo = gizmo.filter(|_| self.held.is_none() && pointer.hovered)?;
        let at = pointer.pressed_at.unwrap_or(pointer.position);
        let handle = gizmo.pick(handles, at)?;
        if pointer.pressed_at.is_some() && pointer.down {
            self.held = Drag::begin(gizmo, handle, world, at).map(|drag| (path.clone(), drag));
        }
        Some(handle)
    }
}

/// Property value that gives a node its new world transform.
fn change(
    path: Path,
    kind: GizmoMode,
    outer: Transform,
    world: Transform,
    new: Transform,
) -> (Path, &'static str, Value) {
    let inner = outer.to_local(new);
    match kind {
        GizmoMode::Move => {
            let step = 1e-4 * world.scale.max(1e-3);
            let DVec3 { x, y, z } = inner.translation;
            let at = Value::Triple([x, y, z].map(|v| round_to(v, step.min(1e-3))));
            (path, key::AT, at)
        }
        GizmoMode::Rotate => (path, key::ROTATE, Value::Triple(inner.degrees())),
        GizmoMode::Scale => (path, key::SCALE, Value::Number(round_to(inner.scale, 1e-4).max(1e-4))),
    }
}
