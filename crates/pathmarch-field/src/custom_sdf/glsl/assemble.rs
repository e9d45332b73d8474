//! Text of the declarations that a field needs, as naga accepts it.
//!
//! Parameters are specialisation constants, as those of WGSL are overrides. A uniform that is no `float` is a variable that
//! the function `pm_distance` sets from them. It also sets the variables outside functions, because naga drops their values
//! unless they are constant.

use super::entry::Entry;
use super::items::{Item, ItemKind};
use super::lexer::{Kind, Place, Token, fault};
use super::reach::replaced;
use super::rewrite::{element_count, elements, rewritten};
use super::text::PlacedText;
use super::uniforms::{param_names, uniform_type};
use crate::custom_sdf::CodeDiagnostic;
use std::collections::{HashMap, HashSet};

/// Name of the function that a field calls.
pub(in crate::custom_sdf) const ENTRY: &str = "pm_distance";

/// Name of the constant of a parameter.
pub(in crate::custom_sdf) fn constant_name(param: &str) -> String {
    format!("pm_{param}")
}

/// Declarations to print.
pub(super) struct Assembly<'i, 'a> {
    pub(super) items: &'i [Item<'a>],
    /// Indices of the items, in order.
    pub(super) order: &'i [usize],
    /// Names that the code declares.
    pub(super) declared: &'i HashSet<&'a str>,
    /// Parameters of the field, those of the code included.
    pub(super) params: &'i [String],
    pub(super) entry: &'i Entry,
    /// Components of the uniforms that are no parameters, by name.
    pub(super) fixed: &'i HashMap<&'a str, Vec<f32>>,
    /// True if a function `init` runs first.
    pub(super) calls_init: bool,
}

impl Assembly<'_, '_> {
    /// Prints the code.
    pub(super) fn print(&self) -> Result<PlacedText, CodeDiagnostic> {
        let mut text = PlacedText::default();
        for (k, param) in self.params.iter().enumerate() {
            let name = constant_name(param);
            text.add(&format!("layout(constant_id = {k}) const float {name} = 0.0;\n"), Place::default());
            if !self.declared.contains(&**param) && self.is_used(param) {
                // A local variable of the same name hides it, as in the code.
                text.add(&format!("float {param};\n"), Place::default());
            }
        }
        // Values that only a call can set.
        let mut start = PlacedText::default();
        for param in self.params.iter().filter(|param| !self.declared.contains(&***param) && self.is_used(param)) {
            start.add(&format!("{param} = {};\n", constant_name(param)), Place::default());
        }
        let mut changing: HashSet<&str> = self.params.iter().map(String::as_str).collect();
        for &index in self.order {
            let item = &self.items[index];
            match &item.kind {
                ItemKind::Function { result, .. } => self.function(item, result, &mut text),
                ItemKind::Struct { .. } => {
                    text.tokens(&item.tokens);
                    text.add(";\n", item.at);
                }
                ItemKind::Variable { is_const, ty, sizes, value } => {
                    let is_const = *is_const && is_plain(ty, value, &changing);
                    let mut printed: Vec<Token> = value.clone();
                    self.replace(&mut printed);
                    if is_const {
                        text.add("const ", item.at);
                    } else {
                        changing.insert(item.name);
                    }
                    sized(ty, value, &mut text);
                    text.add(item.name, item.at);
                    sized(sizes, value, &mut text);
                    let target = if is_const { &mut text } else { &mut start };
                    if !value.is_empty() {
                        target.add(if is_const { "" } else { item.name }, item.at);
                        target.add(" = ", item.at);
                        counted(&printed, target);
                        target.add(if is_const { "" } else { ";\n" }, item.at);
                    }
                    text.add(";\n", item.at);
                }
                ItemKind::Uniform { ty, .. } => {
                    changing.insert(item.name);
                    self.uniform(item, ty, &mut text, &mut start)?;
                }
            }
        }
        self.entry(&start, &mut text);
        Ok(text)
    }

    /// Names of all members of structures.
    fn members(&self) -> Vec<&str> {
        let of_item = |index: &usize| match &self.items[*index].kind {
            ItemKind::Struct { members } => members.iter().map(|(_, name)| *name).collect(),
            _ => Vec::new(),
        };
        self.order.iter().flat_map(of_item).collect()
    }

    fn is_used(&self, param: &str) -> bool {
        let mut references = self.order.iter().flat_map(|index| self.items[*index].references());
        references.any(|token| token.text == param)
    }

