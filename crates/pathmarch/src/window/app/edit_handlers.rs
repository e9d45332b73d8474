//! Handlers of actions that edit the selected nodes.

use super::App;
use super::actions::Action;
use crate::window::gizmo;
use egui::Context;
use pathmarch_render::pathmarch_field::Aabb;
use pathmarch_render::pathmarch_scene::document::{Control, Item, ItemKind, Path, Value, key};

/// Duration of a turn of a turntable, seconds.
const TURN_SECONDS: f32 = 10.0;

/// Property of hidden objects and lights.
const HIDDEN: &str = pathmarch_render::pathmarch_scene::settings::VISIBILITY[0].name;

/// Formulas of a camera position on a circle around the vertical axis through the target; at t = 0 it is `position`.
fn orbit(position: [f32; 3], target: [f32; 3]) -> Vec<String> {
    let (x, z) = (position[0] - target[0], position[2] - target[2]);
    let (radius, start) = (x.hypot(z), z.atan2(x).to_degrees());
    let angle = format!("radians({start:.2} + {}*t)", 360.0 / TURN_SECONDS);
    let along = |middle: f32, function: &str| format!("{middle:.3} + {radius:.3}*{function}({angle})");
    vec![along(target[0], "cos"), format!("{:.3}", position[1]), along(target[2], "sin")]
}

impl App {
    /// Runs an action of the menu Edit; leaves others to the view.
    pub(super) fn run_edit_action(&mut self, ctx: &Context, action: Action) {
        match action {
            Action::Duplicate => self.duplicate(),
            Action::Delete => self.delete(),
            Action::Group => self.group_into("union"),
            Action::Ungroup => self.ungroup(),
            Action::Unite => self.combine("union"),
            Action::Subtract => self.combine("subtract"),
            Action::Intersect => self.combine("intersect"),
            Action::ToGround => self.put_on_ground(),
            Action::SnapToSurfaces => {
                self.snap_to_surfaces = !self.snap_to_surfaces;
                self.show_message(match self.snap_to_surfaces {
                    true => "Snap to surfaces: drag a shape by the disc in its middle.",
                    false => "Snap to surfaces is off.",
                });
            }
            Action::Turntable => self.turntable(),
            Action::SetKey => self.set_key(),
            Action::Mirror => self.group_into("mirror"),
            Action::AlignX => self.align(0),
            Action::AlignY => self.align(1),
            Action::AlignZ => self.align(2),
            Action::Hide => self.hide(),
            Action::HideOthers => self.hide_others(),
            Action::ShowAll => self.set_hidden(self.hideable(|item| item.hidden), false),
            Action::Lock => self.lock(),
            _ => self.run_view_action(ctx, action),
        }
    }

    /// Selected nodes in the order of selection, without those inside other selected ones.
    fn selected_paths(&self) -> Vec<Path> {
        let all = self.open.as_ref().map_or(&[][..], |open| open.view.selection.paths());
        let inside = |path: &&Path| all.iter().any(|other| other != *path && path.is_within(other));
        all.iter().filter(|path| !inside(path)).cloned().collect()
    }

    /// Selected nodes from the end of the file to its start: an edit of one leaves the paths of the next ones alone.
    fn last_first(&self) -> Vec<Path> {
        let mut paths = self.selected_paths();
        paths.sort();
        paths.reverse();
        paths
    }

    /// Selects nodes alone.
    pub(crate) fn select_all(&mut self, paths: Vec<Path>) {
        if let Some(open) = &mut self.open {
            open.view.selection.set(&open.document, paths);
        }
    }

    fn duplicate(&mut self) {
        let mut copies: Vec<Path> = Vec::new();
        for path in self.last_first() {
            let Some(copy) = self.edit(|open| open.document.duplicate(&path)) else { break };
            copies = copies.iter().map(|other| other.after_insertion(&copy)).collect();
            copies.push(copy);
        }
        if !copies.is_empty() {
            self.select_all(copies);
        }
    }

    fn delete(&mut self) {
        for path in self.last_first() {
            if self.edit(|open| open.document.remove(&path)).is_none() {
                return;
            }
        }
        self.select_all(Vec::new());
    }

