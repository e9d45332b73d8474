//! Nodes that become others: another shape, operator, kind of material or form of sky. What the new one has, too, stays as
//! it is written.

use super::control::Value;
use super::error::EditError;
use super::key;
use super::layout::{before_spaces, bytes};
use super::number::{fresh, quoted};
use super::outline::{Found, ItemKind};
use super::patch::Patch;
use super::path::Path;
use super::slots::{Place, SKIES, Slot, child, material_control, material_kind, parameter_values, sky_form, slots};
use super::structure::title;
use super::textures::texture_node;
use super::work::Work;
use super::write::check;
use crate::language::names::{NORMAL, POINT, listed};
use crate::language::schema;
use crate::language::tree;
use crate::materials::{self, Texturing};
use pathmarch_field::Outline;
use pathmarch_field::{Param, Solid, registry};

/// Makes a node one of another kind.
pub(super) fn set_kind(work: &mut Work, path: &Path, kind: &str) -> Result<(), EditError> {
    let found = work.find(path)?;
    let name = title(found.node, found.kind);
    let unknown = |names: Vec<&str>| {
        Err(EditError::NotHere(format!("`{name}` cannot become `{kind}`. Expected {}.", listed(names, "or"))))
    };
    match found.kind {
        ItemKind::Operator => {
            if !registry::solid(kind).is_some_and(Solid::is_operator) {
                let operators = registry::solids().filter(|solid| solid.is_operator());
                return unknown(operators.map(|operator| &*operator.info().name).collect());
            }
            set_solid(work, path, kind)
        }
        ItemKind::Shape => match work.fields().solid(kind) {
            Some(Solid::Shape(_)) => set_solid(work, path, kind),
            _ => unknown(work.fields().all_shapes().map(|shape| &*shape.info().name).collect()),
        },
        ItemKind::Material => match materials::kind(kind) {
            Some(_) => set_material_kind(work, path, kind),
            None => unknown(materials::kinds().iter().map(|kind| kind.name).collect()),
        },
        ItemKind::Sky => match kind {
            "picture" => Err(EditError::NotHere("Choose a .hdr or .exr file to be the sky.".to_owned())),
            kind if SKIES.iter().any(|(name, _)| *name == kind) => {
                let form = sky_text(work, found, kind);
                set_sky(work, path, &form)
            }
            _ => unknown(SKIES.iter().map(|(name, _)| *name).collect()),
        },
        _ => Err(EditError::NotHere(format!("`{name}` is of no kind that could be changed."))),
    }
}

/// Makes a shape or an operator another one, which keeps the numbers that have the same name there and are allowed.
fn set_solid(work: &mut Work, path: &Path, kind: &str) -> Result<(), EditError> {
    let found = work.find(path)?;
    let fields = work.fields();
    let (Some(old), Some(new)) = (fields.solid(&found.node.name.value), fields.solid(kind)) else {
        return Ok(());
    };
    if *old.info().name == new.info().name {
        return Ok(());
    }
    let given = parameter_values(old, found.node);
    let kept: Vec<(&Param, Value)> = old
        .params()
        .iter()
        .zip(given)
        .filter_map(|(param, value)| {
            let value = value?;
            let same = new.params().iter().find(|other| other.name == param.name && other.unit == param.unit)?;
            let fits = !matches!(value, Value::Number(number) if !same.accepts(number));
            fits.then_some((same, value))
        })
        .collect();
    let both_blend = matches!((old, new), (Solid::Operator(a), Solid::Operator(b)) if a.blends() && b.blends());
    let stays = |entry: &&tree::Entry| {
        let named = |word: &str| entry.name.as_ref().is_some_and(|name| name.value == word);
        named("material") || both_blend && schema::BLEND.iter().any(|setting| named(setting.name))
    };
    let text = &work.text;
    let mut patches = vec![Patch::replace(bytes(found.node.name.span), kind)];
    for entry in found.node.entries.iter().filter(|entry| !stays(entry)) {
        let span = bytes(entry.span);
        patches.push(Patch::remove(before_spaces(text, span.start)..span.end));
    }
    work.then(patches)?;
    for (param, value) in kept {
        let slot = work.slot(path, &param.name)?;
        let patches = work.writer(work.find(path)?).write(&slot, &value)?;
        work.then(patches)?;
    }
    while new.info().outline != Some(Outline::Points) && child(work.find(path)?.node, POINT).is_some() {
        let patches = work.writer(work.find(path)?).erase_node(POINT)?;
        work.then(patches)?;
    }
    if !new.info().facing && child(work.find(path)?.node, NORMAL).is_some() {
        let patches = work.writer(work.find(path)?).erase_node(NORMAL)?;
        work.then(patches)?;
    }
    Ok(())
}

