//! Distance functions in GLSL, as shaders of Shadertoy and Fragmentarium have them.
//!
//! **Idea.** naga reads GLSL, but only whole shaders that are free of mistakes, and no directives of Fragmentarium. So the code is
//! prepared first: macros are expanded (`preprocessor.rs`), the code is split into its declarations (`items.rs`), and only those
//! that the distance function needs are printed for naga (`assemble.rs`), with the place of each word in the code. Pictures,
//! lights and cameras of a shader do not matter then. What naga makes of it is a module like that of WGSL, with the same limits.
//!
//! **Sources.** The OpenGL Shading Language 4.60, sections 3 (preprocessor) and 4 (declarations).

mod assemble;
mod conditions;
mod control;
mod entry;
mod fragmentarium;
mod items;
mod lexer;
mod limits;
mod macros;
mod parse;
mod preprocessor;
mod reach;
mod rewrite;
mod text;
mod uniforms;
mod unset;

use super::{CodeDiagnostic, MAX_BYTES, MAX_PARAMS};
use assemble::Assembly;
pub(super) use assemble::{ENTRY, constant_name};
use entry::entry;
use fragmentarium::Fragment;
use items::{ItemKind, items};
use lexer::{Place, Token, fault, foreign_tokens, tokens};
pub(super) use parse::parse;
use preprocessor::preprocess;
use std::collections::{HashMap, HashSet};
use text::PlacedText;
pub use uniforms::ShaderParam;

/// What shaders take for granted.
const PRELUDE: &str = include_str!("prelude.glsl");

/// Distance function of a shader, ready for naga.
pub struct Shader {
    text: PlacedText,
    /// Parameters that the shader declares, as uniforms.
    pub params: Vec<ShaderParam>,
    /// Names of all parameters of the field: those of the scene, and then those of the shader.
    pub(super) names: Vec<String>,
    /// What the distance does not do as the shader does.
    pub warnings: Vec<CodeDiagnostic>,
    /// Values that a file of Fragmentarium opens with, by name, such as `Eye` and `Target`.
    pub preset: HashMap<String, Vec<f32>>,
    /// Name of the distance function.
    pub function: String,
}

impl Shader {
    /// Reads GLSL. `function` is the name of the distance function, `None` for a usual name; `params` are those that the scene
    /// declares.
    ///
    /// # Errors
    /// The mistakes found.
    pub fn read(code: &str, function: Option<&str>, params: &[String]) -> Result<Self, Vec<CodeDiagnostic>> {
        let one = |fault: CodeDiagnostic| vec![fault];
        if code.len() > MAX_BYTES {
            let message = format!("The text of a field has at most {} KiB.", MAX_BYTES >> 10);
            return Err(one(fault(Place::default(), message, "too long", "")));
        }
        let fragment = Fragment::new(code);
        let own_tokens = tokens(&fragment.code);
        if let Some(fault) = wgsl(&own_tokens) {
            return Err(one(fault));
        }
        let mut preprocessed = preprocess(&own_tokens).map_err(one)?;
        rewrite::name_matrices(&mut preprocessed.tokens);
        let is_in_vertex = |at: Place| fragment.vertex.contains(&(at.start as usize));
        let mut all = items(&preprocessed.tokens, !fragment.vertex.is_empty()).map_err(one)?;
        items::drop_repeated(&mut all, &is_in_vertex);
        let own = all.len();
        let entry = entry(&all, function).map_err(one)?;
        let is_init = |item: &items::Item| item.name == "init" && (preprocessed.provides_init || is_in_vertex(item.at));
        let init = all.iter().position(is_init);
        let prelude_tokens = foreign_tokens(PRELUDE);
        all.extend(
            items(&prelude_tokens, false)
                .map_err(one)?
                .into_iter()
                .filter(|item| !params.iter().any(|p| p == item.name)),
        );
        let roots: Vec<usize> = [entry.item].into_iter().chain(init).collect();
        let order = reach::needed(&all, own, &roots);
        let declared: HashSet<&str> = order.iter().map(|index| all[*index].name).chain(names(&all[..own])).collect();
        let is_known = |name: &str| declared.contains(name) || params.iter().any(|param| param == name);
        let foreign: Vec<CodeDiagnostic> =
            order.iter().flat_map(|index| reach::foreign(&all[*index], &is_known)).collect();
        if !foreign.is_empty() {
            return Err(foreign);
        }
        limits::check(&order.iter().map(|index| &all[*index]).collect::<Vec<_>>()).map_err(one)?;
        if let Some(fault) = order.iter().find_map(|index| control_fault(&all[*index])) {
            return Err(one(fault));
        }
        let mut parameters = Parameters { names: params.to_vec(), ..Parameters::default() };
        order.iter().for_each(|index| parameters.add(&all[*index], &fragment.preset, code));
        let Parameters { names, own: own_params, fixed, first_fixed } = parameters;
        let assembly = Assembly {
            items: &all,
            order: &order,
            declared: &declared,
            params: &names,
            entry: &entry,
            fixed: &fixed,
            calls_init: init.is_some(),
        };
        let text = assembly.print().map_err(one)?;
        let mut warnings = unset::warnings(&all[..own], &order);
        warnings.extend(entry.is_component.then(|| component_warning(&all[entry.item])));
        warnings.extend(entry.has_zeros.then(|| zeros_warning(&all[entry.item])));
        warnings.extend(first_fixed.map(|at| fixed_warning(at, &fixed)));
        Ok(Self {
            text,
            params: own_params,
            names,
            warnings,
            preset: fragment.preset,
            function: all[entry.item].name.to_owned(),
        })
    }
}

