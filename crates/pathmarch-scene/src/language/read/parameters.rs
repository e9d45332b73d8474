//! Parameters that shapes, operators and textures declare ([`Param`]).

use super::arguments::{arguments, string, twice};
use super::context::Context;
use super::numbers::accepted;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::{AXES, POINT};
use crate::language::tree::{Entry, Node};
use pathmarch_field::Outline;
use pathmarch_field::{Param, Solid, Unit};
use std::fmt;

/// The numbers of a shape or an operator: arguments in order, or by name; one size for several where it allows it.
pub(super) fn numbers(solid: Solid, node: &Node, named: &[(&str, &Entry)], context: &mut Context) -> Vec<f32> {
    let all = solid.params();
    let sizes = solid.info().size_params;
    // The argument of a text is its words, that of a path its notation.
    let is_text = solid.info().outline.is_some_and(Outline::has_string);
    let entries = if is_text { Vec::new() } else { arguments(node, all.len(), usage(solid), context) };
    let mut given: Vec<Option<&Entry>> = vec![None; all.len()];
    let size_named = named.iter().any(|(name, _)| all[..sizes].iter().any(|param| param.name == *name));
    let one_size = sizes > 1 && !size_named && (1..sizes).contains(&entries.len());
    // One size gives `sizes` parameters; the arguments after it are the parameters after those.
    let slots = if one_size { sizes - 1..all.len() } else { 0..all.len() };
    if one_size && entries.len() > slots.len() {
        let span = entries[0].span.to(entries[entries.len() - 1].span);
        let message = format!("`{}` has one size or {sizes}, not {}.", solid.info().name, entries.len());
        let mistake = draft("pathmarch::missing_argument", span, message).label(format!("expected {}", usage(solid)));
        context.report.add(mistake);
        return all.iter().map(|param| param.default).collect();
    }
    for (slot, entry) in slots.zip(&entries) {
        given[slot] = Some(entry);
    }
    for (name, entry) in named {
        let Some(slot) = all.iter().position(|param| param.name == *name) else { continue };
        match given[slot] {
            Some(first) => twice(&format!("`{name}`"), entry.span, first.span, context),
            None => given[slot] = Some(entry),
        }
    }
    let mut values: Vec<f32> = all
        .iter()
        .zip(given)
        .map(|(param, entry)| entry.and_then(|entry| number(param, entry, context)).unwrap_or(param.default))
        .collect();
    if one_size {
        let size = values[sizes - 1];
        values[..sizes].fill(size);
    }
    values
}

pub(super) fn number(param: &Param, entry: &Entry, context: &mut Context) -> Option<f32> {
    let what = format_args!("`{}`", param.name);
    if param.unit == Unit::Axis {
        let word = string(entry, what, context)?;
        let axis = AXES.iter().position(|axis| *axis == word);
        if axis.is_none() {
            let mistake =
                draft("pathmarch::unknown_axis", entry.value_span, format!("There is no axis {}.", shown(word)));
            context.report.add(mistake.label("unknown axis").help("Expected \"x\", \"y\" or \"z\".").expected(AXES));
        }
        return axis.map(|axis| axis as f32);
    }
    accepted(entry, what, |value| param.accepts(value), || param.range_in_words(), context)
}

/// As in "`box x y z`".
fn usage(solid: Solid) -> impl fmt::Display {
    fmt::from_fn(move |f| {
        let info = solid.info();
        match info.outline {
            Some(Outline::Points) => return write!(f, "`{} {{ {POINT} x y; … }}`", info.name),
            Some(Outline::Curve) => return write!(f, "`{} width {{ {POINT} x y; … }}`", info.name),
            _ => {}
        }
        let names: Vec<&str> =
            std::iter::once(&*info.name).chain(solid.params().iter().map(|param| &*param.name)).collect();
        write!(f, "`{}`", names.join(" "))?;
        if info.size_params > 1 {
            let one: Vec<&str> =
                [&*info.name, "size"].into_iter().chain(names[1 + info.size_params..].iter().copied()).collect();
            write!(f, " or `{}`", one.join(" "))?;
        }
        Ok(())
    })
}
