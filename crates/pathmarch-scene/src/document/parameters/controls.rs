//! Controls for the specifications of settings, of parameters of shapes and of parameters of materials.

use crate::document::control::{Control, ControlKind, NumberRange, Value};
use crate::language::keywords::AXES;
use crate::materials::{MaterialParam, ParamKind};
use crate::settings::{Range, Setting, SettingKind};
use pathmarch_field::{Param, Unit};
use std::borrow::Cow;

/// Control of a setting; `None` for a node whose properties are settings.
pub(super) fn setting_control(key: Cow<'static, str>, setting: &Setting) -> Option<Control> {
    let (kind, default) = match setting.kind {
        SettingKind::Number { range, default } => {
            let kind = ControlKind::Number(number_range(range, false, setting.unit, default));
            (kind, default.map_or(Value::None, Value::Number))
        }
        SettingKind::NumberOrAuto { range, default } => {
            let kind = ControlKind::Number(number_range(range, false, setting.unit, Some(default)));
            (kind, Value::Number(default))
        }
        SettingKind::Whole { range: (min, max), default } => {
            let range = Range::from_to(min as f32, max as f32);
            let default = default as f32;
            (ControlKind::Number(number_range(range, true, setting.unit, Some(default))), Value::Number(default))
        }
        SettingKind::Size { range: (min, max), default } => {
            (ControlKind::Size { min, max }, Value::Size(default.into()))
        }
        SettingKind::Triple { default } => (ControlKind::Triple { direction: false }, Value::Triple(default)),
        SettingKind::Direction { default } => (ControlKind::Triple { direction: true }, Value::Triple(default)),
        SettingKind::Colour { max, default } => {
            (ControlKind::Colour { max }, default.map_or(Value::None, Value::Colour))
        }
        SettingKind::Choice { names, .. } => {
            let names: Vec<Cow<str>> = names().into_iter().map(Cow::Borrowed).collect();
            let first = Value::Text(names[0].to_string());
            (ControlKind::Choice(names), first)
        }
        SettingKind::Flag { default } => (ControlKind::Flag, Value::Flag(default)),
        SettingKind::Properties(_) => return None,
    };
    let mut control = Control::new(key, setting.label, setting.doc, kind, default);
    (control.unit, control.required) = (setting.unit, setting.required);
    if control.default == Value::None {
        control.initial = example_value(setting, &control.kind);
    }
    Some(control)
}

/// Value of a setting's example, for a setting without default.
fn example_value(setting: &Setting, kind: &ControlKind) -> Value {
    let numbers: Vec<f32> = setting.example.split([' ', '=']).skip(1).filter_map(|word| word.parse().ok()).collect();
    match (kind, &numbers[..]) {
        (ControlKind::Number(_), [number, ..]) => Value::Number(*number),
        (ControlKind::Colour { .. }, [r, g, b]) => Value::Colour([*r, *g, *b]),
        _ => Value::None,
    }
}

/// Number of a parameter as the value of its control.
pub(crate) fn parameter_value(param: &Param, value: f32) -> Value {
    match param.unit {
        Unit::Axis => Value::Text(AXES.get(value as usize).copied().unwrap_or_default().to_owned()),
        _ => Value::Number(value),
    }
}

/// Control of a parameter of a shape, an operator or a texture.
pub(super) fn parameter_control(param: &Param) -> Control {
    let default = parameter_value(param, param.default);
    if param.unit == Unit::Axis {
        let kind = ControlKind::Choice(AXES.map(Cow::Borrowed).to_vec());
        return Control::new(param.name.clone(), param.name.clone(), param.doc.clone(), kind, default);
    }
    let unit = if param.unit == Unit::Count { "" } else { param.unit.name() };
    let range = number_range(param.range, param.unit == Unit::Count, unit, Some(param.default));
    let control =
        Control::new(param.name.clone(), param.name.clone(), param.doc.clone(), ControlKind::Number(range), default);
    Control { unit, ..control }
}

/// Control of a parameter of a material.
pub(crate) fn material_control(param: &MaterialParam) -> Control {
    let spec = &param.spec;
    let (kind, default) = match param.kind {
        ParamKind::Colour => (ControlKind::Colour { max: spec.range.max }, Value::Colour(param.default_value())),
        ParamKind::Number => {
            let range = number_range(spec.range, spec.is_whole(), "", Some(spec.default));
            (ControlKind::Number(range), Value::Number(spec.default))
        }
        ParamKind::Flag => (ControlKind::Flag, Value::Flag(spec.default > 0.0)),
    };
    Control::new(spec.name.clone(), spec.name.clone(), spec.doc.clone(), kind, default)
}

/// Range of a control, with ends of its slider that suit the default.
pub(super) fn number_range(range: Range, whole: bool, unit: &str, default: Option<f32>) -> NumberRange {
    let Range { min, min_allowed, max, max_allowed } = range;
    let size = default.unwrap_or(1.0).abs();
    let endless = max - min > 1e4;
    let logarithmic = min >= 0.0 && endless;
    let low = match (logarithmic, min > f32::MIN) {
        _ if unit == "°" && min == f32::MIN => -360.0,
        (true, _) if min_allowed => min,
        (true, _) => (0.01 * size).max(0.001),
        (false, true) if min_allowed => min,
        (false, true) => min + 0.01 * (max - min),
        (false, false) => -10.0_f32.max(4.0 * size),
    };
    let high = match max < f32::MAX && !endless {
        _ if unit == "°" && max == f32::MAX => 360.0,
        true if max_allowed => max,
        true => max - 0.01 * (max - min),
        false if whole => (16.0 * size.max(1.0)).min(max),
        false => 10.0_f32.max(4.0 * size),
    };
    NumberRange { allowed: range, whole, soft: (low, high), logarithmic }
}
