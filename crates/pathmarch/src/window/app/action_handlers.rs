//! Handlers of menu and shortcut actions.

use super::App;
use super::actions::Action;
use super::dialog::{Dialog, RenderDialog};
use super::requests::{FileRequest, PendingAction, file_dialog_options};
use crate::window::file_dialog::FileDialog;
use crate::window::open_scene::view_state::{ComparisonPicture, GizmoMode};
use egui::{ColorImage, Context, TextureOptions};
use pathmarch_render::Mode;
use pathmarch_render::pathmarch_field::MESH_EXTENSIONS;
use pathmarch_render::pathmarch_scene::document::{Item, ItemKind, Path as NodePath};
use pathmarch_render::pathmarch_scene::navigation;

impl App {
    /// Runs an action.
    pub(crate) fn run_action(&mut self, ctx: &Context, action: Action) {
        match action {
            Action::New => self.guard_unsaved(PendingAction::New),
            Action::Open => self.guard_unsaved(PendingAction::Open),
            Action::Gallery => self.guard_unsaved(PendingAction::Gallery),
            Action::Import => {
                let options = file_dialog_options("Import a mesh", &MESH_EXTENSIONS);
                let dialog = FileDialog::open(&self.directory(), options);
                self.file_dialog = Some((self.with_bookmarks(dialog), FileRequest::Import));
            }
            Action::Quit => self.request_quit(),
            Action::Save => drop(self.save(None)),
            Action::SaveAs => self.choose_save_path(FileRequest::SaveAs),
            Action::AllowFiles => self.allow_files(),
            Action::SavePicture => self.choose_picture_path(),
            Action::Render => self.dialog = self.open.as_ref().and_then(RenderDialog::new).map(Dialog::Render),
            Action::Undo | Action::Redo => self.undo_or_redo(action == Action::Undo),
            Action::Help => self.help = !self.help,
            Action::PictureOnly => self.picture_only = !self.picture_only,
            Action::Recover => self.offer_recovery(),
            // Escape closes what is on top first.
            Action::Deselect if self.help => self.help = false,
            Action::Deselect if self.picture_only => self.picture_only = false,
            Action::Play => self.play_or_pause(ctx),
            Action::NextFrame | Action::PreviousFrame => self.step_frame(action == Action::NextFrame),
            Action::RestartGraphics => {
                self.restart_graphics();
            }
            Action::Tree => self.preferences.left_open = !self.preferences.left_open,
            Action::Materials => self.palette = !self.palette,
            Action::Inspector => self.preferences.right_open = !self.preferences.right_open,
            Action::Source => self.preferences.show_source = !self.preferences.show_source,
            Action::Plots => self.preferences.show_plots = !self.preferences.show_plots,
            Action::Dark => {
                let dark = ctx.theme() != egui::Theme::Dark;
                self.preferences.dark = Some(dark);
                ctx.set_theme(if dark { egui::Theme::Dark } else { egui::Theme::Light });
            }
            _ => self.run_edit_action(ctx, action),
        }
    }

    /// Lets the open scene read files outside its folder.
    fn allow_files(&mut self) {
        let Some(open) = &mut self.open else { return };
        open.document.allow_files();
        self.document_changed();
        self.show_message("This scene may read files outside its folder until it is closed.");
    }

    /// Selects a node; `None` keeps the selection.
    pub(crate) fn select(&mut self, path: Option<NodePath>) {
        if let (Some(open), Some(path)) = (&mut self.open, path) {
            open.view.selection.set(&open.document, [path]);
        }
    }

    fn undo_or_redo(&mut self, back: bool) {
        let Some(open) = &mut self.open else { return };
        let label = if back { open.document.undo() } else { open.document.redo() };
        if let Some(label) = label {
            self.document_changed();
            self.show_message(&format!("{}: {label}", if back { "Undone" } else { "Redone" }));
        }
    }

