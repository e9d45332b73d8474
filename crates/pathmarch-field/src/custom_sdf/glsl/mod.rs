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
        let preprocessed = preprocess(&own_tokens).map_err(one)?;
        let mut all = items(&preprocessed.tokens).map_err(one)?;
        let own = all.len();
        let entry = entry(&all, function).map_err(one)?;
        let is_init = |item: &items::Item| item.name == "init" && preprocessed.provides_init;
        let init = all.iter().position(is_init);
        let prelude_tokens = foreign_tokens(PRELUDE);
        all.extend(
            items(&prelude_tokens).map_err(one)?.into_iter().filter(|item| !params.iter().any(|p| p == item.name)),
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
        let uniforms = order.iter().filter_map(|index| uniforms::params(&all[*index], &fragment.preset, code));
        let own_params: Vec<ShaderParam> = uniforms.flatten().collect();
        let mut names = params.to_vec();
        names.extend(own_params.iter().map(|param| param.name.clone()).filter(|name| !params.contains(name)));
        if names.len() > MAX_PARAMS {
            let message =
                format!("A field has at most {MAX_PARAMS} parameters; the uniforms of this code are {}.", names.len());
            return Err(one(fault(Place::default(), message, "too many", "Make constants of some of them.")));
        }
        let assembly = Assembly {
            items: &all,
            order: &order,
            declared: &declared,
            params: &names,
            entry: &entry,
            calls_init: init.is_some(),
        };
        let text = assembly.print().map_err(one)?;
        let mut warnings = unset::warnings(&all[..own], &order);
        warnings.extend(entry.is_component.then(|| component_warning(&all[entry.item])));
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

/// Reports code in WGSL at its first function.
fn wgsl(tokens: &[Token]) -> Option<CodeDiagnostic> {
    let is_function = |three: &&[Token]| three[0].is("fn") && three[1].is_name() && three[2].is("(");
    let found = tokens.windows(3).find(is_function)?;
    let help = "Write `wgsl` in place of `glsl` before the code.";
    Some(fault(found[0].at.to(found[1].at), "This is WGSL: use `wgsl`.", "a function of WGSL", help))
}
