//! Render settings that Python gives by name: those of the scene language's `render`.

use crate::names::hint;
use pathmarch_render::pathmarch_scene::RenderSettings;
use pathmarch_render::pathmarch_scene::settings::{RENDER, Setting, SettingKind, SettingValue};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Replaces settings by those of the dictionary.
///
/// # Errors
/// `TypeError` for unknown names and wrong types, `ValueError` for values out of range.
pub fn apply(render: &mut RenderSettings, given: &Bound<PyDict>) -> PyResult<()> {
    for (name, value) in given {
        let name: String = name.extract()?;
        let Some(setting) = RENDER.iter().find(|setting| setting.name == name) else { return Err(unknown(&name)) };
        let value = setting_value(setting, &value)?;
        render.set(&name, value);
    }
    Ok(())
}

fn unknown(name: &str) -> PyErr {
    let names: Vec<&str> = RENDER.iter().map(|setting| setting.name).collect();
    let message = format!("render() got an unexpected keyword argument '{name}'{}", hint(name, &names));
    PyTypeError::new_err(message)
}

fn setting_value(setting: &Setting, value: &Bound<PyAny>) -> PyResult<SettingValue> {
    let name = setting.name;
    let found = match setting.kind {
        SettingKind::Size { range, .. } => SettingValue::Size(size(name, value, range)?),
        SettingKind::Whole { range, .. } => SettingValue::Whole(whole(name, value, range)?),
        SettingKind::Choice { names, .. } => SettingValue::Choice(choice(name, value, &names())?),
        SettingKind::Number { default: None, .. } if value.is_none() => SettingValue::Absent,
        _ => SettingValue::Number(number(name, value)?),
    };
    if setting.kind.accepts(found) {
        return Ok(found);
    }
    let (range, shown) = (setting.kind.range_in_words(), shown(value));
    Err(PyValueError::new_err(format!("{name}: must be {range}, not {shown}")))
}

fn choice(name: &str, value: &Bound<PyAny>, names: &[&'static str]) -> PyResult<&'static str> {
    let asked: String = value.extract().map_err(|_| wrong_type(name, "a text", value))?;
    crate::names::find(name, &asked, names.iter().map(|name| (*name, *name)))
}

/// A whole number within a range; a number is not rounded.
pub fn whole(name: &str, value: &Bound<PyAny>, (least, most): (u32, u32)) -> PyResult<u32> {
    let found = match value.extract::<i64>() {
        Ok(number) => u32::try_from(number).ok().filter(|number| (least..=most).contains(number)),
        // Larger than an integer of this program.
        Err(error) if error.is_instance_of::<PyOverflowError>(value.py()) => None,
        Err(_) => return Err(wrong_type(name, "a whole number", value)),
    };
    found.ok_or_else(|| {
        PyValueError::new_err(format!("{name}: must be a whole number from {least} to {most}, not {}", shown(value)))
    })
}

fn number(name: &str, value: &Bound<PyAny>) -> PyResult<f32> {
    value.extract::<f64>().map(|number| number as f32).map_err(|_| wrong_type(name, "a number", value))
}

fn size(name: &str, value: &Bound<PyAny>, range: (u32, u32)) -> PyResult<(u32, u32)> {
    let sides: Vec<_> = value.try_iter().and_then(Iterator::collect).unwrap_or_default();
    let [width, height] = &sides[..] else {
        return Err(wrong_type(name, "two whole numbers of pixels, (width, height)", value));
    };
    Ok((whole(&format!("{name}: width"), width, range)?, whole(&format!("{name}: height"), height, range)?))
}

fn wrong_type(name: &str, expected: &str, value: &Bound<PyAny>) -> PyErr {
    PyTypeError::new_err(format!("{name}: expected {expected}, not {}", shown(value)))
}

fn shown(value: &Bound<PyAny>) -> String {
    let mut text = value.repr().map_or_else(|_| "this".to_owned(), |text| text.to_string());
    if let Some((end, _)) = text.char_indices().nth(60) {
        text.truncate(end);
        text.push('…');
    }
    text
}
