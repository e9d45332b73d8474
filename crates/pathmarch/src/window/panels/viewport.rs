//! Viewport: the live picture, with mouse and keyboard controls.

use crate::window::app::App;
use crate::window::gizmo::{GizmoChange, GizmoScene, Pointer, world_origin};
use crate::window::open_scene::OpenScene;
use crate::window::open_scene::view_state::ComparisonPicture;
use crate::window::projection::Projection;
use crate::window::surface_snap::{SurfacePoint, extent_below};
use egui::{Align2, Color32, CursorIcon, FontId, Key, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};
use glam::DVec3;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::pathmarch_scene::document::Path as NodePath;
use pathmarch_render::pathmarch_scene::navigation;
use pathmarch_render::{Picked, clearance, pick};
use std::f32::consts::PI;

/// Distance from the comparison line at which the pointer grabs it, points.
const GRAB_DISTANCE: f32 = 7.0;

/// Action of a click, run after all borrows have ended.
enum PickAction {
    Select(Option<Picked>),
    /// Adds to the selection, or removes from it.
    Extend(Option<Picked>),
    LookAt(Picked),
    Focus(Option<Picked>),
}

impl App {
    pub(crate) fn viewport(&mut self, ui: &mut Ui) {
        egui::CentralPanel::no_frame().frame(egui::Frame::NONE).show(ui, |ui| {
            let area = ui.available_rect_before_wrap();
            self.picture(ui);
            self.diagnostics_panel(ui, area);
        });
    }

