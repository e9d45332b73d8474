//! Widgets for node properties, one for each kind of control.

use egui::{ComboBox, DragValue, Response, RichText, Slider, SliderClamping, TextEdit, Ui};
use pathmarch_render::pathmarch_scene::document::{Control, ControlKind, Path, Value};

/// A change that a control requests.
pub(super) enum Change {
    Set(Value),
    Reset,
    /// Set a key at the present moment.
    Key,
}

/// One row: label, value, and a button that resets to the default.
pub(super) fn row(ui: &mut Ui, path: &Path, control: &Control) -> Option<Change> {
    let words = if control.given { RichText::new(&*control.label) } else { RichText::new(&*control.label).weak() };
    let label = ui.label(words).on_hover_text(tooltip(control));
    let mut change = None;
    let typing = ui.scope_id().with(("formula", path, &*control.key));
    let numbers = numbers_of(&control.value);
    let keyed = matches!(&control.value, Value::Formulas(texts) if texts.iter().any(|text| text.trim_start().starts_with("keys(")));
    if numbers.is_some() || keyed {
        label.context_menu(|ui| {
            if ui.button("Use a formula").clicked() {
                ui.data_mut(|data| data.insert_temp(typing, true));
            }
            let button = ui
                .button("Set a key")
                .on_hover_text("Keep this value at this frame; later changes at other frames set keys, too.");
            if button.clicked() {
                change = Some(Change::Key);
                ui.close();
            }
        });
    }
    ui.horizontal(|ui| {
        let as_text = ui.data(|data| data.get_temp::<bool>(typing)).unwrap_or(false);
        let value = match (&control.value, numbers) {
            // Numbers that are changed become keys.
            (Value::Formulas(_), _) if keyed && !as_text => {
                ui.label("◆").on_hover_text("Has keys: a change sets a key at this frame.");
                let present = Control { value: control.present.clone(), ..control.clone() };
                widget(ui, path, &present, &label)
            }
            (Value::Formulas(texts), _) => formulas(ui, path, control, texts, &label),
            (_, Some(texts)) if as_text => formulas(ui, path, control, &texts, &label),
            _ => widget(ui, path, control, &label),
        };
        if let Some(value) = value {
            ui.data_mut(|data| data.remove_temp::<bool>(typing));
            change = Some(Change::Set(value));
        }
        if control.given && !control.required {
            let back = ui.small_button("×").on_hover_text(format!("Reset {} to the default.", control.label));
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

/// Components of a numeric value as texts.
fn numbers_of(value: &Value) -> Option<Vec<String>> {
    let texts = |numbers: &[f32]| numbers.iter().map(f32::to_string).collect();
    match value {
        Value::Number(number) => Some(texts(&[*number])),
        Value::Triple(numbers) | Value::Colour(numbers) => Some(texts(numbers)),
        Value::Size(size) => Some(size.iter().map(u32::to_string).collect()),
        _ => None,
    }
}

/// Text fields of formulas, with their current value below.
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

/// Widget of a control; returns the new value if it changed.
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
            let least = if range.allowed.min_allowed || range.allowed.min == f32::MIN {
                range.allowed.min
            } else {
                range.allowed.min + 1e-4
            };
            changed.then(|| Value::Number(value.clamp(least, range.allowed.max)))
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
            let of_parent = "Inherit".to_owned();
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
        // The value does not match its control: the scene text contains an error here.
        _ => {
            ui.weak("see the source");
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

/// Colour picker; a radiance above 1 gets an extra field for its strength.
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
        if ui.add(drag).on_hover_text("Strength: the largest of red, green and blue.").labelled_by(label.id).changed() {
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

/// Text field that applies its text on Enter or when it loses the focus.
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
