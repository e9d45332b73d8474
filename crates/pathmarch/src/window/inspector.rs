//! The controls of what is selected. They are made of what the document says of a node: nothing here knows a shape or a
//! material.

use super::app::App;
use super::open::Resolution;
use egui::{ComboBox, DragValue, Response, RichText, Slider, SliderClamping, TextEdit, Ui};
use pathmarch_render::Mode;
use pathmarch_render::pathmarch_scene::document::{Control, ControlKind, Item, ItemKind, Path, Value, key};
use pathmarch_render::pathmarch_scene::settings;

/// Points of a window that has room for controls and a picture.
const LEAST_WINDOW: f32 = 640.0;

/// A change that a control asks for.
enum Change {
    Set(Value),
    Reset,
}

impl App {
    pub(super) fn inspector_panel(&mut self, ui: &mut Ui) {
        // Controls need their width; where that would leave nothing for the picture, they wait for a larger window.
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
            ui.weak("Nothing is selected. Click something in the picture or in the tree.");
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
        // Of what it is made, at hand; where it does not say, of what it stands in.
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

    /// The parameters of the file: what it is made to be changed by.
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
        let gesture = self.gesture;
        if let Some((path, value)) = change {
            self.edit(|open| open.document.set(path, key::VALUE, value, Some(gesture)));
        }
        ui.separator();
    }

    /// The controls of the material that something is made of.
    fn linked_material(&mut self, ui: &mut Ui, material: &str) {
        let Some(open) = &self.open else { return };
        let is_it = |item: &&Item| item.kind == ItemKind::Material && item.name.as_deref() == Some(material);
        let Some(path) = open.document.outline().iter().find(is_it).map(|item| item.path.clone()) else { return };
        egui::CollapsingHeader::new(format!("Material “{material}”"))
            .id_salt("linked material")
            .default_open(true)
            .show(ui, |ui| self.controls_of(ui, &path));
    }

    /// Every control of a node.
    fn controls_of(&mut self, ui: &mut Ui, path: &Path) {
        let Some(open) = &self.open else { return };
        let controls = open.document.controls(path);
        let mut change = None;
        egui::Grid::new(("controls", path)).num_columns(2).spacing([8.0, 5.0]).striped(true).show(ui, |ui| {
            for control in &controls {
                if let Some(changed) = row(ui, path, control) {
                    change = Some((control.key.clone(), changed));
                }
                ui.end_row();
            }
        });
        let gesture = self.gesture;
        match change {
            Some((key, Change::Set(Value::Text(name)))) if key == key::NAME => {
                self.edit(|open| open.document.rename(path, &name));
            }
            Some((key, Change::Set(value))) => {
                self.edit(|open| open.document.set(path, &key, value, Some(gesture)));
            }
            Some((key, Change::Reset)) => {
                self.edit(|open| open.document.reset(path, &key));
            }
            None => {}
        }
    }

