//! Changes of a node's kind: another shape, operator, kind of material or form of the sky.
//!
//! Parameters that the new kind has, too, keep their text.

use super::naming::title;
use super::transaction::Transaction;
use super::write::check::check;
use crate::document::control::Value;
use crate::document::error::EditError;
use crate::document::key;
use crate::document::parameters::{Parameter, Place, material_control, parameter_values, parameters};
use crate::document::text::layout::{before_spaces, bytes};
use crate::document::text::literals::{fresh, quoted};
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::{child, material_kind, sky_form, texture_node};
use crate::document::tree::outline::{Found, ItemKind};
use crate::document::tree::path::Path;
use crate::language::diagnostics::spelling::listed;
use crate::language::keywords::{BUMP, CORNER, DECAL, NORMAL, ORBIT_TRAP, POINT};
use crate::language::tree;
use crate::materials::{self, Texturing};
use crate::settings::{self, SKY_FORMS};
use pathmarch_field::Outline;
use pathmarch_field::{Param, Solid, registry};

/// Makes a node one of another kind.
pub(crate) fn set_kind(transaction: &mut Transaction, path: &Path, kind: &str) -> Result<(), EditError> {
    let found = transaction.find(path)?;
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
            set_solid(transaction, path, kind)
        }
        ItemKind::Shape => match transaction.fields().solid(kind) {
            Some(Solid::Shape(_)) => set_solid(transaction, path, kind),
            _ => unknown(transaction.fields().all_shapes().map(|shape| &*shape.info().name).collect()),
        },
        ItemKind::Material => match materials::kind(kind) {
            Some(_) => set_material_kind(transaction, path, kind),
            None => unknown(materials::kinds().iter().map(|kind| kind.name).collect()),
        },
        ItemKind::Sky => match kind {
            "picture" => Err(EditError::NotHere("Choose a .hdr or .exr file to be the sky.".to_owned())),
            kind if SKY_FORMS.iter().any(|(name, _)| *name == kind) => {
                let form = sky_text(transaction, found, kind);
                set_sky(transaction, path, &form)
            }
            _ => unknown(SKY_FORMS.iter().map(|(name, _)| *name).collect()),
        },
        _ => Err(EditError::NotHere(format!("`{name}` is of no kind that could be changed."))),
    }
}

/// Makes a shape or an operator another one, which keeps the numbers that have the same name there and are allowed.
fn set_solid(transaction: &mut Transaction, path: &Path, kind: &str) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    let fields = transaction.fields();
    let (Some(old), Some(new)) = (fields.solid(&found.node.name.value), fields.solid(kind)) else {
        return Ok(());
    };
    if old.info().name == new.info().name {
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
        named("material") || both_blend && settings::BLEND.iter().any(|setting| named(setting.name))
    };
    let text = &transaction.text;
    let mut patches = vec![Patch::replace(bytes(found.node.name.span), kind)];
    for entry in found.node.entries.iter().filter(|entry| !stays(entry)) {
        let span = bytes(entry.span);
        patches.push(Patch::remove(before_spaces(text, span.start)..span.end));
    }
    transaction.then(patches)?;
    for (param, value) in kept {
        let parameter = transaction.parameter(path, &param.name)?;
        let patches = transaction.writer(transaction.find(path)?).write(&parameter, &value)?;
        transaction.then(patches)?;
    }
    while !new.info().outline.is_some_and(Outline::has_points) && child(transaction.find(path)?.node, POINT).is_some() {
        let patches = transaction.writer(transaction.find(path)?).erase_node(POINT)?;
        transaction.then(patches)?;
    }
    // Every point of a polygon is a corner.
    while new.info().outline == Some(Outline::Points)
        && let Some(entry) = first_corner(transaction.find(path)?.node)
    {
        let span = bytes(entry.span);
        let patch = Patch::remove(before_spaces(&transaction.text, span.start)..span.end);
        transaction.then(vec![patch])?;
    }
    if !new.info().facing && child(transaction.find(path)?.node, NORMAL).is_some() {
        let patches = transaction.writer(transaction.find(path)?).erase_node(NORMAL)?;
        transaction.then(patches)?;
    }
    Ok(())
}

/// The first `corner=` of the points of a shape.
fn first_corner<'n>(node: &'n tree::Node<'static>) -> Option<&'n tree::Entry<'static>> {
    let points = node.child_nodes().iter().filter(|child| child.name.value == POINT);
    points.flat_map(|point| &point.entries).find(|entry| entry.name.as_ref().is_some_and(|name| name.value == CORNER))
}

