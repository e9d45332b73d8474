//! The scene language, version 1: from text to [`Scene`].
//!
//! Three steps: [`syntax`] parses the text into KDL 2 nodes, [`read`](mod@read) gives the nodes meaning (materials first, so that
//! objects may use them before they are declared), and [`Field`] is built from the objects. [`checks`] then warn of what is
//! most likely not intended. Each step continues after a mistake; a text is a scene only if it has none. Reference:
//! docs/scene-language.md. Cost: linear in the text.

pub(crate) mod characters;
mod checks;
pub(crate) mod diagnostics;
pub(crate) mod formulas;
pub(crate) mod keywords;
pub(crate) mod read;
pub(crate) mod syntax;
pub(crate) mod tree;

use crate::assets::Assets;
use crate::diagnostic::{Mistake, SceneError};
use crate::light::Light;
use crate::scene::{Moment, Parameter, Scene};
use crate::sky::Sky;
use crate::source::{MAX_BYTES, read_text, too_large};
use crate::unit::LengthUnit;
use checks::{extent, warnings};
use diagnostics::foreign_code::shader_line;
use diagnostics::report::{Report, draft};
use formulas::scope::Scope;
use keywords::{FOG, TOP, UNIT};
use pathmarch_field::Field;
use read::arguments::twice;
pub(crate) use read::context::WrittenColour;
use read::context::{Context, Files, folder_of};
use read::custom_sdf::CustomSdfs;
use read::declarations::Declarations;
use read::include::Included;
use read::materials::Materials;
pub(crate) use read::objects::MAX_SHAPES;
use read::objects::Solids;
use read::unexpected::unexpected_node;
use read::version::{Version, version};
use read::{camera, fog, lights, params, render, sky, unit};
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
pub(crate) use syntax::MAX_NESTING;
use tree::{Block, Span};

/// Result of reading a text.
pub(crate) struct Read<'t> {
    /// Nodes of the text; `None` if it was refused as a whole.
    pub(crate) file: Option<Block<'t>>,
    pub(crate) scene: Result<Scene, SceneError>,
    pub(crate) values: Values,
}

/// Values and declarations of a text, as far as they could be read.
#[derive(Clone, Default)]
pub(crate) struct Values {
    /// Value of each formula, by the byte at which its string starts.
    pub(crate) formulas: HashMap<u32, f64>,
    /// Custom SDFs.
    pub(crate) fields: CustomSdfs,
    /// Colours that are written as such.
    pub(crate) colours: Vec<WrittenColour>,
    /// Nodes of included files.
    pub(crate) included: Arc<Vec<tree::Node<'static>>>,
}

/// Text of a scene and its name, for diagnostics and relative paths.
#[derive(Clone, Copy)]
struct Source<'s> {
    name: &'s str,
    text: &'s str,
}

impl Scene {
    /// Parses `text`, or returns every mistake in it. `name` is the path of the text, for diagnostics and relative paths.
    ///
    /// # Errors
    /// [`SceneError::Mistakes`] with all of them; [`SceneError::Unreadable`] for a text of more than 16 MiB.
    pub fn parse(name: &str, text: &str) -> Result<Self, SceneError> {
        Self::parse_at(name, text, Moment::default())
    }

    /// Parses `text` at a moment. For several moments of one text use [`Animation`](crate::Animation).
    ///
    /// # Errors
    /// Those of [`Scene::parse`]. Diagnostics of animated values name the moment.
    pub fn parse_at(name: &str, text: &str, moment: Moment) -> Result<Self, SceneError> {
        read(name, text, moment, &mut Assets::default()).scene
    }

    /// Loads the scene file at `path`.
    ///
    /// # Errors
    /// Those of [`Scene::parse`], and [`SceneError::Unreadable`] for a file that is missing, a directory, larger than
    /// 16 MiB, or not UTF-8.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        Self::parse(&path.display().to_string(), &read_text(path)?)
    }
}