    /// Where the picture is seen from: one's own viewpoint until it is written to the scene.
    fn camera_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        let Some(scene) = open.document.last_good().cloned() else { return };
        ui.horizontal(|ui| {
            ui.heading("Camera");
            let mut chosen = None;
            ComboBox::from_id_salt("cameras")
                .selected_text(open.view.camera_name())
                .show_ui(ui, |ui| {
                    for camera in &scene.cameras {
                        let is_it = camera.name == open.view.camera_name();
                        if ui.selectable_label(is_it, &camera.name).clicked() {
                            chosen = Some(camera);
                        }
                    }
                })
                .response
                .on_hover_text("The cameras of the scene.");
            if let Some(camera) = chosen {
                open.view.look_through(camera);
            }
        });
        let before = open.view.camera.clone();
        let camera = &mut open.view.camera;
        egui::Grid::new("camera").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
            let label = ui.label("field of view").on_hover_text("Vertical, degrees.");
            ui.add(Slider::new(&mut camera.fov, 5.0..=120.0).suffix("°").clamping(SliderClamping::Never))
                .labelled_by(label.id);
            ui.end_row();
            let label = ui.label("exposure").on_hover_text("Stops; for the screen and PNG, never for EXR.");
            ui.add(Slider::new(&mut camera.exposure, -6.0..=6.0).suffix(" EV").clamping(SliderClamping::Never))
                .labelled_by(label.id);
            ui.end_row();
            let label = ui.label("lens radius").on_hover_text("Metres; 0 is a pinhole, for which everything is sharp.");
            let lens = Slider::new(&mut camera.lens_radius, 0.0..=0.5).suffix(" m").logarithmic(true);
            ui.add(lens.smallest_positive(1e-3).clamping(SliderClamping::Never)).labelled_by(label.id);
            ui.end_row();
            let label =
                ui.label("focus").on_hover_text("Distance that is sharp; that of the target where none is set.");
            ui.horizontal(|ui| {
                let mut distance = camera
                    .focus
                    .unwrap_or_else(|| glam::Vec3::from(camera.position).distance(glam::Vec3::from(camera.target)));
                let speed = 0.01 * f64::from(distance.max(0.01));
                let value = DragValue::new(&mut distance).speed(speed).suffix(" m").range(1e-3..=1e6);
                if ui.add(value).labelled_by(label.id).changed() {
                    camera.focus = Some(distance);
                }
                ui.toggle_value(&mut open.view.focus_click, "by click")
                    .on_hover_text("Then click what should be sharp.");
            });
            ui.end_row();
        });
        // What is typed may be no finite number.
        for (value, before) in [
            (&mut camera.fov, before.fov),
            (&mut camera.lens_radius, before.lens_radius),
            (&mut camera.exposure, before.exposure),
        ] {
            if !value.is_finite() {
                *value = before;
            }
        }
        camera.focus = camera.focus.filter(|focus| focus.is_finite());
        camera.fov = camera.fov.clamp(0.1, 179.0);
        camera.lens_radius = camera.lens_radius.max(0.0);
        camera.exposure = camera.exposure.clamp(settings::EXPOSURE.min, settings::EXPOSURE.max);
        if *camera != before {
            open.view.touch();
        }
        let (moved, mut write, mut back) = (open.view.has_moved_away(), false, false);
        ui.horizontal(|ui| {
            ui.add_enabled_ui(moved, |ui| {
                let words = "Make the scene's camera the one that is shown.";
                write = ui.button("Write to the scene").on_hover_text(words).clicked();
                back = ui.button("Reset").on_hover_text("Back to the camera of the scene.").clicked();
            });
        });
        if back && let Some(camera) = scene.cameras.iter().find(|camera| camera.name == open.view.camera_name()) {
            open.view.look_through(camera);
        }
        if write {
            self.write_camera();
        }
    }

    /// What is shown, and how well.
    fn picture_controls(&mut self, ui: &mut Ui) {
        let Some(open) = &mut self.open else { return };
        ui.heading("Picture");
        egui::Grid::new("picture").num_columns(2).spacing([8.0, 5.0]).show(ui, |ui| {
            let label = ui.label("show").on_hover_text("Light, a quick look, or what the renderer knows.");
            ComboBox::from_id_salt("mode")
                .selected_text(open.view.mode.name())
                .show_ui(ui, |ui| {
                    for mode in Mode::ALL {
                        ui.selectable_value(&mut open.view.mode, mode, mode.name()).on_hover_text(mode.doc());
                    }
                })
                .response
                .labelled_by(label.id);
            ui.end_row();
            let label =
                ui.label("size here").on_hover_text("Of the picture in the window. Files have the size of the scene.");
            ComboBox::from_id_salt("resolution")
                .selected_text(open.view.resolution.name())
                .show_ui(ui, |ui| {
                    for resolution in Resolution::ALL {
                        ui.selectable_value(&mut open.view.resolution, resolution, resolution.name());
                    }
                })
                .response
                .labelled_by(label.id);
            ui.end_row();
            let label =
                ui.label("frame rate").on_hover_text("While something moves, the picture is as large as fits it.");
            let rate = Slider::new(&mut self.preferences.frame_rate, 5.0..=120.0).suffix(" /s").integer();
            ui.add(rate).labelled_by(label.id);
            ui.end_row();
        });
        for (kind, none) in [(ItemKind::Render, "render"), (ItemKind::Sky, "sky")] {
            let Some(open) = &self.open else { return };
            let item = open.document.outline().iter().find(|item| item.kind == kind).cloned();
            match item {
                Some(item) => {
                    let title = if kind == ItemKind::Render { "Render settings" } else { "Background" };
                    egui::CollapsingHeader::new(title).default_open(kind == ItemKind::Render).show(ui, |ui| {
                        self.controls_of(ui, &item.path);
                    });
                }
                None => self.missing(ui, none),
            }
        }
    }

    /// Offers to write a node that the scene does not have.
    fn missing(&mut self, ui: &mut Ui, word: &str) {
        let Some(open) = &self.open else { return };
        let additions = open.document.additions(None);
        let group = if word == "render" { "Render" } else { "Sky" };
        let mut chosen = None;
        ui.horizontal_wrapped(|ui| {
            ui.weak(if word == "render" { "Samples, bounces, size:" } else { "Background:" });
            for addition in additions.iter().filter(|addition| addition.group.name() == group) {
                if ui.button(format!("Add {}", addition.name)).on_hover_text(&*addition.doc).clicked() {
                    chosen = Some(addition.clone());
                }
            }
        });
        if let Some(addition) = chosen {
            let path = self.edit(|open| open.document.add(None, &addition));
            self.select(path);
        }
    }
}

