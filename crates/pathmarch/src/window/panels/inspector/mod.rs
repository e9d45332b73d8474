//! Inspector: properties of the selection. Controls are generated from the document; no shape or material is known
//! here.

mod camera;
mod picture;
mod widgets;

use crate::window::app::App;
use egui::Ui;
use pathmarch_render::pathmarch_scene::document::{Control, Item, ItemKind, Path, Value, key};
use widgets::{Change, row};

/// Smallest window width with room for inspector and picture, points.
const LEAST_WINDOW: f32 = 640.0;

impl App {
    pub(crate) fn inspector_panel(&mut self, ui: &mut Ui) {
        // A narrow window leaves the space to the picture.
        if ui.ctx().content_rect().width() < LEAST_WINDOW {
            return;
        }
        let panel = egui::Panel::right("inspector").default_size(310.0).min_size(220.0).max_size(560.0);
        panel.show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                self.selected_controls(ui);
                ui.separator();
                self.parameter_controls(ui);
                self.camera_controls(ui);
                ui.separator();
                self.picture_controls(ui);
            });
        });
    }

    fn selected_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &self.open else { return };
        let Some(item) = open.view.selection.as_ref().and_then(|path| open.document.item(path)).cloned() else {
            ui.add_space(6.0);
            ui.weak("Nothing selected. Click a shape in the viewport or a row in the scene tree.");
            return;
        };
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            ui.heading(heading(&item));
            if let Some(line) = open.document.line_of(&item.path) {
                ui.weak(format!("line {line}"));
            }
        });
        self.controls_of(ui, &item.path);
        // Show the material of the object, or the inherited one.
        if item.kind == ItemKind::Object || item.kind.is_solid() {
            let Some(open) = &self.open else { return };
            let up = |path: &Path| path.parent();
            let around = std::iter::successors(Some(item.path.clone()), up);
            let mut named = around.filter_map(|path| open.document.item(&path)?.material.clone());
            if let Some(material) = named.next() {
                self.linked_material(ui, &material);
            }
        }
    }

    /// Controls of the scene's declared parameters.
    fn parameter_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &self.open else { return };
        let params = open.document.outline().iter().filter(|item| item.kind == ItemKind::Param);
        let params: Vec<(Path, Control)> = params
            .filter_map(|item| {
                let control = open.document.control(&item.path, key::VALUE)?;
                Some((item.path.clone(), Control { label: item.title().to_owned().into(), ..control }))
            })
            .collect();
        if params.is_empty() {
            return;
        }
        ui.heading("Parameters");
        let mut change = None;
        egui::Grid::new("parameters").num_columns(2).spacing([8.0, 5.0]).striped(true).show(ui, |ui| {
            for (path, control) in &params {
                if let Some(Change::Set(value)) = row(ui, path, control) {
                    change = Some((path, value));
                }
                ui.end_row();
            }
        });
        let undo_group = self.undo_group;
        if let Some((path, value)) = change {
            self.edit(|open| open.document.set(path, key::VALUE, value, Some(undo_group)));
        }
        ui.separator();
    }

    /// Controls of the material that the selection uses.
    fn linked_material(&mut self, ui: &mut Ui, material: &str) {
        let Some(open) = &self.open else { return };
        let is_it = |item: &&Item| item.kind == ItemKind::Material && item.name.as_deref() == Some(material);
        let Some(path) = open.document.outline().iter().find(is_it).map(|item| item.path.clone()) else { return };
        egui::CollapsingHeader::new(format!("Material “{material}”"))
            .id_salt("linked material")
            .default_open(true)
            .show(ui, |ui| self.controls_of(ui, &path));
    }

    /// All controls of a node.
    fn controls_of(&mut self, ui: &mut Ui, path: &Path) {
        let Some(open) = &self.open else { return };
        let controls = open.document.controls(path);
        let mut change = None;
        egui::Grid::new(("controls", path)).num_columns(2).spacing([8.0, 5.0]).striped(true).show(ui, |ui| {
            for control in &controls {
                if let Some(changed) = row(ui, path, control) {
                    change = Some((&*control.key, changed));
                }
                ui.end_row();
            }
        });
        let undo_group = self.undo_group;
        match change {
            Some((key::NAME, Change::Set(Value::Text(name)))) => {
                self.edit(|open| open.document.rename(path, &name));
            }
            Some((key, Change::Set(value))) => {
                self.edit(|open| open.document.set(path, key, value, Some(undo_group)));
            }
            Some((key, Change::Reset)) => {
                self.edit(|open| open.document.reset(path, key));
            }
            None => {}
        }
    }
}

/// Heading of a node: kind and name.
pub(crate) fn heading(item: &Item) -> String {
    match &item.name {
        Some(name) => format!("{} “{name}”", item.word),
        None => item.word.clone(),
    }
}
