//! The scene language, version 1: text to [`Scene`].
//!
//! Three steps: [`syntax`] reads the text as KDL 2 nodes, the modules beside it give the nodes meaning (materials first,
//! so that they may be used before they are declared), and [`Field`] is built of the objects. Each step goes on after
//! a mistake; a file is a scene only if none was found. Reference: docs/scene-language.md. Cost: linear in the text.

pub(crate) mod arguments;
pub(crate) mod characters;
pub(crate) mod declared;
mod drawings;
pub(crate) mod expression;
mod extent;
pub(crate) mod fields;
pub(crate) mod include;
pub(crate) mod names;
pub(crate) mod params;
mod report;
pub(crate) mod schema;
mod scope;
mod settings;
mod skies;
mod solids;
mod strings;
mod surfaces;
mod syntax;
#[cfg(test)]
mod syntax_tests;
pub(crate) mod textures;
pub(crate) mod tree;
mod warnings;

use crate::assets::Assets;
use crate::diagnostic::SceneError;
use crate::scene::{Light, Moment, Parameter, Scene};
use crate::sky::Sky;
use arguments::{Range, numbers, twice, wrong_type};
use declared::Declarations;
use drawings::Files;
use fields::Fields;
use include::Included;
use names::{TOP, unexpected_node};
use pathmarch_field::Field;
use report::{Report, draft};
use scope::Scope;
pub(crate) use solids::MAX_SHAPES;
use solids::Solids;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;
use surfaces::Materials;
pub(crate) use syntax::MAX_NESTING;
use tree::{Block, Span, Value};

/// The version of the language that this program reads.
const VERSION: f32 = 1.0;
/// Bytes; larger files are refused.
pub(crate) const MAX_BYTES: usize = 16 << 20;

/// Why a large file is refused, and what to do.
pub(crate) fn too_large() -> (String, String) {
    (format!("it is larger than {} MiB", MAX_BYTES >> 20), "Leave parts of the scene out.".to_owned())
}

/// The scene of `text`, which came from `name`, at a moment.
pub(crate) fn parse(name: &str, text: &str, moment: Moment) -> Result<Scene, SceneError> {
    read(name, text, moment, &mut Assets::default()).scene
}

/// What a text was read as.
pub(crate) struct Read<'t> {
    /// Its nodes, as far as they could be read.
    pub(crate) file: Option<Block<'t>>,
    pub(crate) scene: Result<Scene, SceneError>,
    /// What it declares and computes.
    pub(crate) values: Values,
}

/// What a text declares and computes, as far as it could be read.
#[derive(Clone, Default)]
pub(crate) struct Values {
    /// The value of each formula, by the byte where its string begins.
    pub(crate) formulas: HashMap<u32, f64>,
    /// Its own shapes.
    pub(crate) fields: Fields,
    /// What it includes from other files.
    pub(crate) included: Arc<Vec<tree::Node<'static>>>,
}

/// Reads a text, which came from `name`, as of a moment.
pub(crate) fn read<'t>(name: &str, text: &'t str, moment: Moment, assets: &mut Assets) -> Read<'t> {
    if text.len() > MAX_BYTES {
        let (reason, help) = too_large();
        let error = SceneError::Unreadable { name: name.to_owned(), reason, help };
        return Read { file: None, scene: Err(error), values: Values::default() };
    }
    let mut report = Report::new(name, text);
    let Some(file) = syntax::read(text, &mut report) else {
        return Read { file: None, scene: Err(report.into_error()), values: Values::default() };
    };
    let (scene, values) = scene_of((name, text), &file, moment, assets, report);
    Read { file: Some(file), scene, values }
}

/// Reads the nodes of a text that is in form as of a moment.
pub(crate) fn read_again(
    source: (&str, &str),
    file: &Block,
    moment: Moment,
    assets: &mut Assets,
) -> (Result<Scene, SceneError>, Values) {
    scene_of(source, file, moment, assets, Report::new(source.0, source.1))
}

/// Name and text, nodes, and the mistakes so far, to a scene.
fn scene_of(
    (name, text): (&str, &str),
    file: &Block,
    moment: Moment,
    assets: &mut Assets,
    mut report: Report,
) -> (Result<Scene, SceneError>, Values) {
    report.scope = Scope::at(moment);
    let included = Included::of(name, text, file, &mut report);
    let mut fields = Fields::default();
    let scene = meaning(name, text, file, &included, assets, &mut fields, &mut report);
    let formulas = std::mem::take(&mut report.scope.values);
    let values = Values { formulas, fields, included: Arc::new(included.nodes) };
    match scene {
        Some(scene) if !report.has_mistakes() => (Ok(Scene { warnings: report.into_warnings(), ..scene }), values),
        _ => (Err(report.into_error()), values),
    }
}

/// The nodes of `text`, as far as they could be read.
pub(crate) fn nodes(text: &str) -> Option<Block<'_>> {
    syntax::read(text, &mut Report::new("", ""))
}

