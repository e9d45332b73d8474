//! The words of the scene language, and which are nearest to a misspelt one.

use super::declared::SHAPE;
use super::fields::FIELD;
use super::include::INCLUDE;
use super::params::PARAM;
use super::report::{Report, draft, shown};
use super::schema;
use super::tree::Text;
use crate::materials;
use pathmarch_field::registry;

/// Nodes of the file.
pub(crate) const TOP: &[&str] =
    &["pathmarch", INCLUDE, PARAM, "camera", "render", "sky", "sun", "point", "material", FIELD, SHAPE, "object"];
/// Nodes in every shape and operator.
pub(crate) const PLACEMENT: &[&str] =
    &[schema::PLACEMENT[0].name, schema::PLACEMENT[1].name, schema::PLACEMENT[2].name];
/// Node in shapes that face somewhere.
pub(crate) const NORMAL: &str = schema::NORMAL.name;

/// Node in shapes that are drawn of points.
pub(crate) const POINT: &str = "point";

/// Names of all shapes and operators.
pub(crate) fn solids<'a>() -> impl Iterator<Item = &'a str> {
    registry::solids().map(|solid| &*solid.info().name)
}

/// The nearest of `known` to a misspelt name: one edit for every three letters or part of them; a swap is one edit.
pub(crate) fn nearest<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    if name.chars().nth(40).is_some() {
        return None;
    }
    let lower = name.to_lowercase();
    let allowed = name.chars().count().div_ceil(3);
    known
        .into_iter()
        .map(|word| (strsim::damerau_levenshtein(&lower, &word.to_lowercase()), word))
        .filter(|(edits, word)| *edits <= allowed && *edits < word.chars().count())
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, word)| word)
}

/// "a", "a and b", "a, b and c", each in backquotes.
pub(crate) fn listed<'k>(names: impl IntoIterator<Item = &'k str>, joint: &str) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => only.clone(),
        Some((last, others)) => format!("{} {joint} {last}", others.join(", ")),
    }
}

/// "Did you mean `…`?", or which names there are.
pub(crate) fn suggestion(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(word) => format!("Did you mean `{word}`?"),
        None if known.is_empty() => "Nothing stands here.".to_owned(),
        None => format!("Expected {}.", listed(known.iter().copied(), "or")),
    }
}

/// Where a word of this version belongs.
fn home(name: &str) -> Option<String> {
    if TOP.contains(&name) {
        return Some("It stands by itself, outside all braces.".to_owned());
    }
    if solids().any(|solid| solid == name) {
        return Some(format!("Shapes and operators stand in an object: object \"name\" {{ {name} … }}."));
    }
    if PLACEMENT.contains(&name) || name == NORMAL {
        return Some("It stands in the braces of the shape or operator that it places.".to_owned());
    }
    if materials::kind(name).is_some() {
        return Some("It stands in the braces of a `material`.".to_owned());
    }
    let nodes = [
        (schema::CAMERA, "camera"),
        (schema::RENDER, "render"),
        (schema::GRADIENT, "sky \"gradient\""),
        (schema::DAY_GROUND, "sky \"day\""),
        (schema::SUN, "sun"),
        (schema::POINT, "point"),
    ];
    let has = |table: &[schema::Setting]| table.iter().any(|setting| setting.name == name);
    let homes: Vec<&str> = nodes.into_iter().filter(|(table, _)| has(table)).map(|(_, node)| node).collect();
    (!homes.is_empty()).then(|| format!("It stands in the braces of {}.", listed(homes, "or")))
}

/// Reports a node that does not belong where it stands: misspelt or misplaced. `place` is as in
/// "in a camera".
pub(crate) fn unexpected_node(name: &Text, known: &[&str], place: &str, report: &mut Report) {
    if report.is_full() {
        // Looking for the nearest name is the one costly thing here; nobody will see it.
        return report.count();
    }
    report.add(if let Some(home) = home(&name.value) {
        let message = format!("`{}` cannot stand {place}.", name.value);
        draft("pathmarch::misplaced_node", name.span, message).label("not here").help(home)
    } else {
        draft("pathmarch::unknown_node", name.span, format!("There is no {} {place}.", shown(&name.value)))
            .label("unknown name")
            .help(suggestion(&name.value, known))
    });
}

#[cfg(test)]
mod tests {
    use super::{listed, nearest, solids};

    #[test]
    fn nearest_names() {
        for (misspelt, right) in [
            ("spere", Some("sphere")),
            ("shpere", Some("sphere")),
            ("Sphere", Some("sphere")),
            ("BOX", Some("box")),
            ("bx", Some("box")),
            ("tours", Some("torus")),
            ("substract", Some("subtract")),
            ("intersection", Some("intersect")),
            ("unoin", Some("union")),
            ("x", None),
            ("teapot", None),
            ("", None),
        ] {
            assert_eq!(nearest(misspelt, solids()), right, "{misspelt}");
        }
        assert_eq!(nearest(&"a".repeat(1000), ["a"]), None);
    }

    /// One edit away from a name, it is the nearest; unless it is another name or as near to one.
    #[test]
    fn every_name_is_found() {
        for name in solids() {
            let doubled = format!("{}{name}", &name[..1]);
            assert_eq!(nearest(&doubled, solids()), Some(name));
        }
    }

    #[test]
    fn lists() {
        assert_eq!(listed(["a", "b", "c"], "or"), "`a`, `b` or `c`");
        assert_eq!(listed(["a"], "or"), "`a`");
    }
}
