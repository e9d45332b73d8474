//! Gizmo: handles in the viewport that move, rotate and scale the selected node.
//!
//! **Idea.** Handles have a constant size on screen and are drawn by egui. A drag intersects the ray through the
//! pointer with the axis or plane of the handle in world space ([`drag`]). Transforms in the scene language are
//! relative to the parent operators, so the result is multiplied by their inverse ([`transform`]). Control points, sizes
//! and the cone of a spot light are dots at their places ([`dots`]).
//!
//! **Where we differ.** Axes are always those of world space. Angles accumulate over several turns of a ring. A ring
//! seen nearly edge-on rotates by the distance that the pointer moves along it.

mod dots;
mod drag;
mod draw;
mod lights;
mod profile;
mod shape;
mod sizes;
mod sun;
#[cfg(test)]
mod tests;
mod transform;

use crate::window::open_scene::view_state::GizmoMode;
use crate::window::projection::Projection;
use crate::window::surface_snap::SurfacePoint;
use dots::{Dot, DotDrag, DotId};
use drag::Drag;
use egui::{Pos2, Rect, Vec2};
use glam::DVec3;
use lights::{LightHandles, SpotCone};
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value, key};
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use profile::Profile;
use shape::{Gizmo, Handle};
use sizes::Sizes;
use std::borrow::Cow;
use sun::{SkyMap, Sun};
use transform::{Transform, local_transform, parent_transform, round_to};

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

/// Origin of a node in world space, metres.
pub(crate) fn world_origin(document: &Document, path: &Path) -> DVec3 {
    parent_transform(document, path).then_local(local_transform(document, path)).translation
}

/// A change of the scene by the gizmo.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum GizmoChange {
    /// Sets a property of a node.
    Property(Path, Cow<'static, str>, Value),
    /// Moves a control point of a profile.
    MovePoint(Path, usize, [f32; 2]),
    /// Adds a control point, which then has this index.
    AddPoint(Path, usize, [f32; 2]),
}

/// What the gizmo is shown for.
#[derive(Clone, Copy)]
pub(crate) struct GizmoScene<'s> {
    pub(crate) document: &'s Document,
    pub(crate) scene: &'s Scene,
    pub(crate) camera: &'s Camera,
    pub(crate) selection: &'s Path,
    pub(crate) mode: GizmoMode,
    /// The surface at a point of the window, while things are snapped to surfaces.
    pub(crate) surface: Option<&'s dyn Fn(Pos2) -> Option<SurfacePoint>>,
}

/// State of the gizmo between frames.
#[derive(Default)]
pub(crate) struct GizmoState {
    /// Node and drag in progress.
    held: Option<(Path, Drag)>,
    /// Sun that is dragged, and its place relative to the pointer.
    held_sun: Option<(Path, Vec2)>,
    /// Dot that is dragged.
    held_dot: Option<DotDrag>,
    /// Places of the dots that are shown, in the window, for tests.
    #[cfg(test)]
    pub(crate) dot_places: Vec<Pos2>,
    /// Control point under the pointer.
    pub(crate) hovered_point: Option<(Path, usize)>,
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
    /// Node that is dragged onto surfaces by its centre, or whose target is.
    pub(crate) fn dragged_freely(&self) -> Option<&Path> {
        let moved = self.held.as_ref().filter(|(_, drag)| drag.handle == Handle::Disc).map(|(path, _)| path);
        moved.or_else(|| self.held_dot.as_ref().filter(|drag| drag.dot.id == DotId::Target).map(|drag| &drag.path))
    }