/// The scene of the nodes of `text`; nothing after a mistake.
fn meaning(
    name: &str,
    text: &str,
    file: &Block,
    included: &Included,
    assets: &mut Assets,
    fields: &mut Fields,
    report: &mut Report,
) -> Option<Scene> {
    if version(file, report) == Version::Other {
        return None;
    }
    let mut all = Cow::Borrowed(file);
    if !included.nodes.is_empty() {
        all.to_mut().nodes.extend(included.nodes.iter().cloned());
    }
    let (mut scene, sky) = scene((name, text), file, &all, included, assets, fields, report);
    if report.has_mistakes() {
        return None;
    }
    let (sky, sun) = sky.finish(assets);
    scene.sky = sky;
    scene.lights.extend(sun);
    let roots: Vec<_> = scene.objects.iter().map(|object| object.root.clone()).collect();
    scene.field = Field::new(&roots);
    extent::check(&scene, &all, report);
    warnings::warn(&scene, &all, report);
    Some(scene)
}

#[derive(PartialEq)]
enum Version {
    /// Ours, or missing: worth reading on.
    This,
    /// Another, whose words we do not know.
    Other,
}

/// Checks the first node of the file.
fn version(file: &Block, report: &mut Report) -> Version {
    let Some(first) = file.nodes.first().filter(|first| first.name.value == "pathmarch") else {
        if !file.broken || file.nodes.iter().any(|node| node.name.value == "pathmarch") {
            let later = file.nodes.iter().find(|node| node.name.value == "pathmarch");
            let span = file.nodes.first().map_or(Span::new(0, 0), |first| first.name.span);
            let mistake = draft("pathmarch::version", span, "A scene starts with its version.");
            let mistake = mistake.label("expected `pathmarch 1` before it");
            report.add(match later {
                Some(later) => mistake.also(later.name.span, "move this to the top of the file"),
                None => mistake.help("Write `pathmarch 1` on the first line."),
            });
        }
        return Version::This;
    };
    if let Some(entry) = first.entries.iter().find(|entry| matches!(entry.value, Value::Text(_))) {
        wrong_type(entry, "The version", "a number", report);
        return Version::This;
    }
    let Some([given]) = numbers::<1>(first, "`pathmarch 1`", Range::ANY, report) else { return Version::This };
    if given == VERSION {
        return Version::This;
    }
    let span = first.entries[0].value_span;
    if given > VERSION && given.fract() == 0.0 {
        let message = format!("This scene is written in version {given} of the language.");
        let mistake = draft("pathmarch::version", span, message).label(format!("this program reads version {VERSION}"));
        report.add(mistake.help("Use a newer pathmarch."));
        return Version::Other;
    }
    let message = format!("There is no version {given} of the language.");
    report.add(draft("pathmarch::version", span, message).label("expected 1"));
    Version::This
}

/// What the nodes of the file, and those of `all` with what it includes, say; the field is still empty, and the sky black.
fn scene(
    (name, text): (&str, &str),
    file: &Block,
    all: &Block,
    included: &Included,
    assets: &mut Assets,
    fields: &mut Fields,
    report: &mut Report,
) -> (Scene, skies::Described) {
    let nodes = |name: &'static str| file.nodes.iter().filter(move |node| node.name.value == name);
    let of_all = |name: &'static str| all.nodes.iter().filter(move |node| node.name.value == name);
    for node in &file.nodes {
        if !TOP.contains(&&*node.name.value) {
            unexpected_node(&node.name, TOP, "at the top of a scene", report);
        }
    }
    for unique in ["pathmarch", "render", "sky"] {
        let mut all = nodes(unique);
        let first = all.next();
        for again in all {
            let first = first.map_or(again.name.span, |first| first.name.span);
            twice(&format!("`{unique}`"), again.name.span, first, report);
        }
    }
    let params = params::declare(params::nodes(&included.nodes).chain(params::nodes(&file.nodes)), &[], &[], report);
    let mut names = HashMap::new();
    let cameras: Vec<_> = nodes("camera").filter_map(|node| settings::camera(node, &mut names, report)).collect();
    if nodes("camera").next().is_none() && !file.broken {
        let span = file.nodes.first().map_or(Span::new(0, 0), |first| first.name.span);
        let mistake =
            draft("pathmarch::missing_node", span, "The scene has no camera.").label("expected a `camera` below");
        report.add(mistake.help("For example: camera { position 0 1.5 6; target 0 1 0 }."));
    }
    let render = nodes("render").next().and_then(|node| settings::render(node, report));
    let sky = nodes("sky").next().and_then(|node| skies::sky(node, name, assets, report)).unwrap_or_default();
    let lights: Vec<Light> = all
        .nodes
        .iter()
        .filter_map(|node| match &*node.name.value {
            "sun" => settings::sun(node, report),
            "point" => settings::point(node, report),
            _ => None,
        })
        .collect();
    let mut materials = Materials::default();
    let mut files = textures::Files { scene: name, assets };
    of_all("material").for_each(|node| materials.add(node, &mut files, report));
    *fields = Fields::new(all, assets, report);
    let mut declared = Declarations::gather(&all.nodes, fields, report);
    Solids::check(&mut materials, &mut declared, fields, (name, assets), report);
    let mut solids = Solids::new(&mut materials, &declared, fields, Files { scene: name, assets });
    let objects = of_all("object").filter_map(|node| solids.object(node, report)).collect();
    let scene = Scene {
        cameras,
        render: render.unwrap_or_default(),
        sky: Sky::default(),
        lights,
        materials: materials.list,
        objects,
        field: Field::new(&[]),
        params: params.into_iter().map(Parameter::from).collect(),
        includes: included.files.clone(),
        moment: report.scope.moment,
        animated: report.scope.animated,
        warnings: Vec::new(),
        source_name: name.to_owned(),
        source_text: text.to_owned(),
    };
    (scene, sky)
}