    fn entry(&self, start: &PlacedText, text: &mut PlacedText) {
        text.add(&format!("float {ENTRY}(vec3 p) {{\n"), Place::default());
        text.append(start);
        if self.calls_init {
            text.add("init();\n", Place::default());
        }
        let Entry { declarations, call, item, .. } = self.entry;
        text.add(declarations, self.items[*item].at);
        text.add(&format!("return {call};\n}}\nvoid main() {{}}\n"), self.items[*item].at);
    }

    /// Replaces the names of functions that WGSL lacks.
    fn replace<'t>(&self, tokens: &mut [Token<'t>])
    where
        Self: 't,
    {
        for k in 0..tokens.len() {
            if tokens[k].is_name() && (k == 0 || !tokens[k - 1].is(".")) {
                tokens[k].text = replaced(tokens[k].text, self.declared);
            }
        }
    }

    fn uniform(
        &self,
        item: &Item,
        ty: &str,
        text: &mut PlacedText,
        start: &mut PlacedText,
    ) -> Result<(), CodeDiagnostic> {
        let Some(kind) = uniform_type(ty) else {
            let help = "Uniforms of a field are float, int, uint, bool, vec2, vec3 and vec4.";
            let message = format!("A field has no uniform of the type `{ty}`.");
            return Err(fault(item.at, message, "not in a field", help));
        };
        text.add(&format!("{ty} {};\n", item.name), item.at);
        let names = param_names(item.name, kind.components);
        let fixed = self.fixed.get(item.name);
        let value = |(k, name): (usize, &String)| match fixed.and_then(|values| values.get(k)) {
            Some(value) => (kind.convert)(&format!("({value:?})")),
            None => (kind.convert)(&constant_name(name)),
        };
        let parts: Vec<String> = names.iter().enumerate().map(value).collect();
        start.add(&format!("{} = {ty}({});\n", item.name, parts.join(", ")), item.at);
        Ok(())
    }

    fn function(&self, item: &Item, result: &str, text: &mut PlacedText) {
        let mut tokens = rewritten(&item.tokens, &self.members());
        self.replace(&mut tokens);
        for (k, token) in tokens.iter().enumerate() {
            text.token(token);
            if let Some(count) = element_count(&tokens, k) {
                text.add(&format!("{count} "), token.at);
            }
            // naga does not convert what a function returns.
            let returned = |at: usize| k.checked_sub(at).map_or("", |k| tokens[k].text);
            let is_returned = returned(1) == "return" || (returned(2) == "return" && returned(1) == "-");
            let ends = tokens.get(k + 1).is_some_and(|next| next.is(";"));
            if result == "float" && token.kind == Kind::Number && is_returned && ends && is_integer(token.text) {
                text.text.pop();
                text.add(".0 ", token.at);
            }
        }
    }
}

/// Prints tokens with the number of elements of each array that has its values.
fn counted(tokens: &[Token], text: &mut PlacedText) {
    for (k, token) in tokens.iter().enumerate() {
        text.token(token);
        if let Some(count) = element_count(tokens, k) {
            text.add(&format!("{count} "), token.at);
        }
    }
}

/// Prints a type or the sizes behind a name; empty brackets get the number of elements of the value.
fn sized(tokens: &[Token], value: &[Token], text: &mut PlacedText) {
    for (k, token) in tokens.iter().enumerate() {
        text.token(token);
        let is_empty = token.is("[") && tokens.get(k + 1).is_some_and(|next| next.is("]"));
        if let Some(count) = elements(value).filter(|_| is_empty) {
            text.add(&format!("{count} "), token.at);
        }
    }
}

fn is_integer(number: &str) -> bool {
    number.bytes().all(|byte| byte.is_ascii_digit())
}

/// True for values that naga can compute while it reads them.
fn is_plain(ty: &[Token], value: &[Token], changing: &HashSet<&str>) -> bool {
    let is_scalar = matches!(ty, [ty] if matches!(ty.text, "float" | "int" | "uint" | "bool"));
    let is_type = |name: &str| {
        ["vec", "ivec", "uvec", "bvec", "mat"]
            .iter()
            .any(|start| name.strip_prefix(start).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit())))
            || ["float", "int", "uint", "bool"].contains(&name)
            || ty.first().is_some_and(|ty| ty.is(name))
    };
    (0..value.len()).all(|k| {
        let token = &value[k];
        let opens = value.get(k + 1).is_some_and(|next| next.is("("));
        match token.kind {
            Kind::Name => !changing.contains(token.text) && (!opens || is_type(token.text)),
            Kind::Number => true,
            _ => is_scalar || matches!(token.text, "(" | ")" | "," | "-" | "[" | "]" | "{" | "}"),
        }
    })
}