fn names<'i, 'a>(items: &'i [items::Item<'a>]) -> impl Iterator<Item = &'a str> + use<'i, 'a> {
    items.iter().filter(|item| !matches!(item.kind, ItemKind::Uniform { .. })).map(|item| item.name)
}

fn component_warning(item: &items::Item) -> CodeDiagnostic {
    let message = format!("`{}` gives several numbers: the first is taken as the distance.", item.name);
    fault(item.at, message, "only `.x` is used", "")
}

fn zeros_warning(item: &items::Item) -> CodeDiagnostic {
    let message = format!("`{}` has more parameters than the point: they are 0.", item.name);
    fault(item.at, message, "called with 0", "Write a function that calls it with other numbers, and name that one.")
}

fn fixed_warning(at: Place, fixed: &HashMap<&str, Vec<f32>>) -> CodeDiagnostic {
    let mut names: Vec<String> = fixed.keys().map(|name| format!("`{name}`")).collect();
    names.sort_unstable();
    let message = format!("A field has at most {MAX_PARAMS} parameters: {} are constants here.", names.join(", "));
    fault(at, message, "the first constant", "Make constants of other uniforms to get a parameter for one of these.")
}

/// Mistake in the control of a uniform.
fn control_fault(item: &items::Item) -> Option<CodeDiagnostic> {
    match &item.kind {
        ItemKind::Uniform { control: Some(Err(fault)), ty, .. } if uniforms::uniform_type(ty).is_some() => {
            Some(fault.clone())
        }
        _ => None,
    }
}

/// Parameters of a field: as many of the uniforms as it can have.
#[derive(Default)]
struct Parameters<'a> {
    names: Vec<String>,
    own: Vec<ShaderParam>,
    /// Values of the uniforms that are constants.
    fixed: HashMap<&'a str, Vec<f32>>,
    first_fixed: Option<Place>,
}

impl<'a> Parameters<'a> {
    fn add(&mut self, item: &items::Item<'a>, preset: &fragmentarium::Preset, code: &str) {
        let params = uniforms::params(item, preset, code).unwrap_or_default();
        let new = params.iter().filter(|param| !self.names.contains(&param.name));
        let new: Vec<String> = new.map(|param| param.name.clone()).collect();
        if self.names.len() + new.len() > MAX_PARAMS {
            self.fixed.insert(item.name, params.iter().map(|param| param.default).collect());
            self.first_fixed.get_or_insert(item.at);
            return;
        }
        self.names.extend(new);
        self.own.extend(params);
    }
}

/// Reports code in WGSL at its first function.
fn wgsl(tokens: &[Token]) -> Option<CodeDiagnostic> {
    let is_function = |three: &&[Token]| three[0].is("fn") && three[1].is_name() && three[2].is("(");
    let found = tokens.windows(3).find(is_function)?;
    let help = "Write `wgsl` in place of `glsl` before the code.";
    Some(fault(found[0].at.to(found[1].at), "This is WGSL: use `wgsl`.", "a function of WGSL", help))
}