/// Reads a text at a moment.
pub(crate) fn read<'t>(name: &str, text: &'t str, moment: Moment, assets: &mut Assets) -> Read<'t> {
    if text.len() > MAX_BYTES {
        let (reason, help) = too_large();
        let error = SceneError::Unreadable { name: name.to_owned(), reason, help };
        return Read { file: None, scene: Err(error), values: Values::default() };
    }
    let mut report = Report::new(name, text);
    if let Some(line) = shader_line(text) {
        let mistake =
            draft("pathmarch::glsl", Span::new(line.start, line.end), "This is a shader in GLSL, not a scene.");
        let help = "`pathmarch import` makes a scene of a .glsl or .frag file. In a scene, shaders are the code of a \
                    `field`: field \"name\" { bounds 4; glsl \"float map(vec3 p) { … }\" }.";
        report.add(mistake.label("GLSL").help(help));
        return Read { file: None, scene: Err(report.into_error()), values: Values::default() };
    }
    let Some(file) = syntax::read(text, &mut report) else {
        return Read { file: None, scene: Err(report.into_error()), values: Values::default() };
    };
    let (scene, values) = read_nodes(Source { name, text }, &file, moment, assets, report);
    Read { file: Some(file), scene, values }
}

/// False for a text that [`read`] refuses before it parses it.
pub(crate) fn is_read(text: &str) -> bool {
    text.len() <= MAX_BYTES && shader_line(text).is_none()
}

/// Reads the nodes of a text without mistakes of syntax: at another moment, or after an edit.
pub(crate) fn read_again(
    (name, text): (&str, &str),
    file: &Block,
    moment: Moment,
    assets: &mut Assets,
) -> (Result<Scene, SceneError>, Values) {
    read_nodes(Source { name, text }, file, moment, assets, Report::new(name, text))
}

/// Names that would be right in place of the word at byte `at`, with the mistake that lists them.
pub(crate) fn expected_at(name: &str, text: &str, at: usize, assets: &mut Assets) -> Option<Mistake> {
    let mut report = Report::new(name, text).watching(at as u32);
    let file = syntax::read(text, &mut report)?;
    let error = read_nodes(Source { name, text }, &file, Moment::default(), assets, report).0.err()?;
    let is_there = |mistake: &&Mistake| {
        let (start, length) = (mistake.span.offset(), mistake.span.len());
        mistake.source_code.name() == name && (start..start + length).contains(&at) && !mistake.expected.is_empty()
    };
    error.mistakes().iter().filter(is_there).min_by_key(|mistake| mistake.span.len()).cloned()
}

/// Parses a text into nodes; `None` if it is refused as a whole.
pub(crate) fn nodes(text: &str) -> Option<Block<'_>> {
    syntax::read(text, &mut Report::new("", ""))
}

/// Reads nodes; `report` contains the mistakes of syntax.
fn read_nodes(
    source: Source,
    file: &Block,
    moment: Moment,
    assets: &mut Assets,
    report: Report,
) -> (Result<Scene, SceneError>, Values) {
    let folder = assets.confined.then(|| folder_of(source.name));
    let mut context = Context { report, scope: Scope::at(moment), colours: Vec::new(), folder };
    let included = Included::of(source.name, source.text, file, &mut context);
    let mut fields = CustomSdfs::default();
    let scene = complete_scene(source, file, &included, assets, &mut fields, &mut context);
    let Context { report, scope, colours, .. } = context;
    let values = Values { formulas: scope.values, fields, colours, included: Arc::new(included.nodes) };
    match scene {
        Some(scene) if !report.has_mistakes() => (Ok(Scene { warnings: report.into_warnings(), ..scene }), values),
        _ => (Err(report.into_error()), values),
    }
}

/// Reads a scene with its sky and field, and checks it; `None` after a mistake.
fn complete_scene(
    source: Source,
    file: &Block,
    included: &Included,
    assets: &mut Assets,
    fields: &mut CustomSdfs,
    context: &mut Context,
) -> Option<Scene> {
    if version(file, context) == Version::Other {
        return None;
    }
    let mut all = Cow::Borrowed(file);
    if !included.nodes.is_empty() {
        all.to_mut().nodes.extend(included.nodes.iter().cloned());
    }
    let (mut scene, sky) = scene(source, file, &all, included, assets, fields, context);
    if context.report.has_mistakes() {
        return None;
    }
    let (sky, sun) = sky.finish(assets);
    scene.sky = sky;
    scene.lights.extend(sun);
    let roots: Vec<_> = scene.objects.iter().map(|object| object.root.clone()).collect();
    scene.field = Field::with_lamps(&roots, |tag| scene.materials[tag as usize].is_even_lamp());
    extent::check(&scene, &all, &mut context.report);
    warnings::warn(&scene, &all, &mut context.report);
    Some(scene)
}

