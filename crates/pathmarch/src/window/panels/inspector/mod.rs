//! Inspector: properties of the selection. Controls are generated from the document; no shape or material is known
//! here.

mod camera;
mod picture;
mod ramp;
mod widgets;

use crate::window::app::App;
use egui::Ui;
use pathmarch_render::pathmarch_scene::document::{
    Control, ControlKind, Item, ItemKind, PRESETS, Path, Ramp, Value, key,
};
use pathmarch_render::pathmarch_scene::settings;
use ramp::RampChange;
use widgets::{Change, row};

/// Smallest window width with room for inspector and picture, points.
pub(super) const LEAST_WINDOW: f32 = 640.0;
/// Colours that a ramp starts with.
const DEFAULT_COLOURS: [[f32; 3]; 2] = [[0.02; 3], [0.9; 3]];
/// Space that a row needs beside its slider, points.
const LABEL_AND_NUMBER: f32 = 225.0;

impl App {
    pub(crate) fn inspector_panel(&mut self, ui: &mut Ui) {
        let screen = ui.ctx().content_rect();
        if screen.width() < LEAST_WINDOW {
            // A narrow window leaves the space to the picture: the properties float above it.
            let window = egui::Window::new("Properties").default_open(false).default_width(0.6 * screen.width());
            let place = window.anchor(egui::Align2::RIGHT_TOP, [-6.0, 30.0]).max_height(screen.height() - 110.0);
            place.show(ui.ctx(), |ui| self.properties(ui));
            return;
        }
        let panel = egui::Panel::right("inspector").default_size(310.0).min_size(220.0).max_size(560.0);
        panel.show(ui, |ui| {
            // Contents wider than the panel are cut off instead of widening it, because that would resize the picture.
            let rect = ui.available_rect_before_wrap();
            let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(rect));
            inner.set_clip_rect(rect.expand(2.0).intersect(ui.clip_rect()));
            self.properties(&mut inner);
            ui.allocate_rect(rect, egui::Sense::hover());
        });
    }

    fn properties(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = (ui.available_width() - LABEL_AND_NUMBER).clamp(50.0, 130.0);
        egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            self.selected_controls(ui);
            ui.separator();
            self.parameter_controls(ui);
            self.camera_controls(ui);
            ui.separator();
            self.picture_controls(ui);
            self.histogram_of_picture(ui);
        });
    }

    fn selected_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &self.open else { return };
        let Some(item) = open.view.selection.active().and_then(|path| open.document.item(path)).cloned() else {
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
        if item.kind == ItemKind::Material {
            ui.horizontal(|ui| {
                self.ball_of(ui, item.title());
                self.material_presets(ui, &item.path);
            });
        }
        self.controls_of(ui, &item.path);
        // Show the material of the object, or the inherited one.
        if item.kind == ItemKind::Object || item.kind.is_solid() {
            let Some(open) = &self.open else { return };
            let up = |path: &Path| path.parent();
            let around = std::iter::successors(Some(item.path.clone()), up);
            let mut named = around.filter_map(|path| Some((open.document.item(&path)?.material.clone()?, path)));
            if let Some((material, user)) = named.next() {
                self.linked_material(ui, &material, &user);
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
                if let Some(changed) = row(ui, path, control) {
                    change = Some((path, changed));
                }
                ui.end_row();
            }
        });
        let undo_group = self.undo_group;
        match change {
            Some((path, Change::Set(value))) => {
                self.edit(|open| open.document.set(path, key::VALUE, value, Some(undo_group)));
            }
            Some((path, Change::Key)) => drop(self.edit(|open| open.document.set_key(path, key::VALUE, None))),
            Some((_, Change::Reset)) | None => {}
        }
        ui.separator();
    }

    /// Controls of the material that the selection uses.
    fn linked_material(&mut self, ui: &mut Ui, material: &str, user: &Path) {
        let Some(open) = &self.open else { return };
        let is_it = |item: &&Item| item.kind == ItemKind::Material && item.name.as_deref() == Some(material);
        let Some(path) = open.document.outline().iter().find(is_it).map(|item| item.path.clone()) else { return };
        egui::CollapsingHeader::new(format!("Material “{material}”"))
            .id_salt("linked material")
            .default_open(true)
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    self.ball_of(ui, material);
                    ui.vertical(|ui| {
                        self.shared_material(ui, material, &path, user);
                        self.material_presets(ui, &path);
                    });
                });
                self.controls_of(ui, &path);
            });
    }

    /// Tells how many nodes use a material, and offers a copy for this one.
    fn shared_material(&mut self, ui: &mut Ui, material: &str, path: &Path, user: &Path) {
        let uses = self.open.as_ref().map_or(0, |open| open.document.uses_of_material(material));
        if uses < 2 {
            return;
        }
        let mut copied = false;
        ui.horizontal_wrapped(|ui| {
            ui.weak(format!("Used {uses} times."));
            let button = ui
                .small_button("Make a copy")
                .on_hover_text("Give this one its own copy; the others keep the material.");
            copied = button.clicked();
        });
        if copied {
            self.edit(|open| open.document.copy_material(user, path));
        }
    }

    /// Menu of materials to start from.
    fn material_presets(&mut self, ui: &mut Ui, path: &Path) {
        let mut chosen = None;
        ui.menu_button("Presets…", |ui| {
            for preset in PRESETS {
                if ui.button(preset.name).clicked() {
                    chosen = Some(preset.name);
                    ui.close();
                }
            }
        });
        if let Some(preset) = chosen {
            self.edit(|open| open.document.apply_preset(path, preset));
        }
    }

    /// All controls of a node.
    fn controls_of(&mut self, ui: &mut Ui, path: &Path) {
        let Some(open) = &self.open else { return };
        let animated = open.document.last_good().is_some_and(|scene| scene.animated);
        let ramps = open.document.ramps(path);
        let (mut unset, controls): (Vec<Control>, Vec<Control>) =
            open.document.controls(path).into_iter().partition(|control| is_unset(control, animated));
        // The bar of a ramp sets the positions of its colours.
        unset.retain(|control| !(control.key.contains(".colour.") && control.key.ends_with(".at")));
        let (mut change, mut ramp_change) = (None, None);
        egui::Grid::new(("controls", path)).num_columns(2).spacing([8.0, 5.0]).striped(true).show(ui, |ui| {
            for control in &controls {
                let first_of = |ramp: &&Ramp| control.key.strip_prefix(&*ramp.name) == Some(".colour.1");
                if let Some(ramp) = ramps.iter().find(first_of) {
                    let label = ui.label(format!("{} ramp", ramp.name));
                    if let Some(changed) = ramp::bar(ui, path, ramp, &label) {
                        ramp_change = Some((ramp, changed));
                    }
                    ui.end_row();
                }
                if let Some(changed) = row(ui, path, control) {
                    change = Some((&*control.key, changed));
                }
                ui.end_row();
            }
        });
        let empty: Vec<&Ramp> = ramps.iter().filter(|ramp| ramp.colours.is_empty()).collect();
        let mut started = None;
        if !(unset.is_empty() && empty.is_empty()) {
            ui.horizontal_wrapped(|ui| {
                ui.weak("Add:");
                for ramp in &empty {
                    let button = ui.small_button(match &*ramp.name {
                        "colour" => "colours".to_owned(),
                        name => format!("{name} colours"),
                    });
                    if button.on_hover_text("Add a ramp of colours, from the value 0 to the value 1.").clicked() {
                        started = Some(*ramp);
                    }
                }
                for control in &unset {
                    if ui.small_button(&*control.label).on_hover_text(&*control.doc).clicked() {
                        change = Some((&*control.key, Change::Set(control.initial.clone())));
                    }
                }
            });
        }
        let undo_group = self.undo_group;
        if let Some(ramp) = started {
            self.edit(|open| open.document.start_ramp(path, ramp, &DEFAULT_COLOURS));
        }
        if let Some((ramp, change)) = ramp_change {
            self.edit(|open| match change {
                RampChange::Add(colour, position) => {
                    open.document.add_colour_at(path, ramp, colour, position, undo_group)
                }
                RampChange::Remove(index) => open.document.remove_colour(path, ramp, index),
                RampChange::Place(index, position) => {
                    open.document.place_colour(path, ramp, index, position, undo_group)
                }
            });
        }
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
            Some((key, Change::Key)) => {
                self.edit(|open| open.document.set_key(path, key, None));
            }
            None => {}
        }
    }
}

/// True for a control that is not shown until it is added: one without value, or of motion in a still scene.
fn is_unset(control: &Control, animated: bool) -> bool {
    let of_motion = settings::OF_MOTION.contains(&&*control.key);
    let has_none = control.value == Value::None && !matches!(control.kind, ControlKind::Material(_));
    has_none || of_motion && !control.given && !animated
}

/// Heading of a node: kind and name.
pub(crate) fn heading(item: &Item) -> String {
    match &item.name {
        Some(name) => format!("{} “{name}”", item.word),
        None => item.word.clone(),
    }
}
