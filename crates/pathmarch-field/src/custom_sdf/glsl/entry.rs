//! The distance function of a shader, and the function around it that a field calls.

use super::items::{Argument, Item, ItemKind};
use super::lexer::{Place, fault};
use crate::custom_sdf::CodeDiagnostic;

/// Names of distance functions, the usual ones first.
const NAMES: [&str; 24] = [
    "map",
    "DE",
    "de",
    "sdf",
    "SDF",
    "sdScene",
    "sceneSDF",
    "sceneSdf",
    "sceneDist",
    "scene",
    "Map",
    "mapScene",
    "GetDist",
    "getDist",
    "getDistance",
    "distanceEstimator",
    "DistanceEstimator",
    "df",
    "dist",
    "distanceField",
    "distance_field",
    "world",
    "estimate",
    "distance",
];
/// Names of the member with the distance, in a structure.
const MEMBERS: [&str; 7] = ["d", "dist", "distance", "sd", "sdf", "t", "x"];

/// Types of parameters behind the point that may be zero.
const ZEROS: [&str; 4] = ["float", "int", "uint", "bool"];

/// Distance function.
pub(super) struct Entry {
    /// Index of its item.
    pub(super) item: usize,
    /// Expression with the distance, `p` being the point.
    pub(super) call: String,
    /// Declarations that the call needs.
    pub(super) declarations: String,
    /// True if only one of several unnamed components is used.
    pub(super) is_component: bool,
    /// True if further parameters are zero.
    pub(super) has_zeros: bool,
}

/// Finds the function of this name, or of a usual one.
pub(super) fn entry(items: &[Item], name: Option<&str>) -> Result<Entry, CodeDiagnostic> {
    let usable = |item: &Item| call(item, items).is_some();
    let named = |name: &str| {
        let same = |item: &&Item| item.name == name && matches!(item.kind, ItemKind::Function { .. });
        items.iter().filter(same).collect::<Vec<_>>()
    };
    let candidates: Vec<&Item> = match name {
        Some(name) => named(name),
        None => NAMES.iter().flat_map(|name| named(name)).collect(),
    };
    // Of overloads the one without further parameters.
    let calls = || candidates.iter().filter_map(|item| Some((item, call(item, items)?)));
    let first = calls().next().map(|(item, _)| item.name);
    let mut same = calls().filter(|(item, _)| Some(item.name) == first).collect::<Vec<_>>();
    same.sort_by_key(|(_, call)| call.has_zeros);
    let Some((item, call)) = same.into_iter().next() else {
        return Err(match candidates.first() {
            Some(item) => wrong_type(item),
            None => missing(items, name, &usable),
        });
    };
    let index = items.iter().position(|other| std::ptr::eq(other, *item)).unwrap_or_default();
    Ok(Entry { item: index, ..call })
}

/// The call of a function that takes a point and gives a distance.
fn call(item: &Item, items: &[Item]) -> Option<Entry> {
    let ItemKind::Function { result, arguments } = &item.kind else { return None };
    let (first, others) = arguments.split_first()?;
    // Further results, such as colours, are not used; further numbers, such as a time, are zero.
    let is_possible = |argument: &Argument| argument.is_output || ZEROS.contains(&argument.ty);
    if first.ty != "vec3" || first.is_only_output || !others.iter().all(is_possible) {
        return None;
    }
    let declaration = |(k, argument): (usize, &Argument)| match argument.is_output {
        true => format!("{} pm_unused_{k};\n", argument.ty),
        false => format!("{0} pm_unused_{k} = {0}(0);\n", argument.ty),
    };
    let declarations: String = others.iter().enumerate().map(declaration).collect();
    let names: String = (0..others.len()).map(|k| format!(", pm_unused_{k}")).collect();
    let member = match *result {
        "float" => String::new(),
        "vec2" | "vec3" | "vec4" => ".x".to_owned(),
        name => format!(".{}", distance_member(items.iter().find(|item| item.name == name)?)?),
    };
    let is_component = matches!(*result, "vec3" | "vec4");
    let has_zeros = others.iter().any(|argument| !argument.is_output);
    Some(Entry { item: 0, call: format!("{}(p{names}){member}", item.name), declarations, is_component, has_zeros })
}

/// Name of the member of a structure with the distance.
fn distance_member<'a>(item: &Item<'a>) -> Option<&'a str> {
    let ItemKind::Struct { members } = &item.kind else { return None };
    let floats = || members.iter().filter(|(ty, _)| *ty == "float").map(|(_, name)| *name);
    MEMBERS.iter().find_map(|name| floats().find(|member| member == name)).or(floats().next())
}

fn wrong_type(item: &Item) -> CodeDiagnostic {
    let help = "A distance function takes a point and gives a number: float map(vec3 p). It may also give a vec2 or a \
                structure with the distance first, and have `out` parameters behind the point.";
    let message = format!("`{}` is no distance function.", item.name);
    fault(item.at, message, "expected one parameter, a `vec3`", help)
}

fn missing(items: &[Item], name: Option<&str>, usable: &dyn Fn(&Item) -> bool) -> CodeDiagnostic {
    let message = match name {
        Some(name) => format!("This GLSL has no function `{name}`."),
        None => "This GLSL has no distance function.".to_owned(),
    };
    let others: Vec<String> =
        items.iter().filter(|item| usable(item)).take(8).map(|item| format!("`{}`", item.name)).collect();
    let help = match others.is_empty() {
        true => "It looks like this: float map(vec3 p) { return length(p) - 1.0; }".to_owned(),
        false => format!(
            "Functions from a point to a number are {}: name the one to use behind the code, as in entry=\"…\".",
            others.join(", ")
        ),
    };
    fault(Place::default(), message, "expected `float map(vec3 p)`", &help)
}