/// Reads the nodes of a file and, in `all`, of the files that it includes. The field of the scene is still empty, and the
/// sky black.
fn scene(
    source: Source,
    file: &Block,
    all: &Block,
    included: &Included,
    assets: &mut Assets,
    fields: &mut CustomSdfs,
    context: &mut Context,
) -> (Scene, sky::SkyNode) {
    let of_file = |name: &'static str| file.nodes.iter().filter(move |node| node.name.value == name);
    let of_all = |name: &'static str| all.nodes.iter().filter(move |node| node.name.value == name);
    check_top(file, context);
    let params = params::declare(params::nodes(&included.nodes).chain(params::nodes(&file.nodes)), &[], &[], context);
    let mut names = HashMap::new();
    let cameras: Vec<_> = of_file("camera").filter_map(|node| camera::camera(node, &mut names, context)).collect();
    if of_file("camera").next().is_none() && !file.broken {
        report_missing_camera(file, context);
    }
    let render = of_file("render").next().map(|node| render::render(node, context));
    let sky = of_file("sky").next().and_then(|node| sky::sky(node, source.name, assets, context)).unwrap_or_default();
    let unit = of_file(UNIT).next().map(|node| unit::unit(node, context)).unwrap_or_default();
    let fog = of_file(FOG).next().and_then(|node| fog::fog(node, context)).unwrap_or_default();
    let lights = all.nodes.iter().filter_map(|node| light(node, unit, context)).collect();
    let mut materials = Materials::default();
    let mut files = Files { scene: source.name, assets };
    of_all("material").for_each(|node| materials.add(node, &mut files, context));
    *fields = CustomSdfs::new(all, assets, context);
    let mut declared = Declarations::gather(&all.nodes, fields, context);
    Solids::check(&mut materials, &mut declared, fields, (source.name, assets), context);
    let mut solids = Solids::new(&mut materials, &declared, fields, Files { scene: source.name, assets });
    let objects = of_all("object").filter_map(|node| solids.object(node, unit, context)).collect();
    let scene = Scene {
        unit,
        cameras,
        render: render.unwrap_or_default(),
        sky: Sky::default(),
        fog,
        lights,
        materials: materials.list,
        objects,
        field: Field::new(&[]),
        params: params.into_iter().map(Parameter::from).collect(),
        includes: included.files.clone(),
        moment: context.scope.moment,
        animated: context.scope.animated,
        warnings: Vec::new(),
        source_name: source.name.to_owned(),
        source_text: source.text.to_owned(),
    };
    (scene, sky)
}

/// Reports unknown nodes at the top of a file, and repeated ones that may stand there only once.
fn check_top(file: &Block, context: &mut Context) {
    for node in &file.nodes {
        if !TOP.contains(&&*node.name.value) {
            unexpected_node(&node.name, TOP, "at the top of a scene", context);
        }
    }
    for unique in ["pathmarch", UNIT, "render", "sky", FOG] {
        let mut nodes = file.nodes.iter().filter(|node| node.name.value == unique);
        let first = nodes.next();
        for again in nodes {
            let first = first.map_or(again.name.span, |first| first.name.span);
            twice(&format!("`{unique}`"), again.name.span, first, context);
        }
    }
}

fn report_missing_camera(file: &Block, context: &mut Context) {
    let span = file.nodes.first().map_or(Span::new(0, 0), |first| first.name.span);
    let mistake = draft("pathmarch::missing_node", span, "The scene has no camera.").label("expected a `camera` below");
    context.report.add(mistake.help("For example: camera { position 0 1.5 6; target 0 1 0 }."));
}

fn light(node: &tree::Node, unit: LengthUnit, context: &mut Context) -> Option<Light> {
    match &*node.name.value {
        "sun" => lights::sun(node, context),
        "point" => lights::point(node, unit, context),
        "spot" => lights::spot(node, unit, context),
        _ => None,
    }
}