    /// Draws the gizmo of the selected node. Returns true if it uses the pointer, and the changes.
    pub(crate) fn show(
        &mut self,
        ui: &egui::Ui,
        picture: Rect,
        of: GizmoScene,
        pointer: Option<Pointer>,
    ) -> (bool, Vec<GizmoChange>) {
        let GizmoScene { document, selection, .. } = of;
        let projection = Projection::new(of.camera, picture);
        self.hovered_point = None;
        #[cfg(test)]
        self.dot_places.clear();
        if let Some(sun) = Sun::of(document, selection) {
            (self.held, self.held_dot) = (None, None);
            let map = SkyMap::new(&projection, picture);
            let (taken, changes) = self.show_sun(ui, picture, &map, sun, selection, pointer);
            let change = |(path, key, value)| GizmoChange::Property(path, Cow::Borrowed(key), value);
            return (taken, changes.into_iter().map(change).collect());
        }
        self.held_sun = None;
        let Some(path) = target_node(document, selection) else {
            (self.held, self.held_dot) = (None, None);
            return (false, Vec::new());
        };
        let light = LightHandles::of(document, &path);
        let mode = light.map_or(of.mode, |(light, _)| light.mode(of.mode));
        let outer = parent_transform(document, &path);
        let own = light.map_or_else(|| local_transform(document, &path), |(_, transform)| transform);
        let world = outer.then_local(own);
        let (handles, gizmo) = (Handle::of(mode), Gizmo::new(projection, world.translation));
        let snapping = ui.input(|input| input.modifiers.command);
        let painter = ui.painter_at(picture);
        if let Some((LightHandles::Spot(cone), _)) = light {
            let radii = [cone.outer_radius(), cone.inner_radius()];
            draw::draw_cone(&painter, &projection, world.translation, cone.direction * cone.distance, radii);
        }

        let owner = DotOwner::of(of, &projection, &path, light);
        // A handle that is held keeps the pointer.
        let free = pointer.filter(|_| self.held.is_none());
        let (dots_taken, mut changes) = self.show_dots(&painter, owner.as_ref(), of, &projection, free, snapping);
        let pointer = pointer.map(|pointer| Pointer { hovered: pointer.hovered && !dots_taken, ..pointer });
        let hovered = self.follow(handles, gizmo.as_ref(), &path, world, pointer);
        if let (Some((_, drag)), Some(pointer)) = (&mut self.held, pointer)
            && let Some(mut new) = drag.to(&projection, pointer.position, snapping)
        {
            if let (Some(surface), Handle::Disc, None) = (of.surface, drag.handle, light)
                && let Some(point) = surface(pointer.position)
            {
                new.translation = point.touching;
            }
            changes.push(match light {
                Some((light, _)) => {
                    let (key, value) = light.change(mode, new);
                    GizmoChange::Property(path, Cow::Borrowed(key), value)
                }
                None => change(path, mode, outer, world, new),
            });
        }
        let drag = self.held.as_ref().map(|(_, drag)| drag);
        if let Some(gizmo) = &gizmo {
            draw::draw(&painter, gizmo, handles, hovered, drag);
        }
        if let Some(owner) = &owner {
            let marked = self.held_dot.as_ref().map(|drag| drag.dot.id);
            let under = self.hovered_point.as_ref().map(|(_, index)| DotId::ControlPoint(*index));
            dots::draw(&painter, &owner.dots, &projection, marked.or(under));
            #[cfg(test)]
            self.dot_places.extend(owner.dots.iter().filter_map(|dot| projection.project(dot.at)));
        }
        (drag.is_some() || hovered.is_some() || dots_taken, changes)
    }