/// What a node is called.
pub(super) fn heading(item: &Item) -> String {
    match &item.name {
        Some(name) => format!("{} “{name}”", item.word),
        None => item.word.clone(),
    }
}

/// One control: its name, its value, and a way back to the default.
fn row(ui: &mut Ui, path: &Path, control: &Control) -> Option<Change> {
    let words = if control.given { RichText::new(&*control.label) } else { RichText::new(&*control.label).weak() };
    let label = ui.label(words).on_hover_text(tooltip(control));
    let mut change = None;
    let typing = ui.scope_id().with(("formula", path, &*control.key));
    let numbers = numbers_of(&control.value);
    if numbers.is_some() {
        label.context_menu(|ui| {
            if ui.button("Write a formula").clicked() {
                ui.data_mut(|data| data.insert_temp(typing, true));
            }
        });
    }
    ui.horizontal(|ui| {
        if control.value == Value::None && !matches!(control.kind, ControlKind::Material(_)) {
            let button = ui.button("set").labelled_by(label.id).on_hover_text(format!("Give it a {}.", control.label));
            if button.clicked() {
                change = Some(Change::Set(control.initial.clone()));
            }
            return;
        }
        let as_text = ui.data(|data| data.get_temp::<bool>(typing)).unwrap_or(false);
        let value = match (&control.value, numbers) {
            (Value::Formulas(texts), _) => formulas(ui, path, control, texts, &label),
            (_, Some(texts)) if as_text => formulas(ui, path, control, &texts, &label),
            _ => widget(ui, path, control, &label),
        };
        if let Some(value) = value {
            ui.data_mut(|data| data.remove_temp::<bool>(typing));
            change = Some(Change::Set(value));
        }
        if control.given && !control.required {
            let back = ui.small_button("×").on_hover_text(format!("{}: back to the default.", control.label));
            if back.clicked() {
                change = Some(Change::Reset);
            }
        }
    });
    change
}