    fn picture(&mut self, ui: &mut Ui) {
        let area = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(area, Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Viewport"));
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else {
            fill_around(ui, area, Rect::from_center_size(area.center(), Vec2::ZERO));
            let words = "This scene has errors, so there is no picture yet.\nThey are listed below. Correct the text here or in any editor.";
            ui.painter().text(
                area.center(),
                Align2::CENTER_CENTER,
                words,
                FontId::proportional(16.0),
                ui.visuals().text_color(),
            );
            return;
        };
        let pixels_per_point = ui.ctx().pixels_per_point();
        let inner = area.shrink(6.0);
        let pixels = |side: f32| (side * pixels_per_point).max(1.0) as u32;
        let window = ui.ctx().content_rect().size();
        let available = [pixels(inner.width()), pixels(inner.height())];
        open.view.set_available(available, [pixels(window.x), pixels(window.y)]);
        let (width, height) = scene.render.size;
        let fit = (inner.width() / width as f32).min(inner.height() / height as f32);
        let picture = Rect::from_center_size(area.center(), Vec2::new(width as f32, height as f32) * fit);
        fill_around(ui, area, picture);
        match &open.view.picture {
            Some((texture, ..)) => {
                let uv = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
                ui.painter().image(texture.id(), picture, uv, Color32::WHITE);
            }
            None => {
                ui.painter().rect_filled(picture, 0.0, Color32::BLACK);
                ui.put(Rect::from_center_size(picture.center(), Vec2::splat(32.0)), egui::Spinner::new());
            }
        }
        outline(ui, picture, open, &scene);
        let comparing = compare(ui, picture, open, &response);
        let handled = self.handles(ui, picture, &response);
        if !comparing && !handled {
            self.pointer(ui, picture, &scene, &response);
        }
        self.drop_material(ui, &response, |app| {
            let open = app.open.as_ref()?;
            let at = ui.input(|input| input.pointer.latest_pos())?;
            let path = open.document.path_of_leaf(pick_at(open, &scene, picture, at)?.leaf)?;
            let path = owner_of_material(open, path);
            let rect = bounds_in_window(open, &scene, picture, &path).unwrap_or(picture);
            (!open.is_locked(&path)).then_some((path, rect))
        });
        self.fly(ui, &scene, &response);
        let Some(open) = &self.open else { return };
        if open.view.focus_click && response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Crosshair);
        }
    }

    /// Draws the gizmo of the selection and applies its changes. Returns true if it uses the pointer.
    fn handles(&mut self, ui: &Ui, picture: Rect, response: &Response) -> bool {
        let Some(open) = &mut self.open else { return false };
        let Some(selection) = open.view.selection.active().cloned() else { return false };
        if open.document.scene().is_err() || open.is_locked(&selection) {
            return false;
        }
        let pointer = ui.input(|input| {
            let position = input.pointer.latest_pos()?;
            let plain = !input.modifiers.alt && !input.modifiers.shift;
            let pressed = input.pointer.primary_pressed();
            // A drag that began elsewhere does not grab a handle.
            let free = pressed || !input.pointer.any_down();
            Some(Pointer {
                position,
                hovered: response.contains_pointer() && plain && free,
                // On a slow machine the pointer has already moved on within the frame.
                pressed_at: input.pointer.press_origin().filter(|_| pressed),
                down: input.pointer.primary_down(),
            })
        });
        let Some(scene) = open.document.last_good().cloned() else { return false };
        self.keep_surroundings();
        let Some(open) = &self.open else { return false };
        let surroundings = self.surroundings.as_ref().and_then(|(path, scene)| Some((path, scene.as_ref()?)));
        let surface = |at: Pos2| {
            let (path, around) = surroundings?;
            surface_at(open, &scene, around, path, picture, at)
        };
        let of = GizmoScene {
            document: &open.document,
            scene: &scene,
            camera: &open.view.camera,
            selection: &selection,
            mode: open.view.gizmo_mode,
            surface: surroundings.is_some().then_some(&surface),
        };
        let (taken, changes) = self.gizmo.show(ui, picture, of, pointer);
        let undo_group = self.undo_group;
        for change in changes {
            self.edit(|open| {
                let document = &mut open.document;
                match change {
                    GizmoChange::Property(path, key, value) => document.set(&path, &key, value, Some(undo_group)),
                    GizmoChange::MovePoint(path, point, at) => document.move_point(&path, point, at, Some(undo_group)),
                    GizmoChange::AddPoint(path, point, at) => document.add_point(&path, point, at, Some(undo_group)),
                }
            });
        }
        self.point_menu(response);
        taken
    }

    /// Reads the scene without the node that is dragged onto surfaces, once a drag.
    fn keep_surroundings(&mut self) {
        let dragged = self.gizmo.dragged_freely().filter(|_| self.snap_to_surfaces);
        let Some((dragged, open)) = dragged.zip(self.open.as_mut()) else {
            self.surroundings = None;
            return;
        };
        if self.surroundings.as_ref().is_none_or(|(path, _)| path != dragged) {
            self.surroundings = Some((dragged.clone(), open.document.scene_without(dragged)));
        }
    }

    /// Context menu of the control point that was clicked.
    fn point_menu(&mut self, response: &Response) {
        if response.secondary_clicked() {
            self.clicked_point = self.gizmo.hovered_point.clone();
        }
        let (Some((path, point)), Some(open)) = (self.clicked_point.clone(), &self.open) else { return };
        let Some(control) = open.document.control_points(&path).get(point).copied() else { return };
        let is_curve = open.document.item(&path).is_some_and(|item| item.word == "curve");
        let (mut removes, mut corner) = (false, None);
        let menu = egui::Popup::context_menu(response);
        menu.show(|ui| {
            if is_curve {
                let mut is_corner = control.is_corner;
                if ui.checkbox(&mut is_corner, "Corner").changed() {
                    corner = Some(is_corner);
                    ui.close();
                }
            }
            removes = ui.button("Remove point").clicked();
            if removes {
                ui.close();
            }
        });
        if let Some(is_corner) = corner {
            self.edit(|open| open.document.set_corner(&path, point, is_corner));
        }
        if removes {
            self.edit(|open| open.document.remove_point(&path, point));
            self.clicked_point = None;
        }
    }

    /// Applies drags, clicks and the wheel to camera and selection.
    fn pointer(&mut self, ui: &Ui, picture: Rect, scene: &Scene, response: &Response) {
        let Some(open) = &mut self.open else { return };
        let (scroll, zoom, modifiers) =
            ui.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta(), input.modifiers));
        let before = open.view.camera.clone();
        let delta = response.drag_delta() / picture.height().max(1.0);
        let boxes = modifiers.command && response.dragged_by(PointerButton::Primary);
        let boxed = modifiers.command && response.drag_stopped_by(PointerButton::Primary);
        if (boxes || boxed)
            && let (Some(from), Some(to)) = ui.input(|input| (input.pointer.press_origin(), input.pointer.latest_pos()))
        {
            let rect = Rect::from_two_pos(from, to);
            ui.painter().rect_stroke(rect, 0.0, Stroke::new(1.0, Color32::WHITE), egui::StrokeKind::Middle);
            let paths = shapes_in(open, scene, picture, rect);
            open.view.selection.set(&open.document, paths);
            return;
        }
        let camera = &mut open.view.camera;
        let pans = response.dragged_by(PointerButton::Middle)
            || response.dragged_by(PointerButton::Primary) && modifiers.shift;
        if pans {
            navigation::pan(camera, delta.x, delta.y);
        } else if response.dragged_by(PointerButton::Primary) {
            navigation::orbit(camera, -delta.x * PI, -delta.y * PI);
        } else if response.dragged_by(PointerButton::Secondary) {
            let angle = camera.fov.to_radians();
            navigation::look(camera, -delta.x * angle, -delta.y * angle);
        }
        if response.contains_pointer() {
            navigation::dolly(camera, (-scroll * 0.002).exp() / zoom);
        }
        if *camera != before {
            open.view.mark_moving();
        }
        let Some(at) = response.interact_pointer_pos() else { return };
        let clicked = response.clicked() || response.double_clicked();
        if !clicked {
            return;
        }
        let picked = pick_at(open, scene, picture, at);
        let focuses = modifiers.alt || open.view.focus_click;
        let action = match picked {
            picked if focuses => PickAction::Focus(picked),
            picked if modifiers.command || modifiers.shift => PickAction::Extend(picked),
            Some(picked) if response.double_clicked() => PickAction::LookAt(picked),
            picked => PickAction::Select(picked),
        };
        self.apply_pick(action);
    }

    fn apply_pick(&mut self, action: PickAction) {
        let Some(open) = &mut self.open else { return };
        let path = match &action {
            PickAction::Select(Some(picked)) | PickAction::Extend(Some(picked)) => {
                open.document.path_of_leaf(picked.leaf)
            }
            _ => None,
        };
        let path = path.filter(|path| !open.is_locked(path));
        let view = &mut open.view;
        match action {
            PickAction::Select(None) => view.selection.clear(),
            PickAction::Select(Some(_)) => view.selection.set(&open.document, path),
            PickAction::Extend(None) => {}
            PickAction::Extend(Some(_)) => {
                if let Some(path) = path {
                    view.selection.toggle(&open.document, path);
                }
            }
            PickAction::LookAt(picked) => {
                navigation::look_at(&mut view.camera, picked.position.into());
                // Focus on the new target, like a camera with centre autofocus.
                if view.camera.focus.is_some() {
                    view.camera.focus = Some(picked.distance);
                }
                view.mark_moving();
            }
            PickAction::Focus(picked) => {
                view.focus_click = false;
                let Some(picked) = picked else { return self.show_message("There is nothing to focus on.") };
                view.camera.focus = Some(picked.depth);
                view.mark_moving();
                let sharp = if view.camera.lens_radius > 0.0 {
                    String::new()
                } else {
                    "; everything is sharp while the lens radius is 0".to_owned()
                };
                self.show_message(&format!("Focus distance: {:.3} m{sharp}.", picked.depth));
            }
        }
    }

    /// Flies while keys are held.
    fn fly(&mut self, ui: &Ui, scene: &Scene, response: &Response) {
        if ui.ctx().text_edit_focused() || !(response.contains_pointer() || response.has_focus()) {
            return;
        }
        let Some(open) = &mut self.open else { return };
        let (towards, seconds) = ui.input(|input| {
            let along = |more: Key, less: Key| f32::from(input.key_down(more)) - f32::from(input.key_down(less));
            let fast = if input.modifiers.shift { 4.0 } else { 1.0 };
            let towards = glam::Vec3::new(along(Key::D, Key::A), along(Key::E, Key::Q), along(Key::W, Key::S)) * fast;
            (if input.modifiers.command { glam::Vec3::ZERO } else { towards }, input.stable_dt.min(0.1))
        });
        if towards != glam::Vec3::ZERO {
            let clearance = clearance(scene, open.view.camera.position);
            let clearance = if clearance.is_finite() { clearance } else { 1.0 };
            navigation::fly(&mut open.view.camera, towards, seconds, clearance);
            open.view.mark_moving();
            ui.ctx().request_repaint();
        }
    }
}