    /// Follows the pointer over the dots of a node, and draws its outline. Returns true if they use the pointer, and the
    /// changes.
    fn show_dots(
        &mut self,
        painter: &egui::Painter,
        owner: Option<&DotOwner>,
        of: GizmoScene,
        projection: &Projection,
        pointer: Option<Pointer>,
        snapping: bool,
    ) -> (bool, Vec<GizmoChange>) {
        let (Some(owner), Some(pointer)) = (owner, pointer) else {
            self.held_dot = None;
            if let Some(DotOwner { kind: DotKind::Profile(profile), .. }) = owner {
                profile.draw(painter, projection);
            }
            return (false, Vec::new());
        };
        let goes_on = |drag: &DotDrag| {
            pointer.down
                && drag.path == owner.path
                && drag.count == owner.dots.len()
                && owner.dots.iter().any(|dot| dot.id == drag.dot.id)
        };
        self.held_dot = self.held_dot.take().filter(goes_on);
        let at = pointer.pressed_at.unwrap_or(pointer.position);
        let pressed = pointer.pressed_at.is_some() && pointer.down;
        let free = pointer.hovered && self.held_dot.is_none();
        let hovered = dots::pick(&owner.dots, projection, at).filter(|_| free);
        let begin = |count: usize, dot: Dot| DotDrag::begin(owner.path.clone(), count, dot, projection, at);
        let mut changes = Vec::new();
        let mut taken = hovered.is_some();
        if let (Some(dot), true) = (hovered, pressed) {
            self.held_dot = begin(owner.dots.len(), dot);
        }
        if let Some(DotId::ControlPoint(index)) = hovered.map(|dot| dot.id) {
            self.hovered_point = Some((owner.path.clone(), index));
        }
        if let DotKind::Profile(profile) = &owner.kind {
            profile.draw(painter, projection);
            let on_handle = hovered.is_some() || !free;
            if let Some((index, place, shown)) = profile.on_outline(projection, at).filter(|_| !on_handle) {
                taken = true;
                dots::draw_plus(painter, shown);
                if pressed {
                    let dot = profile.dot(index, place);
                    let place = profile.coordinates(dot.at, projection, false);
                    changes.push(GizmoChange::AddPoint(owner.path.clone(), index, place));
                    self.held_dot = begin(owner.dots.len() + 1, profile.dot(index, place));
                    return (true, changes);
                }
            }
        }
        if let Some(drag) = &mut self.held_dot
            && let Some(mut to) = drag.to(projection, pointer.position)
        {
            if let (Some(surface), DotId::Target) = (of.surface, drag.dot.id)
                && let Some(point) = surface(pointer.position)
            {
                to = point.position;
            }
            changes.extend(owner.change(drag.dot.id, to, projection, snapping));
        }
        (taken || self.held_dot.is_some(), changes)
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
fn change(path: Path, kind: GizmoMode, outer: Transform, world: Transform, new: Transform) -> GizmoChange {
    let inner = outer.to_local(new);
    let (key, value) = match kind {
        GizmoMode::Move => {
            let step = 1e-4 * world.scale.max(1e-3);
            let DVec3 { x, y, z } = inner.translation;
            (key::AT, Value::Triple([x, y, z].map(|v| round_to(v, step.min(1e-3)))))
        }
        GizmoMode::Rotate => (key::ROTATE, Value::Triple(inner.degrees())),
        GizmoMode::Scale => (key::SCALE, Value::Number(round_to(inner.scale, 1e-4).max(1e-4))),
    };
    GizmoChange::Property(path, Cow::Borrowed(key), value)
}

/// A node with dots.
struct DotOwner {
    path: Path,
    dots: Vec<Dot>,
    kind: DotKind,
}

/// Kind of a node with dots.
enum DotKind {
    Profile(Profile),
    Sizes(Sizes),
    Spot(SpotCone),
}

impl DotOwner {
    /// The node with dots for a selected one: a profile while it is moved, a shape while it is scaled, or a spot light.
    fn of(
        of: GizmoScene,
        projection: &Projection,
        target: &Path,
        light: Option<(LightHandles, Transform)>,
    ) -> Option<Self> {
        if let Some((light, _)) = light {
            let LightHandles::Spot(cone) = light else { return None };
            return Some(Self {
                path: target.clone(),
                dots: cone.dots(projection).to_vec(),
                kind: DotKind::Spot(cone),
            });
        }
        match of.mode {
            GizmoMode::Move => {
                let profile = Profile::of(of.document, of.selection, projection.position)?;
                Some(Self { path: profile.path.clone(), dots: profile.dots(), kind: DotKind::Profile(profile) })
            }
            GizmoMode::Scale => {
                let sizes = Sizes::of(of.document, of.scene, target)?;
                Some(Self { path: target.clone(), dots: sizes.dots(), kind: DotKind::Sizes(sizes) })
            }
            GizmoMode::Rotate => None,
        }
    }

    /// The change that puts a dot at this point; `None` if it is there already.
    fn change(&self, id: DotId, at: DVec3, projection: &Projection, snapping: bool) -> Option<GizmoChange> {
        let path = self.path.clone();
        match (&self.kind, id) {
            (DotKind::Profile(profile), DotId::ControlPoint(index)) => {
                let place = profile.coordinates(at, projection, snapping);
                let is_new = profile.point(index).is_some_and(|point| point.at != place);
                is_new.then_some(GizmoChange::MovePoint(path, index, place))
            }
            (DotKind::Sizes(sizes), DotId::Size(index)) => {
                let (key, value) = sizes.change(index, at, snapping)?;
                Some(GizmoChange::Property(path, key, value))
            }
            (DotKind::Spot(cone), id) => {
                let (key, value) = cone.change(id, at, projection, snapping);
                Some(GizmoChange::Property(path, Cow::Borrowed(key), value))
            }
            _ => None,
        }
    }
}