fn tooltip(control: &Control) -> String {
    let mut words = control.doc.to_string();
    if !control.unit.is_empty() {
        words += &format!(" Unit: {}.", control.unit);
    }
    words
}

/// The numbers of a value as texts.
fn numbers_of(value: &Value) -> Option<Vec<String>> {
    let texts = |numbers: &[f32]| numbers.iter().map(f32::to_string).collect();
    match value {
        Value::Number(number) => Some(texts(&[*number])),
        Value::Triple(numbers) | Value::Colour(numbers) => Some(texts(numbers)),
        Value::Size(size) => Some(size.iter().map(u32::to_string).collect()),
        _ => None,
    }
}

/// Formulas as texts, and what they are worth.
fn formulas(ui: &mut Ui, path: &Path, control: &Control, texts: &[String], label: &Response) -> Option<Value> {
    let mut new = None;
    ui.vertical(|ui| {
        for (index, now) in texts.iter().enumerate() {
            let typed = text(ui, path, &format!("{} {index}", control.key), now, label);
            if let Some(Value::Text(typed)) = typed {
                let mut texts = texts.to_vec();
                texts[index] = typed;
                new = Some(Value::Formulas(texts));
            }
        }
        if let Some(worth) = numbers_of(&control.present) {
            let unit = suffix(control.unit);
            ui.label(RichText::new(format!("= {}{unit}", worth.join(" "))).small().weak());
        }
    });
    new
}

/// The widget of a control; the value it was changed to.
fn widget(ui: &mut Ui, path: &Path, control: &Control, label: &Response) -> Option<Value> {
    match (&control.kind, &control.value) {
        (ControlKind::Number(range), Value::Number(value)) => {
            let mut value = *value;
            let soft = range.soft.0.min(value)..=range.soft.1.max(value);
            let mut slider = Slider::new(&mut value, soft).clamping(SliderClamping::Never).suffix(suffix(control.unit));
            if range.logarithmic {
                slider = slider.logarithmic(true).smallest_positive(1e-3);
            }
            slider = if range.whole { slider.integer() } else { slider.max_decimals(4) };
            let changed = ui.add(slider).labelled_by(label.id).changed();
            let least = if range.min_allowed || range.min == f32::MIN { range.min } else { range.min + 1e-4 };
            changed.then(|| Value::Number(value.clamp(least, range.max)))
        }
        (ControlKind::Triple { .. }, Value::Triple(value)) => {
            let mut value = *value;
            let changed = triple(ui, &mut value, control.unit, label);
            changed.then_some(Value::Triple(value))
        }
        (ControlKind::Colour { max }, Value::Colour(value)) => colour(ui, *value, *max, label).map(Value::Colour),
        (ControlKind::Choice(names), Value::Text(value)) => {
            let names = names.iter().map(|name| (name.to_string(), name.to_string()));
            choose(ui, &control.key, path, value, names, label).map(Value::Text)
        }
        (ControlKind::Material(names), value) => {
            let of_parent = "as what it stands in".to_owned();
            let shown = if let Value::Text(name) = value { name.as_str() } else { "" };
            let names = names.iter().map(|name| (name.clone(), name.clone()));
            let names = std::iter::once((String::new(), of_parent)).chain(names);
            let chosen = choose(ui, &control.key, path, shown, names, label)?;
            Some(if chosen.is_empty() { Value::None } else { Value::Text(chosen) })
        }
        (ControlKind::Flag, Value::Flag(value)) => {
            let mut value = *value;
            ui.checkbox(&mut value, "").labelled_by(label.id).changed().then_some(Value::Flag(value))
        }
        (ControlKind::Size { min, max }, Value::Size(value)) => {
            let mut value = *value;
            let mut changed = false;
            for side in &mut value {
                let drag = DragValue::new(side).range(*min..=*max).speed(2.0);
                changed |= ui.add(drag).labelled_by(label.id).changed();
            }
            changed.then_some(Value::Size(value))
        }
        (ControlKind::Text | ControlKind::Picture, Value::Text(value)) => text(ui, path, &control.key, value, label),
        // A value that does not fit its control: the text has a mistake there.
        _ => {
            ui.weak("see the text");
            None
        }
    }
}

