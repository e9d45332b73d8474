//! Outlines of drawn shapes: points of polygons, glyphs of texts.

use super::arguments::{arguments, string};
use super::context::{Context, Files, relative_to};
use super::numbers::numbers;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::POINT;
use crate::language::tree::{Entry, Node};
use crate::settings::Range;
use crate::text::{self, DEFAULT_FONT, DEFAULT_TEXT};
use pathmarch_field::outline::{Fill, MAX_CROSSINGS, contour, has_area};

/// The most points of a polygon.
const MAX_POINTS: usize = 1000;
/// Range of coordinates of points, metres, which f32 resolves.
const PLACES: Range = Range::from_to(-1e6, 1e6);

/// The segments through the points in a polygon's braces; none where there are no points.
pub(super) fn points(node: &Node, context: &mut Context) -> Vec<f32> {
    let written: Vec<&Node> = node.child_nodes().iter().filter(|child| child.name.value == POINT).collect();
    if let Some(extra) = written.get(MAX_POINTS) {
        let message = format!("`{}` has more than {MAX_POINTS} points.", node.name.value);
        context.report.add(draft("pathmarch::too_large", extra.name.span, message).label("one too many"));
        return Vec::new();
    }
    let points: Vec<Option<[f32; 2]>> =
        written.iter().map(|point| numbers(point, "`point x y`", PLACES, context)).collect();
    let Some(points) = points.into_iter().collect::<Option<Vec<_>>>() else { return Vec::new() };
    if points.is_empty() {
        return Vec::new();
    }
    if points.len() < 3 {
        let count = if points.len() == 1 { "one point".to_owned() } else { format!("{} points", points.len()) };
        let mistake = draft("pathmarch::too_few_points", node.name.span, format!("`{}` of {count}.", node.name.value));
        let help = format!("It needs at least three: {} {{ point 0 0; point 1 0; point 0.5 1 }}.", node.name.value);
        context.report.add(mistake.label("expected more points in its braces").help(help));
        return Vec::new();
    }
    let segments: Vec<f32> = contour(&points).collect();
    let Some(has_area) = has_area(&segments, Fill::EvenOdd) else {
        let message = format!("This `{}` crosses itself too often.", node.name.value);
        let mistake = draft("pathmarch::too_many_crossings", node.name.span, message);
        let mistake = mistake.label(format!("more than {MAX_CROSSINGS} crossings"));
        context.report.add(mistake.help("Put the points in their order along the outline, or use several polygons."));
        return Vec::new();
    };
    if !has_area {
        let message = format!("This `{}` has no inside.", node.name.value);
        let mistake = draft("pathmarch::no_area", node.name.span, message).label("its points lie on a line");
        context.report.add(mistake.help("Move one of them aside."));
        return Vec::new();
    }
    segments
}

/// The segments of a text for a size of one metre; none after a mistake.
pub(super) fn text(node: &Node, font: Option<&Entry>, files: &mut Files, context: &mut Context) -> Vec<f32> {
    let name = &node.name.value;
    let given = arguments(node, 1, &format!("`{name} \"Hello\" size=1 font=\"path.ttf\"`"), context).first().copied();
    let words = given.map_or(Some(DEFAULT_TEXT), |entry| string(entry, &format!("`{name}`"), context));
    let loaded = match font {
        None => None,
        Some(entry) => match font_file(entry, files, context) {
            Some(loaded) => Some(loaded),
            None => return Vec::new(),
        },
    };
    let Some(words) = words else { return Vec::new() };
    let found = text::segments(loaded.as_deref().unwrap_or(DEFAULT_FONT), words);
    found.unwrap_or_else(|error| {
        // What is wrong with the file is shown there, what is wrong with the words at these.
        let at = match (&error, font, given) {
            (text::TextError::NotAFont(_), Some(font), _) => font.value_span,
            (_, _, Some(given)) => given.value_span,
            _ => node.name.span,
        };
        let message = format!("The text {} cannot be drawn.", shown(words));
        context.report.add(draft("pathmarch::text", at, message).label(error.to_string()).help(error.help()));
        Vec::new()
    })
}

/// The bytes of the font at a path relative to the scene file.
fn font_file(entry: &Entry, files: &mut Files, context: &mut Context) -> Option<std::sync::Arc<[u8]>> {
    let name = string(entry, "`font`", context)?;
    if name.is_empty() {
        let mistake = draft("pathmarch::empty_name", entry.value_span, "This name is empty.");
        context.report.add(mistake.label("expected the path of a .ttf or .otf file"));
        return None;
    }
    let path = relative_to(files.scene, name);
    match files.assets.font(&path) {
        Ok(bytes) => Some(bytes),
        Err(reason) => {
            let message = format!("The font {} cannot be read.", shown(name));
            let mistake = draft("pathmarch::font", entry.value_span, message).label(reason);
            context.report.add(mistake.help("The path of a .ttf or .otf file, relative to the scene file."));
            None
        }
    }
}