    /// Puts the selected shapes into an operator.
    pub(crate) fn group_into(&mut self, operator: &str) {
        let paths = self.selected_paths();
        if !paths.is_empty() {
            let group = self.edit(|open| open.document.group(&paths, operator));
            self.select(group);
        }
    }

    fn ungroup(&mut self) {
        let Some(path) = self.selected_paths().pop() else { return };
        if let Some(freed) = self.edit(|open| open.document.ungroup(&path)) {
            self.select_all(freed);
        }
    }

    /// Combines the selected shapes and objects.
    pub(crate) fn combine(&mut self, operator: &str) {
        let paths = self.selected_paths();
        let combined = self.edit(|open| open.document.combine(&paths, operator));
        self.select(combined);
    }

    /// Lets the camera circle its target, by formulas of the time; the playback ends after one turn.
    fn turntable(&mut self) {
        self.write_camera();
        let Some(open) = &self.open else { return };
        let (camera, name) = (open.view.camera.clone(), open.view.camera_name().to_owned());
        let is_it = |item: &&Item| item.kind == ItemKind::Camera && item.title() == name;
        let Some(path) = open.document.outline().iter().find(is_it).map(|item| item.path.clone()) else { return };
        let position = Value::Formulas(orbit(camera.position, camera.target));
        if self.edit(|open| open.document.set(&path, "position", position, None)).is_some()
            && let Some(open) = &mut self.open
        {
            let fps = open.document.last_good().map_or(24.0, |scene| scene.render.fps);
            open.playback.last = (TURN_SECONDS * fps).round().max(2.0) as u32 - 1;
            self.show_message(
                "The camera goes around its target in 10 s. Space plays; File, Render writes the frames.",
            );
        }
    }

    /// Moves each selected node along the y axis until the bounds of its shapes touch the height 0.
    fn put_on_ground(&mut self) {
        self.undo_group += 1;
        let undo_group = self.undo_group;
        for path in self.selected_paths() {
            let Some((target, at)) = self.place_on_ground(&path) else {
                self.show_error("Only shapes of finite size can be put on the ground.");
                return;
            };
            self.edit(|open| open.document.set(&target, key::AT, Value::Triple(at), Some(undo_group)));
        }
    }

    /// Sets keys of the selected nodes at the present frame: of position, and of rotation and scale where they are given;
    /// of a camera's position and target.
    fn set_key(&mut self) {
        self.undo_group += 1;
        let undo_group = self.undo_group;
        for path in self.selected_paths() {
            let Some(open) = &self.open else { return };
            let document = &open.document;
            let is_camera = document.item(&path).is_some_and(|item| item.kind == ItemKind::Camera);
            let Some(target) = gizmo::target_node(document, &path).or(is_camera.then_some(path)) else {
                self.show_message(
                    "Only shapes, lights and cameras have a position to key. For other numbers, right click their label and choose Set a key.",
                );
                return;
            };
            let is_keyed = |control: &Control| {
                let key = &*control.key;
                matches!(key, key::AT | "at" | "position" | "target")
                    || control.given && matches!(key, key::ROTATE | key::SCALE)
            };
            let keys: Vec<String> = document
                .controls(&target)
                .iter()
                .filter(|control| is_keyed(control))
                .map(|control| control.key.to_string())
                .collect();
            for key in keys {
                if self.edit(|open| open.document.set_key(&target, &key, Some(undo_group))).is_none() {
                    return;
                }
            }
        }
    }

    /// The node to move, and its new position relative to its parent.
    fn place_on_ground(&self, path: &Path) -> Option<(Path, [f32; 3])> {
        let (target, bounds) = self.target_with_bounds(path)?;
        let document = &self.open.as_ref()?.document;
        let height = f64::from(bounds.min[1]);
        height.is_finite().then(|| gizmo::moved_by(document, &target, [0.0, -height, 0.0])).map(|at| (target, at))
    }