fn suffix(unit: &str) -> String {
    match unit {
        "" | "count" => String::new(),
        "°" => unit.to_owned(),
        _ => format!(" {unit}"),
    }
}

fn triple(ui: &mut Ui, value: &mut [f32; 3], unit: &str, label: &Response) -> bool {
    let largest = value.iter().fold(0.0_f32, |largest, v| largest.max(v.abs()));
    let speed = if unit == "°" { 0.5 } else { f64::from(largest.clamp(0.5, 100.0)) * 0.01 };
    let mut changed = false;
    for component in value {
        let drag = DragValue::new(component).speed(speed).max_decimals(4).suffix(if unit == "°" { "°" } else { "" });
        changed |= ui.add_sized([62.0, 20.0], drag).labelled_by(label.id).changed();
    }
    changed
}

/// A colour to 1, or a radiance as a colour and its strength.
fn colour(ui: &mut Ui, value: [f32; 3], max: f32, label: &Response) -> Option<[f32; 3]> {
    let strength = value.iter().fold(0.0_f32, |largest, v| largest.max(*v));
    let bounded = max <= 1.0;
    let scale = if bounded { 1.0 } else { strength.max(1e-6) };
    let mut shown = value.map(|v| v / scale);
    let button = ui.color_edit_button_rgb(&mut shown).labelled_by(label.id);
    let mut new = button.changed().then(|| shown.map(|v| (v * scale).clamp(0.0, max)));
    if !bounded {
        let mut wanted = strength;
        let drag = DragValue::new(&mut wanted).speed(0.02 * strength.max(0.05)).range(0.0..=1e9).max_decimals(4);
        if ui.add(drag).on_hover_text("The largest of red, green and blue.").labelled_by(label.id).changed() {
            let colour = if strength > 0.0 { value.map(|v| v / strength) } else { [1.0; 3] };
            new = Some(colour.map(|v| v * wanted));
        }
    }
    let numbers = value.map(|v| format!("{}", (v * 1e3).round() / 1e3)).join(" ");
    ui.label(RichText::new(numbers).small().color(ui.visuals().weak_text_color().gamma_multiply(0.9)));
    new.map(|new| new.map(|v| (v * 1e4).round() / 1e4))
}

fn choose(
    ui: &mut Ui,
    key: &str,
    path: &Path,
    value: &str,
    names: impl Iterator<Item = (String, String)>,
    label: &Response,
) -> Option<String> {
    let mut chosen = None;
    let names: Vec<_> = names.collect();
    let shown = names.iter().find(|(name, _)| name == value).map_or(value, |(_, shown)| shown);
    ComboBox::from_id_salt((key, path))
        .selected_text(shown)
        .width(150.0)
        .show_ui(ui, |ui| {
            for (name, shown) in &names {
                if ui.selectable_label(name == value, shown).clicked() && name != value {
                    chosen = Some(name.clone());
                }
            }
        })
        .response
        .labelled_by(label.id);
    chosen
}

/// A text that counts once it is left or Enter is pressed.
fn text(ui: &mut Ui, path: &Path, key: &str, value: &str, label: &Response) -> Option<Value> {
    let id = ui.scope_id().with(("text", path, key));
    let mut typed = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| value.to_owned());
    let edit = ui.add(TextEdit::singleline(&mut typed).desired_width(150.0)).labelled_by(label.id);
    if edit.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, typed));
        return None;
    }
    ui.data_mut(|data| data.remove_temp::<String>(id));
    let cancelled = ui.input(|input| input.key_pressed(egui::Key::Escape));
    (edit.lost_focus() && !cancelled && typed != value).then_some(Value::Text(typed))
}
