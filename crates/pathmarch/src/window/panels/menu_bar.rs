//! Menu bar and toolbar.

use crate::window::app::App;
use crate::window::app::actions::{ACTIONS, Action, Entry, Menu};
use crate::window::app::requests::PendingAction;
use crate::window::open_scene::view_state::GizmoMode;
use egui::Ui;
use pathmarch_render::Mode;
use pathmarch_render::pathmarch_scene::document::Document;

impl App {
    pub(crate) fn menu_bar(&mut self, ui: &mut Ui) {
        let mut requested = None;
        egui::Panel::top("menus").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                for menu in Menu::ALL {
                    ui.menu_button(menu.name(), |ui| {
                        for entry in ACTIONS.iter().filter(|entry| entry.menu == menu) {
                            if self.menu_entry(ui, entry) {
                                requested = Some(entry.action);
                            }
                            if entry.action == Action::Open {
                                self.recent_menu(ui);
                            }
                        }
                    });
                }
                if self.open.is_some() {
                    ui.separator();
                    requested = requested.or(self.toolbar(ui));
                }
            });
        });
        if let Some(action) = requested {
            let ctx = ui.ctx().clone();
            self.run_action(&ctx, action);
        }
    }

    /// Draws a menu entry; returns true if it was clicked.
    fn menu_entry(&self, ui: &mut Ui, entry: &Entry) -> bool {
        let document = self.open.as_ref().map(|open| &open.document);
        let mut name = entry.name.to_owned();
        let mut enabled = document.is_some() || !entry.needs_scene;
        let has_selection = self.open.as_ref().is_some_and(|open| open.view.selection.active().is_some());
        match entry.action {
            Action::Undo | Action::Redo => {
                let label = document.and_then(|document| {
                    if entry.action == Action::Undo { document.can_undo() } else { document.can_redo() }
                });
                enabled = label.is_some();
                name = label.map_or(name, |label| format!("{}: {label}", entry.name));
            }
            Action::Duplicate | Action::Delete | Action::Group | Action::Ungroup | Action::ToGround => {
                enabled &= has_selection;
            }
            Action::AllowFiles => enabled &= document.is_some_and(Document::is_confined),
            Action::Unite | Action::Subtract | Action::Intersect => {
                enabled &= self.open.as_ref().is_some_and(|open| open.view.selection.paths().len() > 1);
            }
            _ => {}
        }
        let is_on = entry.action == Action::SnapToSurfaces && self.snap_to_surfaces;
        let mut button = egui::Button::new(name).selected(is_on);
        if let Some(shortcut) = &entry.shortcut {
            button = button.shortcut_text(ui.ctx().format_shortcut(shortcut));
        }
        let chosen = ui.add_enabled(enabled, button).on_hover_text(entry.doc).clicked();
        if chosen {
            ui.close();
        }
        chosen
    }

    fn recent_menu(&mut self, ui: &mut Ui) {
        let recent = self.preferences.recent.clone();
        ui.add_enabled_ui(!recent.is_empty(), |ui| {
            ui.menu_button("Open recent", |ui| {
                for path in recent {
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                        self.guard_unsaved(PendingAction::OpenFile(path));
                        ui.close();
                    }
                }
            });
        });
    }

    /// Toolbar: gizmo mode, preview, comparison, save and render.
    fn toolbar(&mut self, ui: &mut Ui) -> Option<Action> {
        let open = self.open.as_mut()?;
        let mut requested = None;
        for (handles, name, action) in [
            (GizmoMode::Move, "Move", Action::GizmoMove),
            (GizmoMode::Rotate, "Rotate", Action::GizmoRotate),
            (GizmoMode::Scale, "Scale", Action::GizmoScale),
        ] {
            let doc = ACTIONS.iter().find(|entry| entry.action == action).map_or("", |entry| entry.doc);
            if ui.selectable_label(open.view.gizmo_mode == handles, name).on_hover_text(doc).clicked() {
                requested = Some(action);
            }
        }
        ui.separator();
        let previews = open.view.mode == Mode::Preview;
        if ui.selectable_label(previews, "Preview").on_hover_text(Mode::Preview.doc()).clicked() {
            requested = Some(Action::Preview);
        }
        let compares = open.view.comparison.as_ref().is_some_and(|kept| kept.shown);
        if ui
            .selectable_label(compares, "Compare")
            .on_hover_text("Store this picture and compare later ones with it.")
            .clicked()
        {
            requested = Some(Action::Compare);
        }
        ui.separator();
        let unsaved = open.has_unsaved_work();
        if ui.add_enabled(unsaved, egui::Button::new("Save")).on_hover_text("Save the scene to its file.").clicked() {
            requested = Some(Action::Save);
        }
        if ui.button("Render…").on_hover_text("Render with all samples to a file, in the background.").clicked() {
            requested = Some(Action::Render);
        }
        requested
    }
}