/// Makes a material one of another kind, which keeps the parameters that it has, too.
fn set_material_kind(work: &mut Work, path: &Path, kind: &str) -> Result<(), EditError> {
    let found = work.find(path)?;
    let name = title(found.node, found.kind);
    let Some(old) = material_kind(found.node) else {
        let patches = work.writer(found).insert(kind)?;
        work.last(patches);
        return Ok(());
    };
    let Some(new) = materials::kind(kind).filter(|new| new.name != old.name) else { return Ok(()) };
    let slots = slots(&work.file, &work.values(), found.kind, found.node);
    let fits = |param: &'static materials::MaterialParam, value: &Value| {
        let slot = Slot { control: material_control(param), place: Place::Kind };
        check(&slot, value).is_ok()
    };
    let Some(node) = child(found.node, old.name) else { return Err(EditError::Unreadable(name)) };
    let mut patches = vec![Patch::replace(bytes(node.name.span), new.name)];
    let first = slots.iter().find(|slot| slot.place == Place::Node(old.name));
    let keeps_first = match (first, new.params.first()) {
        (Some(slot), Some(param)) => fits(param, &slot.control.value),
        _ => false,
    };
    if !keeps_first {
        for entry in &node.entries {
            let span = bytes(entry.span);
            patches.push(Patch::remove(before_spaces(&work.text, span.start)..span.end));
        }
    }
    let beside = new.params.get(1..).unwrap_or_default();
    let dropped: Vec<&str> = old.params[1.min(old.params.len())..]
        .iter()
        .filter(|param| {
            let value = slots.iter().find(|slot| slot.control.key == param.name).map(|slot| &slot.control.value);
            let same = beside.iter().find(|other| other.name == param.name);
            if texture_node(found.node, param.name).is_some() {
                return same.is_none_or(|same| same.texturing == Texturing::None);
            }
            !same.zip(value).is_some_and(|(same, value)| fits(same, value))
        })
        .map(|param| param.name)
        .collect();
    let untextured = new.params.first().is_none_or(|param| param.texturing == Texturing::None);
    if let Some(block) = node.children.as_ref().filter(|_| untextured && texture_node(found.node, old.name).is_some()) {
        let span = bytes(block.span);
        patches.push(Patch::remove(before_spaces(&work.text, span.start)..span.end));
    }
    let of_surfaces = [schema::ORBIT_TRAP, schema::BUMP].into_iter().filter(|_| new.bsdf.is_none());
    let dropped: Vec<&str> = dropped.into_iter().chain(of_surfaces).collect();
    work.then(patches)?;
    for name in dropped {
        let patches = work.writer(work.find(path)?).erase_node(name)?;
        work.then(patches)?;
    }
    Ok(())
}

/// What stands behind `sky` for a sky of this form.
fn sky_text(work: &Work, found: Found, form: &str) -> String {
    let slots = slots(&work.file, &work.values(), ItemKind::Sky, found.node);
    let strength = slots.iter().find(|slot| slot.control.key == "strength" && slot.control.given);
    let strength = strength.map(|slot| format!(" strength={}", fresh(&slot.control.value)));
    match form {
        "day" => format!("\"day\"{}", strength.unwrap_or_default()),
        "gradient" => format!("\"gradient\" {{ {} }}", required(schema::GRADIENT, "; ")),
        _ => {
            let horizon = slots.iter().find(|slot| slot.control.key == "horizon").map(|slot| &slot.control.value);
            fresh(horizon.unwrap_or(&Value::Colour([0.5; 3])))
        }
    }
}

/// The settings of a table that must be given, as they are written.
pub(super) fn required(table: &'static [schema::Setting], between: &str) -> String {
    let settings: Vec<&str> = table.iter().filter(|setting| setting.required).map(|setting| setting.example).collect();
    settings.join(between)
}

fn set_sky(work: &mut Work, path: &Path, form: &str) -> Result<(), EditError> {
    let found = work.find(path)?;
    let range = bytes(found.node.name.span).end..bytes(found.node.whole).end;
    work.last(vec![Patch::replace(range, format!(" {form}"))]);
    Ok(())
}

/// Makes a sky a picture.
pub(super) fn set_picture(work: &mut Work, path: &Path, file: &str) -> Result<(), EditError> {
    if file.is_empty() {
        return Err(EditError::Name("The path of a picture must not be empty.".to_owned()));
    }
    let found = work.find(path)?;
    if sky_form(found.node) == "picture" {
        let slot = work.slot(path, key::PICTURE)?;
        let patches = work.writer(found).write(&slot, &Value::Text(file.to_owned()))?;
        work.last(patches);
        return Ok(());
    }
    set_sky(work, path, &quoted(file))
}
