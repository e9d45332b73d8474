//! Nodes that are misspelt or misplaced.

use super::context::Context;
use crate::language::diagnostics::missing_words;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::diagnostics::spelling::{listed, suggestion};
use crate::language::keywords::{COLOUR, NORMAL, PLACEMENT, TOP, solids};
use crate::language::tree::Text;
use crate::materials;
use crate::settings::{self, Setting};

/// Help for a known word in the wrong place.
fn home(name: &str) -> Option<String> {
    if TOP.contains(&name) {
        return Some("It belongs at the top of the file, outside all braces.".to_owned());
    }
    if solids().any(|solid| solid == name) {
        return Some(format!("Shapes and operators belong in an object: object \"name\" {{ {name} … }}."));
    }
    if PLACEMENT.contains(&name) || name == NORMAL {
        return Some("It belongs in the braces of the shape or operator that it places.".to_owned());
    }
    if materials::kind(name).is_some() {
        return Some("It belongs in the braces of a `material`.".to_owned());
    }
    let nodes = [
        (settings::CAMERA, "camera"),
        (settings::RENDER, "render"),
        (settings::GRADIENT, "sky \"gradient\""),
        (settings::DAY_GROUND, "sky \"day\""),
        (settings::FOG, "fog"),
        (settings::SUN, "sun"),
        (settings::POINT, "point"),
        (settings::SPOT, "spot"),
    ];
    // Colours occur in too many places for advice.
    if name == COLOUR {
        return None;
    }
    let has = |table: &[Setting]| table.iter().any(|setting| setting.name == name);
    let homes: Vec<&str> = nodes.into_iter().filter(|(table, _)| has(table)).map(|(_, node)| node).collect();
    (!homes.is_empty()).then(|| format!("It belongs in the braces of {}.", listed(homes, "or")))
}

/// Reports a misspelt or misplaced node. `place` is as in "in a camera"; an article before a vowel becomes "an".
pub(crate) fn unexpected_node(name: &Text, known: &[&str], place: &str, context: &mut Context) {
    if context.report.is_full() {
        // Looking for the nearest name is the one costly thing here; nobody will see it.
        return context.report.count();
    }
    let place = &with_article(place);
    context.report.add(if let Some(home) = home(&name.value) {
        let message = format!("`{}` is not allowed {place}.", name.value);
        draft("pathmarch::misplaced_node", name.span, message).label("not here").help(home)
    } else {
        draft("pathmarch::unknown_node", name.span, format!("There is no {} {place}.", shown(&name.value)))
            .label("unknown name")
            .expected(known.iter().copied())
            .help(missing_words::advice(&name.value).map_or_else(|| suggestion(&name.value, known), str::to_owned))
    });
}

/// The place with "an" instead of "a" before a vowel; "union" begins with none.
pub(crate) fn with_article(place: &str) -> String {
    let is_vowel = |rest: &str| rest.trim_start_matches('`').starts_with(['a', 'e', 'i', 'o']);
    match place.strip_prefix("in a ") {
        Some(rest) if is_vowel(rest) => format!("in an {rest}"),
        _ => place.to_owned(),
    }
}
