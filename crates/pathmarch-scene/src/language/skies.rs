//! The sky: a constant, a gradient, a picture, or a computed day.

use super::arguments::{Range, arguments, colour, is_formula, no_children, properties, string};
use super::names::{listed, nearest};
use super::report::{Report, draft, shown};
use super::schema::{Braces, DAY, DAY_GROUND, GRADIENT, PICTURE, Properties, Setting};
use super::tree::{Entry, Node, Value};
use crate::assets::Assets;
use crate::atmosphere::Day;
use crate::scene::Light;
use crate::sky::Sky;
use std::path::Path;

/// What a `sky` node says.
pub(crate) enum Described {
    /// A sky that needs no more work.
    Ready(Sky),
    /// A sky that takes a while to compute, and whether its sun shines.
    Day(Day, bool),
}

impl Default for Described {
    fn default() -> Self {
        Self::Ready(Sky::default())
    }
}

impl Described {
    /// The sky, and the sun in it.
    pub(crate) fn finish(self, assets: &mut Assets) -> (Sky, Option<Light>) {
        match self {
            Self::Ready(sky) => (sky, None),
            Self::Day(day, shines) => {
                let (environment, sun) = assets.day(&day);
                (Sky::Map(environment), sun.filter(|_| shines))
            }
        }
    }
}

/// The sky of a node; `None` after a mistake. `scene` is the path of the scene file.
pub(crate) fn sky(node: &Node, scene: &str, assets: &mut Assets, report: &mut Report) -> Option<Described> {
    let first = node.entries.iter().find(|entry| entry.name.is_none());
    match first.map(|entry| (entry, &entry.value)) {
        Some((_, Value::Text(text))) if text == "gradient" => gradient(node, report).map(Described::Ready),
        Some((_, Value::Text(text))) if text == "day" => day(node, report),
        Some((entry, Value::Text(text))) if !text.starts_with('#') && !is_formula(text, report) => {
            picture(node, entry, scene, assets, report).map(Described::Ready)
        }
        _ => constant(node, report).map(|radiance| Described::Ready(Sky::Constant(radiance))),
    }
}

fn constant(node: &Node, report: &mut Report) -> Option<[f32; 3]> {
    let homes = [(PICTURE, "sky \"studio.hdr\""), (DAY, "sky \"day\"")];
    let has = |table: &[Setting], word: &str| table.iter().any(|setting| setting.name == word);
    let others = |word: &str| homes.iter().any(|(table, _)| has(table, word));
    if let Some(name) = node.entries.iter().filter_map(|entry| entry.name.as_ref()).find(|name| others(&name.value)) {
        let word = &*name.value;
        let homes = homes.into_iter().filter(|(table, _)| has(table, word)).map(|(_, home)| home);
        let mistake = draft("pathmarch::unknown_property", name.span, format!("A constant sky has no `{word}`."));
        report.add(mistake.label("not here").help(format!("It belongs to {}.", listed(homes, "or to"))));
        return None;
    }
    colour(node, Range::NOT_NEGATIVE, report)
}

fn gradient(node: &Node, report: &mut Report) -> Option<Sky> {
    properties(node, &[], report);
    arguments(node, 1, "`sky \"gradient\" { … }`", report);
    let settings = Braces::new(node, GRADIENT, "in a gradient", report);
    let zenith = settings.colour("zenith", report);
    let horizon = settings.colour("horizon", report);
    let ground = match settings.get("ground") {
        Some(_) => settings.colour("ground", report),
        None => horizon,
    };
    Some(Sky::Gradient { zenith: zenith?, horizon: horizon?, ground: ground? })
}

fn day(node: &Node, report: &mut Report) -> Option<Described> {
    arguments(node, 1, "`sky \"day\" elevation=40 azimuth=135`", report);
    let properties = Properties::new(node, DAY, report);
    let shines = properties.flag("sun", report);
    let [elevation, azimuth, haze, strength] =
        ["elevation", "azimuth", "haze", "strength"].map(|word| properties.number(word, report));
    let ground = Braces::new(node, DAY_GROUND, "in a day", report).colour("ground", report);
    let day = Day { elevation: elevation?, azimuth: azimuth?, haze: haze?, strength: strength?, ground: ground? };
    Some(Described::Day(day, shines))
}

fn picture(node: &Node, entry: &Entry, scene: &str, assets: &mut Assets, report: &mut Report) -> Option<Sky> {
    let name = string(entry, "A sky", report)?;
    if name.is_empty() {
        let mistake = draft("pathmarch::empty_name", entry.value_span, "This name is empty.");
        report.add(mistake.label("expected the path of a .hdr or .exr file"));
        return None;
    }
    let path = Path::new(scene).parent().unwrap_or(Path::new("")).join(name);
    if path.extension().is_none() && !path.exists() {
        let mistake = draft("pathmarch::unknown_name", entry.value_span, format!("There is no sky {}.", shown(name)));
        let help = match nearest(name, ["gradient", "day"]) {
            Some(word) => format!("Did you mean `{word}`?"),
            None => "Expected `gradient`, `day`, the path of a .hdr or .exr file, or a colour.".to_owned(),
        };
        report.add(mistake.label("unknown name").help(help));
        return None;
    }
    no_children(node, report);
    arguments(node, 1, "`sky \"studio.hdr\" strength=1 rotate=90`", report);
    let properties = Properties::new(node, PICTURE, report);
    let (strength, rotate) = (properties.number("strength", report)?, properties.number("rotate", report)?);
    match assets.picture(&path, strength, rotate) {
        Ok(loaded) => {
            let at = |code, message: String| draft(code, entry.value_span, message);
            let (width, height) = loaded.size;
            if u64::from(width) != 2 * u64::from(height) {
                let message = format!("This picture is not twice as wide as high, but {width} x {height}.");
                let help =
                    "It goes once around the sky and from pole to pole, whatever its size: it will look stretched.";
                report.warn(at("pathmarch::stretched_sky", message).label("stretched").help(help));
            }
            if loaded.repaired > 0 {
                let message = format!("In this picture {} were negative or not finite.", texels(loaded.repaired));
                let help = "Negative values and NaN became 0, infinite ones the largest finite value of the picture.";
                report.warn(at("pathmarch::bad_texels", message).label("repaired").help(help));
            }
            Some(Sky::Map(loaded.environment))
        }
        Err(error) => {
            let message = format!("The picture {} cannot be the sky.", shown(name));
            let mistake = draft("pathmarch::sky_picture", entry.value_span, message);
            report.add(mistake.label(error.to_string()).help(error.help()));
            None
        }
    }
}

fn texels(count: u64) -> String {
    if count == 1 { "1 texel".to_owned() } else { format!("{count} texels") }
}