    /// The node that the gizmo moves for a selected one, and the bounds of its shapes.
    fn target_with_bounds(&self, path: &Path) -> Option<(Path, Aabb)> {
        let document = &self.open.as_ref()?.document;
        let scene = document.scene().ok()?;
        let target = gizmo::target_node(document, path)?;
        let leaves = document.leaves_of(&target).into_iter();
        let bounds = leaves.map(|leaf| scene.field.declared_bounds(leaf)).reduce(|all, bounds| all.union(bounds))?;
        Some((target, bounds))
    }

    /// Moves the selected nodes along an axis until their centres are at that of the active one.
    fn align(&mut self, axis: usize) {
        self.undo_group += 1;
        let undo_group = self.undo_group;
        let centre = |bounds: &Aabb| 0.5 * (f64::from(bounds.min[axis]) + f64::from(bounds.max[axis]));
        let paths = self.selected_paths();
        let (Some(last), true) = (paths.last(), paths.len() > 1) else {
            return self.show_message("Select several shapes: Ctrl + click adds to the selection.");
        };
        let goal = self.target_with_bounds(last).map(|(_, bounds)| centre(&bounds)).filter(|goal| goal.is_finite());
        for path in &paths[..paths.len() - 1] {
            let target = self.target_with_bounds(path);
            let target = target.filter(|(_, bounds)| centre(bounds).is_finite());
            let (Some(goal), Some((target, bounds))) = (goal, target) else {
                return self.show_error("Only shapes of finite size can be aligned.");
            };
            let mut by = [0.0; 3];
            by[axis] = goal - centre(&bounds);
            let Some(open) = &self.open else { return };
            let at = gizmo::moved_by(&open.document, &target, by);
            self.edit(|open| open.document.set(&target, key::AT, Value::Triple(at), Some(undo_group)));
        }
    }

    /// Objects and lights of the scene that fulfil a condition.
    fn hideable(&self, is_one: impl Fn(&Item) -> bool) -> Vec<Path> {
        let items = self.open.as_ref().map_or(&[][..], |open| open.document.outline());
        let can_hide = |item: &&Item| item.kind.can_hide();
        items.iter().filter(can_hide).filter(|item| is_one(item)).map(|item| item.path.clone()).collect()
    }

    /// Hides or shows objects and lights in one undo step.
    pub(crate) fn set_hidden(&mut self, paths: Vec<Path>, hidden: bool) {
        self.undo_group += 1;
        let undo_group = self.undo_group;
        for path in paths {
            let value = Value::Flag(hidden);
            let done = if hidden {
                self.edit(|open| open.document.set(&path, HIDDEN, value, Some(undo_group)))
            } else {
                self.edit(|open| open.document.reset_in(&path, HIDDEN, Some(undo_group)))
            };
            if done.is_none() {
                return;
            }
        }
    }

    /// Hides the objects and lights of the selected nodes, or shows them if all of them are hidden.
    fn hide(&mut self) {
        let selected = self.selected_paths();
        let paths = self.hideable(|item| selected.iter().any(|path| path.is_within(&item.path) || *path == item.path));
        let hidden =
            |path: &Path| self.open.as_ref().and_then(|open| open.document.item(path)).is_some_and(|item| item.hidden);
        let show = paths.iter().all(hidden);
        self.set_hidden(paths, !show);
    }

    fn hide_others(&mut self) {
        let selected = self.selected_paths();
        let is_other = |item: &Item| {
            item.kind == ItemKind::Object
                && !item.hidden
                && !selected.iter().any(|path| path.is_within(&item.path) || *path == item.path)
        };
        if !selected.is_empty() {
            self.set_hidden(self.hideable(is_other), true);
        }
    }

    /// Locks the objects of the selected nodes, or unlocks them if all of them are locked.
    fn lock(&mut self) {
        let selected = self.selected_paths();
        let paths = self.hideable(|item| {
            item.kind == ItemKind::Object
                && selected.iter().any(|path| path.is_within(&item.path) || *path == item.path)
        });
        let Some(open) = &mut self.open else { return };
        let names: Vec<String> = paths.iter().filter_map(|path| open.document.item(path)?.name.clone()).collect();
        let unlock = names.iter().all(|name| open.locked.contains(name));
        for name in names {
            if unlock {
                open.locked.remove(&name);
            } else {
                open.locked.insert(name);
            }
        }
    }
}