/// Fills the area around the picture. No pixel is drawn twice, as that is slow on software adapters.
fn fill_around(ui: &Ui, area: Rect, picture: Rect) {
    let fill = if ui.visuals().dark_mode { Color32::from_gray(18) } else { Color32::from_gray(150) };
    let (x, y) = (
        [area.min.x, picture.min.x, picture.max.x, area.max.x],
        [area.min.y, picture.min.y, picture.max.y, area.max.y],
    );
    for [x0, y0, x1, y1] in
        [[x[0], y[0], x[3], y[1]], [x[0], y[2], x[3], y[3]], [x[0], y[1], x[1], y[2]], [x[2], y[1], x[3], y[2]]]
    {
        ui.painter().rect_filled(Rect::from_min_max(Pos2::new(x0, y0), Pos2::new(x1, y1)), 0.0, fill);
    }
}

/// Draws the bounding boxes of the selected nodes.
fn outline(ui: &Ui, picture: Rect, open: &OpenScene, scene: &Scene) {
    for selection in open.view.selection.paths() {
        outline_of(ui, picture, open, scene, selection);
    }
}

/// Draws the bounding box of a node.
fn outline_of(ui: &Ui, picture: Rect, open: &OpenScene, scene: &Scene, node: &NodePath) {
    let leaves = open.document.leaves_of(node);
    let boxes = leaves.into_iter().map(|leaf| scene.field.declared_bounds(leaf)).filter(|bounds| bounds.is_finite());
    let Some(bounds) = boxes.reduce(|all, bounds| all.union(bounds)) else { return };
    let projection = Projection::new(&open.view.camera, picture);
    let painter = ui.painter_at(picture);
    let corner = |k: usize| {
        DVec3::from_array(std::array::from_fn(|axis| {
            f64::from(if k >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] })
        }))
    };
    for a in 0..8 {
        for b in [1, 2, 4].map(|bit| a | bit).into_iter().filter(|&b| b != a) {
            if let (Some(from), Some(to)) = (projection.project(corner(a)), projection.project(corner(b))) {
                painter.line_segment([from, to], Stroke::new(2.5, Color32::from_black_alpha(110)));
                painter.line_segment([from, to], Stroke::new(1.0, Color32::from_rgb(255, 190, 90)));
            }
        }
    }
}

