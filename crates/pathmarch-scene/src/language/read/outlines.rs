//! Outlines of drawn shapes: points of polygons and curves, paths, glyphs of texts.

use super::arguments::{arguments, flag, missing_arguments, no_children, properties, string};
use super::context::{Context, Files, relative_to};
use super::numbers::{in_range, numbers};
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::{CORNER, POINT};
use crate::language::tree::{Entry, Node};
use crate::settings::Range;
use crate::svg_path;
use crate::text::{self, DEFAULT_FONT, DEFAULT_TEXT};
use pathmarch_field::outline::{self, Fill, MAX_CROSSINGS, SplinePoint, contour, curve_has_area, has_area};

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
        too_few(node, points.len(), "three", "{ point 0 0; point 1 0; point 0.5 1 }", context);
        return Vec::new();
    }
    let segments: Vec<f32> = contour(&points).collect();
    if encloses(has_area(&segments, Fill::EvenOdd), node, context) { segments } else { Vec::new() }
}

fn too_few(node: &Node, count: usize, least: &str, example: &str, context: &mut Context) {
    let count = if count == 1 { "one point".to_owned() } else { format!("{count} points") };
    let mistake = draft("pathmarch::too_few_points", node.name.span, format!("`{}` of {count}.", node.name.value));
    let help = format!("It needs at least {least}: {} {example}.", node.name.value);
    context.report.add(mistake.label("expected more points in its braces").help(help));
}

/// Reports outlines without an inside, and those that cross themselves too often.
fn encloses(has_area: Option<bool>, node: &Node, context: &mut Context) -> bool {
    let name = &node.name.value;
    match has_area {
        None => {
            let message = format!("This `{name}` crosses itself too often.");
            let mistake = draft("pathmarch::too_many_crossings", node.name.span, message);
            let mistake = mistake.label(format!("more than {MAX_CROSSINGS} crossings"));
            let help = format!("Put the points in their order along the outline, or use several of `{name}`.");
            let help = if name == "polygon" {
                "Put the points in their order along the outline, or use several polygons.".to_owned()
            } else {
                help
            };
            context.report.add(mistake.help(help));
        }
        Some(false) => {
            let message = format!("This `{name}` has no inside.");
            let mistake = draft("pathmarch::no_area", node.name.span, message).label("its points lie on a line");
            let line = if name == "polygon" { "" } else { " Or draw it as a line with `width=0.02`." };
            context.report.add(mistake.help(format!("Move one of them aside.{line}")));
        }
        Some(true) => return true,
    }
    false
}

/// The arcs of a smooth curve through the points in its braces, closed if it is filled; none where there are no points.
pub(super) fn curve(node: &Node, width: f32, context: &mut Context) -> Vec<f32> {
    let written: Vec<&Node> = node.child_nodes().iter().filter(|child| child.name.value == POINT).collect();
    if let Some(extra) = written.get(MAX_POINTS) {
        let message = format!("`{}` has more than {MAX_POINTS} points.", node.name.value);
        context.report.add(draft("pathmarch::too_large", extra.name.span, message).label("one too many"));
        return Vec::new();
    }
    let points: Vec<Option<SplinePoint>> = written.iter().map(|point| spline_point(point, context)).collect();
    let Some(points) = points.into_iter().collect::<Option<Vec<_>>>() else { return Vec::new() };
    if points.is_empty() {
        return Vec::new();
    }
    let filled = width <= 0.0;
    if points.len() < if filled { 3 } else { 2 } {
        let least = if filled { "three" } else { "two" };
        too_few(node, points.len(), least, "{ point 0 0; point 1 0; point 0.5 1 }", context);
        return Vec::new();
    }
    // A line that returns to its first point is closed.
    let closed = filled || points.len() > 3 && points[0].at == points[points.len() - 1].at;
    let curves = outline::through(&points, closed);
    arcs(&curves, width, Fill::EvenOdd, node, context)
}

fn spline_point(node: &Node, context: &mut Context) -> Option<SplinePoint> {
    let usage = "`point x y` or `point x y corner=#true`";
    let named = properties(node, &[CORNER], context);
    no_children(node, context);
    let corner = named.first().map(|(_, entry)| flag(entry, "`corner`", context));
    let entries = arguments(node, 2, usage, context);
    let values: Vec<_> = entries.iter().map(|entry| in_range(entry, "`point`", PLACES, context)).collect();
    let [x, y] = values[..] else {
        missing_arguments(node, usage, context);
        return None;
    };
    Some(SplinePoint { at: [x?, y?], is_corner: corner.unwrap_or(Some(false))? })
}

/// The arcs of a path; none after a mistake.
pub(super) fn path(node: &Node, width: f32, context: &mut Context) -> Vec<f32> {
    let name = &node.name.value;
    let Some(given) =
        arguments(node, 1, format_args!("`{name} \"M 0 0 L 1 0 …\" width=0.02`"), context).first().copied()
    else {
        return Vec::new();
    };
    let Some(words) = string(given, format_args!("`{name}`"), context) else { return Vec::new() };
    match svg_path::curves(words, width <= 0.0) {
        Ok(curves) if curves.iter().flat_map(|curve| curve.0).flatten().all(|v| PLACES.accepts(v)) => {
            arcs(&curves, width, Fill::NonZero, node, context)
        }
        Ok(_) => {
            let mistake = draft("pathmarch::out_of_range", given.value_span, "This path has too large numbers.");
            context.report.add(mistake.label(format!("coordinates must be {}", PLACES.in_words())));
            Vec::new()
        }
        Err(error) => {
            let mistake = draft("pathmarch::path", given.value_span, "This path cannot be read.");
            let help = "Copy the attribute `d` of a <path> of an SVG file: M, L, H, V, C, S, Q, T, A and Z.";
            context.report.add(mistake.label(error).help(help));
            Vec::new()
        }
    }
}

/// The arcs of curves, if they enclose an area or are drawn as a line.
fn arcs(curves: &[outline::Cubic], width: f32, fill: Fill, node: &Node, context: &mut Context) -> Vec<f32> {
    // Each curve has at least an arc; the scene counts the others.
    let arcs = outline::arcs(&curves[..curves.len().min(outline::MAX_SEGMENTS + 1)]);
    if arcs.is_empty() {
        let message = format!("This `{}` has no length.", node.name.value);
        context.report.add(draft("pathmarch::no_area", node.name.span, message).label("its points are one point"));
        return arcs;
    }
    if arcs.len() / outline::NUMBERS_OF_ARC > outline::MAX_SEGMENTS {
        // Too large to look for crossings; reported with all outlines of the scene.
        return arcs;
    }
    if width > 0.0 || encloses(curve_has_area(&arcs, fill), node, context) { arcs } else { Vec::new() }
}

/// The segments of a text for a size of one metre; none after a mistake.
pub(super) fn text(node: &Node, font: Option<&Entry>, files: &mut Files, context: &mut Context) -> Vec<f32> {
    let name = &node.name.value;
    let given =
        arguments(node, 1, format_args!("`{name} \"Hello\" size=1 font=\"path.ttf\"`"), context).first().copied();
    let words = given.map_or(Some(DEFAULT_TEXT), |entry| string(entry, format_args!("`{name}`"), context));
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
    if context.refuses(&path, entry) {
        return None;
    }
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
