//! The sky: a constant, a gradient, a picture, or a computed day.

use super::arguments::{arguments, no_children, properties, string};
use super::colours::colour;
use super::context::{Context, relative_to};
use super::numbers::is_formula;
use super::settings::{Braces, Properties};
use crate::assets::Assets;
use crate::atmosphere::Day;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::diagnostics::spelling::{listed, nearest};
use crate::language::tree::{Entry, Node, Value};
use crate::light::Light;
use crate::settings::{DAY, DAY_GROUND, GRADIENT, PICTURE, Range, Setting};
use crate::sky::Sky;

/// Contents of a `sky` node.
pub(crate) enum SkyNode {
    /// A sky that needs no more work.
    Ready(Sky),
    /// A sky that takes a while to compute, and whether its sun shines.
    Day(Day, bool),
}

impl Default for SkyNode {
    fn default() -> Self {
        Self::Ready(Sky::default())
    }
}

impl SkyNode {
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
pub(crate) fn sky(node: &Node, scene: &str, assets: &mut Assets, context: &mut Context) -> Option<SkyNode> {
    let first = node.entries.iter().find(|entry| entry.name.is_none());
    match first.map(|entry| (entry, &entry.value)) {
        Some((_, Value::Text(text))) if text == "gradient" => gradient(node, context).map(SkyNode::Ready),
        Some((_, Value::Text(text))) if text == "day" => day(node, context),
        Some((entry, Value::Text(text))) if !text.starts_with('#') && !is_formula(text, context) => {
            picture(node, entry, scene, assets, context).map(SkyNode::Ready)
        }
        _ => constant(node, context).map(|radiance| SkyNode::Ready(Sky::Constant(radiance))),
    }
}

fn constant(node: &Node, context: &mut Context) -> Option<[f32; 3]> {
    let homes = [(PICTURE, "sky \"studio.hdr\""), (DAY, "sky \"day\"")];
    let has = |table: &[Setting], word: &str| table.iter().any(|setting| setting.name == word);
    let others = |word: &str| homes.iter().any(|(table, _)| has(table, word));
    if let Some(name) = node.entries.iter().filter_map(|entry| entry.name.as_ref()).find(|name| others(&name.value)) {
        let word = &*name.value;
        let homes = homes.into_iter().filter(|(table, _)| has(table, word)).map(|(_, home)| home);
        let mistake = draft("pathmarch::unknown_property", name.span, format!("A constant sky has no `{word}`."));
        context.report.add(mistake.label("not here").help(format!("It belongs to {}.", listed(homes, "or to"))));
        return None;
    }
    colour(node, Range::NOT_NEGATIVE, context)
}

fn gradient(node: &Node, context: &mut Context) -> Option<Sky> {
    properties(node, &[], context);
    arguments(node, 1, "`sky \"gradient\" { … }`", context);
    let settings = Braces::new(node, GRADIENT, "in a gradient", context);
    let zenith = settings.colour("zenith", context);
    let horizon = settings.colour("horizon", context);
    let ground = match settings.get("ground") {
        Some(_) => settings.colour("ground", context),
        None => horizon,
    };
    Some(Sky::Gradient { zenith: zenith?, horizon: horizon?, ground: ground? })
}

fn day(node: &Node, context: &mut Context) -> Option<SkyNode> {
    arguments(node, 1, "`sky \"day\" elevation=40 azimuth=135`", context);
    let properties = Properties::new(node, DAY, context);
    let shines = properties.flag("sun", context);
    let [elevation, azimuth, haze, strength] =
        ["elevation", "azimuth", "haze", "strength"].map(|word| properties.number(word, context));
    let ground = Braces::new(node, DAY_GROUND, "in a day", context).colour("ground", context);
    let day = Day { elevation: elevation?, azimuth: azimuth?, haze: haze?, strength: strength?, ground: ground? };
    Some(SkyNode::Day(day, shines))
}

fn picture(node: &Node, entry: &Entry, scene: &str, assets: &mut Assets, context: &mut Context) -> Option<Sky> {
    let name = string(entry, "A sky", context)?;
    if name.is_empty() {
        let mistake = draft("pathmarch::empty_name", entry.value_span, "This name is empty.");
        context.report.add(mistake.label("expected the path of a .hdr or .exr file"));
        return None;
    }
    let path = relative_to(scene, name);
    if path.extension().is_none() && pathmarch_mesh::files::metadata(&path).is_err() {
        let mistake = draft("pathmarch::unknown_name", entry.value_span, format!("There is no sky {}.", shown(name)));
        let help = match nearest(name, ["gradient", "day"]) {
            Some(word) => format!("Did you mean `{word}`?"),
            None => "Expected `gradient`, `day`, the path of a .hdr or .exr file, or a colour.".to_owned(),
        };
        context.report.add(mistake.label("unknown name").help(help).expected(["gradient", "day"]));
        return None;
    }
    if context.refuses(&path, entry) {
        return None;
    }
    no_children(node, context);
    arguments(node, 1, "`sky \"studio.hdr\" strength=1 rotate=90`", context);
    let properties = Properties::new(node, PICTURE, context);
    let (strength, rotate) = (properties.number("strength", context)?, properties.number("rotate", context)?);
    match assets.picture(&path, strength, rotate) {
        Ok(loaded) => {
            let at = |code, message: String| draft(code, entry.value_span, message);
            let (width, height) = loaded.size;
            if u64::from(width) != 2 * u64::from(height) {
                let message = format!("This picture is not twice as wide as high, but {width} x {height}.");
                let help =
                    "It goes once around the sky and from pole to pole, whatever its size: it will look stretched.";
                context.report.warn(at("pathmarch::stretched_sky", message).label("stretched").help(help));
            }
            if loaded.repaired > 0 {
                let message = format!("In this picture {} were negative or not finite.", texels(loaded.repaired));
                let help = "Negative values and NaN became 0, infinite ones the largest finite value of the picture.";
                context.report.warn(at("pathmarch::bad_texels", message).label("repaired").help(help));
            }
            Some(Sky::Map(loaded.environment))
        }
        Err(error) => {
            let message = format!("The picture {} cannot be the sky.", shown(name));
            let mistake = draft("pathmarch::sky_picture", entry.value_span, message);
            context.report.add(mistake.label(error.to_string()).help(error.help()));
            None
        }
    }
}

fn texels(count: u64) -> String {
    if count == 1 { "1 texel".to_owned() } else { format!("{count} texels") }
}