/// Makes a material one of another kind, which keeps the parameters that it has, too.
fn set_material_kind(transaction: &mut Transaction, path: &Path, kind: &str) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    let name = title(found.node, found.kind);
    let Some(old) = material_kind(found.node) else {
        let patches = transaction.writer(found).insert(kind)?;
        transaction.last(patches);
        return Ok(());
    };
    let Some(new) = materials::kind(kind).filter(|new| new.name != old.name) else { return Ok(()) };
    let parameters = parameters(&transaction.file, &transaction.values(), found.kind, found.node);
    let fits = |param: &'static materials::MaterialParam, value: &Value| {
        let parameter = Parameter { control: material_control(param), place: Place::Kind };
        check(&parameter, value).is_ok()
    };
    let Some(node) = child(found.node, old.name) else { return Err(EditError::Unreadable(name)) };
    let mut patches = vec![Patch::replace(bytes(node.name.span), new.name)];
    let first = parameters.iter().find(|parameter| parameter.place == Place::Node(old.name));
    let keeps_first = match (first, new.params.first()) {
        (Some(parameter), Some(param)) => fits(param, &parameter.control.value),
        _ => false,
    };
    if !keeps_first {
        for entry in &node.entries {
            let span = bytes(entry.span);
            patches.push(Patch::remove(before_spaces(&transaction.text, span.start)..span.end));
        }
    }
    let beside = new.params.get(1..).unwrap_or_default();
    let dropped: Vec<&str> = old.params[1.min(old.params.len())..]
        .iter()
        .filter(|param| {
            let value = parameters
                .iter()
                .find(|parameter| parameter.control.key == param.name())
                .map(|parameter| &parameter.control.value);
            let same = beside.iter().find(|other| other.name() == param.name());
            if texture_node(found.node, param.name()).is_some() {
                return same.is_none_or(|same| same.texturing == Texturing::None);
            }
            !same.zip(value).is_some_and(|(same, value)| fits(same, value))
        })
        .map(|param| param.name())
        .collect();
    let untextured = new.params.first().is_none_or(|param| param.texturing == Texturing::None);
    if let Some(block) = node.children.as_ref().filter(|_| untextured && texture_node(found.node, old.name).is_some()) {
        let span = bytes(block.span);
        patches.push(Patch::remove(before_spaces(&transaction.text, span.start)..span.end));
    }
    let decals = found.node.child_nodes().iter().filter(|child| child.name.value == DECAL).count();
    let of_surfaces = [ORBIT_TRAP, BUMP].into_iter().chain(std::iter::repeat_n(DECAL, decals));
    let of_surfaces = of_surfaces.filter(|_| !new.is_shaded());
    let dropped: Vec<&str> = dropped.into_iter().chain(of_surfaces).collect();
    transaction.then(patches)?;
    for name in dropped {
        let patches = transaction.writer(transaction.find(path)?).erase_node(name)?;
        transaction.then(patches)?;
    }
    Ok(())
}

/// Text after `sky` for a sky of this form.
fn sky_text(transaction: &Transaction, found: Found, form: &str) -> String {
    let parameters = parameters(&transaction.file, &transaction.values(), ItemKind::Sky, found.node);
    let strength = parameters.iter().find(|parameter| parameter.control.key == "strength" && parameter.control.given);
    let strength = strength.map(|parameter| format!(" strength={}", fresh(&parameter.control.value)));
    match form {
        "day" => format!("\"day\"{}", strength.unwrap_or_default()),
        "gradient" => format!("\"gradient\" {{ {} }}", settings::required(settings::GRADIENT, "; ")),
        _ => {
            let horizon = parameters
                .iter()
                .find(|parameter| parameter.control.key == "horizon")
                .map(|parameter| &parameter.control.value);
            fresh(horizon.unwrap_or(&Value::Colour([0.5; 3])))
        }
    }
}

fn set_sky(transaction: &mut Transaction, path: &Path, form: &str) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    let range = bytes(found.node.name.span).end..bytes(found.node.whole).end;
    transaction.last(vec![Patch::replace(range, format!(" {form}"))]);
    Ok(())
}

/// Makes a sky a picture.
pub(crate) fn set_picture(transaction: &mut Transaction, path: &Path, file: &str) -> Result<(), EditError> {
    if file.is_empty() {
        return Err(EditError::Name("The path of a picture must not be empty.".to_owned()));
    }
    let found = transaction.find(path)?;
    if sky_form(found.node) == "picture" {
        let parameter = transaction.parameter(path, key::PICTURE)?;
        let patches = transaction.writer(found).write(&parameter, &Value::Text(file.to_owned()))?;
        transaction.last(patches);
        return Ok(());
    }
    set_sky(transaction, path, &quoted(file))
}