/// The node that names the material of a shape, or else its object.
fn owner_of_material(open: &OpenScene, shape: NodePath) -> NodePath {
    let around = std::iter::successors(Some(shape.clone()), NodePath::parent);
    let names = |path: &NodePath| open.document.item(path).is_some_and(|item| item.material.is_some());
    around.clone().find(names).or_else(|| around.last()).unwrap_or(shape)
}

/// Rectangle around the bounds of a node in the window; `None` if they are infinite or reach behind the camera.
fn bounds_in_window(open: &OpenScene, scene: &Scene, picture: Rect, node: &NodePath) -> Option<Rect> {
    let leaves = open.document.leaves_of(node).into_iter().map(|leaf| scene.field.declared_bounds(leaf));
    let bounds = leaves.reduce(|all, bounds| all.union(bounds)).filter(|bounds| bounds.is_finite())?;
    let projection = Projection::new(&open.view.camera, picture);
    let corner = |k: usize| {
        let at = |axis: usize| if k >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        projection.project(DVec3::from_array([0, 1, 2].map(|axis| f64::from(at(axis)))))
    };
    let corners: Vec<Pos2> = (0..8).map(corner).collect::<Option<_>>()?;
    Some(Rect::from_points(&corners).intersect(picture))
}

/// Shapes whose bounds have their centre in a rectangle of the window.
fn shapes_in(open: &OpenScene, scene: &Scene, picture: Rect, rect: Rect) -> Vec<NodePath> {
    let projection = Projection::new(&open.view.camera, picture);
    let is_inside = |leaf: &usize| {
        let bounds = scene.field.declared_bounds(*leaf);
        let centre = DVec3::from_array(std::array::from_fn(|k| 0.5 * f64::from(bounds.min[k] + bounds.max[k])));
        bounds.is_finite() && projection.project(centre).is_some_and(|at| rect.contains(at))
    };
    let mut paths: Vec<NodePath> =
        (0..scene.field.leaves().len()).filter(is_inside).filter_map(|leaf| open.document.path_of_leaf(leaf)).collect();
    paths.dedup();
    paths.retain(|path| !open.is_locked(path));
    paths
}

