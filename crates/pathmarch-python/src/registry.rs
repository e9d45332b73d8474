//! Description of the scene language for the Python part of the package, which makes functions of it.

use crate::parameters::decimal;
use pathmarch_render::pathmarch_field::registry::{modifiers, operators, shapes};
use pathmarch_render::pathmarch_field::{BlendProfile, Info, Outline, Param, Range, Unit};
use pathmarch_render::pathmarch_scene::materials::{self, MaterialKind, MaterialParam, ParamKind, Texturing, Trap};
use pathmarch_render::pathmarch_scene::settings::{self, Setting, SettingKind};
use pathmarch_render::pathmarch_scene::textures;
use pyo3::prelude::*;
use serde_json::{Map, Value, json};

/// Shapes, operators, modifiers, materials, textures and settings of the scene language, with their parameters, as
/// JSON.
#[pyfunction]
pub fn registry() -> String {
    let solid = |info: &Info, params: &[Param]| merged(description(info), json!({"params": all(params, param)}));
    json!({
        "shapes": all(shapes(), |shape| solid(shape.info(), shape.params())),
        "operators": all(operators(), |operator| {
            merged(solid(operator.info(), operator.params()), json!({"blends": operator.blends()}))
        }),
        "modifiers": all(modifiers(), |modifier| solid(modifier.info(), modifier.params())),
        "materials": all(materials::kinds(), |kind| material(kind)),
        "textures": all(textures::kinds(), |kind| {
            json!({"name": kind.name, "doc": kind.doc, "source": kind.source, "params": all(kind.params, param)})
        }),
        "picture": [param(&textures::PICTURE_SIZE)],
        "traps": Trap::ALL.map(Trap::name),
        "profiles": BlendProfile::ALL.map(|profile| json!({"name": profile.name(), "doc": profile.doc()})),
        "settings": tables(),
    })
    .to_string()
}

/// Tables of settings, by the node that contains them.
fn tables() -> Value {
    let tables: [(&str, &[Setting]); 15] = [
        ("placement", settings::PLACEMENT),
        ("normal", &[settings::NORMAL]),
        ("blend", settings::BLEND),
        ("mesh", settings::MESH),
        ("camera", settings::CAMERA),
        ("lens", settings::LENS),
        ("render", settings::RENDER),
        ("fog", settings::FOG),
        ("sun", settings::SUN),
        ("point", settings::POINT),
        ("spot", settings::SPOT),
        ("gradient", settings::GRADIENT),
        ("day", settings::DAY),
        ("day_ground", settings::DAY_GROUND),
        ("picture", settings::PICTURE),
    ];
    Value::Object(tables.iter().map(|(name, table)| ((*name).to_owned(), all(table, setting))).collect())
}

fn all<T>(items: &[T], describe: impl Fn(&T) -> Value) -> Value {
    items.iter().map(describe).collect()
}

/// Two objects as one.
fn merged(first: Value, second: Value) -> Value {
    let fields = |value| if let Value::Object(fields) = value { fields } else { Map::new() };
    Value::Object(fields(first).into_iter().chain(fields(second)).collect())
}

fn description(info: &Info) -> Value {
    let outline = info.outline.map(|outline| match outline {
        Outline::Points => "points",
        Outline::Text => "text",
        Outline::Curve => "curve",
        Outline::Path => "path",
    });
    json!({
        "name": info.name, "doc": info.doc, "source": info.source, "exact": info.exact, "size_params": info.size_params,
        "sheet": info.sheet, "facing": info.facing, "profile": info.profile, "outline": outline,
    })
}

fn param(param: &Param) -> Value {
    let default = if param.unit == Unit::Axis {
        json!(param.default_in_words().trim_matches('"'))
    } else {
        json!(decimal(param.default))
    };
    let kind = match param.unit {
        Unit::Axis => "axis",
        _ if param.is_whole() => "whole",
        _ => "number",
    };
    let unit = if kind == "whole" { "" } else { param.unit.name() };
    let about = json!({
        "name": param.name, "doc": param.doc, "kind": kind, "unit": unit, "default": default,
        "range": param.range_in_words(),
    });
    merged(about, limits(param.range))
}

/// Ends of a range; those that are not given have no limit.
fn limits(range: Range) -> Value {
    let limit = |value: f32, open: f32| if value == open { Value::Null } else { json!(decimal(value)) };
    json!({
        "min": limit(range.min, f32::MIN), "min_allowed": range.min_allowed,
        "max": limit(range.max, f32::MAX), "max_allowed": range.max_allowed,
    })
}

fn material(kind: &MaterialKind) -> Value {
    json!({
        "name": kind.name, "doc": kind.doc, "source": kind.source, "scatters": kind.bsdf.is_some() && kind.has_surface,
        "params": all(kind.params, material_param),
    })
}

fn material_param(param: &MaterialParam) -> Value {
    let textured = param.texturing != Texturing::None;
    let details = match param.kind {
        ParamKind::Flag => json!({
            "kind": "flag", "textured": textured, "default": param.spec.default > 0.0, "range": param.range_in_words(),
        }),
        ParamKind::Number if param.spec.is_whole() => json!({"kind": "whole", "textured": textured}),
        kind => json!({"kind": kind.name(), "textured": textured}),
    };
    merged(self::param(&param.spec), details)
}

fn setting(setting: &Setting) -> Value {
    let (kind, details) = kind(&setting.kind);
    let about = json!({
        "name": setting.name, "doc": setting.doc, "kind": kind, "unit": setting.unit, "required": setting.required,
        "range": setting.kind.range_in_words(),
    });
    merged(merged(about, details), limits(setting.kind.range()))
}

/// Name of a kind, and what only it has.
fn kind(kind: &SettingKind) -> (&'static str, Value) {
    match *kind {
        SettingKind::Number { default, .. } => ("number", json!({"default": default.map(decimal)})),
        SettingKind::NumberOrAuto { default, .. } => ("number", json!({"default": decimal(default)})),
        SettingKind::Whole { default, .. } => ("whole", json!({"default": default})),
        SettingKind::Size { default, .. } => ("size", json!({"default": [default.0, default.1]})),
        SettingKind::Triple { default } => ("triple", json!({"default": default.map(decimal)})),
        SettingKind::Direction { default } => ("direction", json!({"default": default.map(decimal)})),
        SettingKind::Colour { default, .. } => {
            ("colour", json!({"default": default.map(|colour| colour.map(decimal))}))
        }
        SettingKind::Choice { names, .. } => {
            let names = names();
            ("choice", json!({"default": names.first(), "choices": names}))
        }
        SettingKind::Flag { default } => ("flag", json!({"default": default})),
        SettingKind::Properties(table) => ("properties", json!({"default": null, "settings": all(table, setting)})),
    }
}