    pub(super) fn run_view_action(&mut self, ctx: &Context, action: Action) {
        let Some(open) = &mut self.open else { return };
        let view = &mut open.view;
        match action {
            Action::Deselect => {
                view.selection.clear();
                view.focus_click = false;
            }
            Action::ResetCamera | Action::NextCamera => {
                let Some(scene) = open.document.last_good() else { return };
                let cameras = &scene.cameras;
                let here = cameras.iter().position(|camera| camera.name == view.camera_name()).unwrap_or(0);
                let next = if action == Action::NextCamera { (here + 1) % cameras.len() } else { here };
                view.use_camera(&cameras[next]);
                if action == Action::NextCamera {
                    let words = format!("Camera “{}”", cameras[next].name);
                    self.show_message(&words);
                }
            }
            Action::WriteCamera => self.write_camera(),
            Action::FrameSelection => self.frame_selection(),
            Action::FocusClick => view.focus_click = !view.focus_click,
            Action::GizmoMove => view.gizmo_mode = GizmoMode::Move,
            Action::GizmoRotate => view.gizmo_mode = GizmoMode::Rotate,
            Action::GizmoScale => view.gizmo_mode = GizmoMode::Scale,
            Action::Preview => {
                view.mode = if view.mode == Mode::Preview { Mode::Path } else { Mode::Preview };
            }
            Action::KeepForComparison => self.keep_for_comparison(ctx),
            Action::Compare => match &mut view.comparison {
                Some(kept) => kept.shown = !kept.shown,
                None => self.keep_for_comparison(ctx),
            },
            _ => {}
        }
    }

    /// Writes the current view to the scene's camera.
    pub(crate) fn write_camera(&mut self) {
        let written = self.edit(|open| {
            let name = open.view.camera_name().to_owned();
            let is_it = |item: &&Item| item.kind == ItemKind::Camera && item.name.as_deref().unwrap_or("main") == name;
            let path = open.document.outline().iter().find(is_it).map(|item| item.path.clone());
            let camera = open.view.camera.clone();
            open.document.write_camera(&camera, path.as_ref())?;
            let scene = open.document.last_good().cloned();
            if let Some(camera) = scene.iter().flat_map(|scene| &scene.cameras).find(|camera| camera.name == name) {
                open.view.set_scene_camera(camera);
            }
            Ok(name)
        });
        if let Some(name) = written {
            self.show_message(&format!("View saved to camera “{name}”."));
        }
    }

    fn frame_selection(&mut self) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        let leaves: Vec<usize> = match open.view.selection.paths() {
            [] => (0..scene.field.leaves().len()).collect(),
            paths => paths.iter().flat_map(|path| open.document.leaves_of(path)).collect(),
        };
        let boxes = leaves.into_iter().map(|leaf| scene.field.declared_bounds(leaf));
        let bounds = boxes.filter(|bounds| bounds.is_finite()).reduce(|all, bounds| all.union(bounds));
        let Some(bounds) = bounds else {
            self.show_message("The selection has no finite size, so it cannot be framed.");
            return;
        };
        let (min, max) = (glam::Vec3::from(bounds.min), glam::Vec3::from(bounds.max));
        navigation::frame(&mut open.view.camera, (min + max) * 0.5, (max - min).length() * 0.5);
        open.view.mark_moving();
    }

    fn keep_for_comparison(&mut self, ctx: &Context) {
        let (Some(open), Some(shown)) = (&mut self.open, self.live.picture()) else { return };
        let image = ColorImage::from_rgba_premultiplied(shown.size.map(|side| side as usize), &shown.codes);
        let texture = ctx.load_texture("kept picture", image, TextureOptions::LINEAR);
        let label = format!("{}, {:.0} samples", open.view.mode.name(), shown.samples);
        open.view.comparison = Some(ComparisonPicture { texture, label, split: 0.5, shown: true });
        self.show_message(
            "Picture stored. Drag the line to compare it with the current picture; B hides the stored picture.",
        );
    }
}