/// Picks the surface at a point of the window.
fn pick_at(open: &OpenScene, scene: &Scene, picture: Rect, at: Pos2) -> Option<Picked> {
    let settings = App::settings(open, scene);
    let place = (at - picture.min) / picture.size();
    let inside = (0.0..1.0).contains(&place.x) && (0.0..1.0).contains(&place.y);
    let [width, height] = settings.size.map(|side| side as f32);
    if inside { pick(scene, &settings, [place.x * width, place.y * height]) } else { None }
}

/// The surface under a point of the window in the scene without a node, and where the node touches it.
fn surface_at(
    open: &OpenScene,
    scene: &Scene,
    around: &Scene,
    node: &NodePath,
    picture: Rect,
    at: Pos2,
) -> Option<SurfacePoint> {
    let picked = pick_at(open, around, picture, at)?;
    let [position, normal] = [picked.position, picked.normal].map(|v| DVec3::from_array(v.map(f64::from)));
    let origin = world_origin(&open.document, node);
    let below = extent_below(&open.document, &scene.field, node, origin, normal).unwrap_or(0.0);
    Some(SurfacePoint { position, touching: position + normal * below })
}

/// Draws the stored picture left of the comparison line. Returns true if the pointer drags the line.
fn compare(ui: &Ui, picture: Rect, open: &mut OpenScene, response: &Response) -> bool {
    let Some(ComparisonPicture { texture, label, split, shown: true }) = &mut open.view.comparison else {
        return false;
    };
    let x = egui::lerp(picture.x_range(), *split);
    let left = Rect::from_min_max(picture.min, Pos2::new(x, picture.max.y));
    let uv = Rect::from_min_max(Pos2::ZERO, Pos2::new(*split, 1.0));
    let painter = ui.painter_at(picture);
    painter.image(texture.id(), left, uv, Color32::WHITE);
    painter.vline(x, picture.y_range(), Stroke::new(2.0, Color32::WHITE));
    let note = |at: Pos2, anchor: Align2, words: &str| {
        let font = FontId::proportional(13.0);
        painter.text(at + Vec2::new(1.0, 1.0), anchor, words, font.clone(), Color32::BLACK);
        painter.text(at, anchor, words, font, Color32::WHITE);
    };
    note(Pos2::new(x - 8.0, picture.min.y + 6.0), Align2::RIGHT_TOP, &format!("stored: {label}"));
    note(Pos2::new(x + 8.0, picture.min.y + 6.0), Align2::LEFT_TOP, "now");
    let near = |at: Option<Pos2>| at.is_some_and(|at| (at.x - x).abs() < GRAB_DISTANCE && picture.contains(at));
    let (pressed_at, down) = ui.input(|input| (input.pointer.press_origin(), input.pointer.primary_down()));
    let id = response.id.with("comparison");
    let mut dragging = ui.data(|data| data.get_temp::<bool>(id)).unwrap_or(false);
    if !down {
        dragging = false;
    } else if response.drag_started() && near(pressed_at) {
        dragging = true;
    }
    ui.data_mut(|data| data.insert_temp(id, dragging));
    if dragging && let Some(at) = ui.input(|input| input.pointer.latest_pos()) {
        *split = ((at.x - picture.min.x) / picture.width()).clamp(0.0, 1.0);
    }
    let hovering = near(response.hover_pos());
    if dragging || hovering {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    dragging || hovering && down
}
