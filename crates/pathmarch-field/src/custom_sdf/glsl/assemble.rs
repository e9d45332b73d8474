//! Text of the declarations that a field needs, as naga accepts it.
//!
//! Parameters are specialisation constants, as those of WGSL are overrides. A uniform that is no `float` is a variable that
//! the function `pm_distance` sets from them. It also sets the variables outside functions, because naga drops their values
//! unless they are constant.

use super::entry::Entry;
use super::items::{Item, ItemKind};
use super::lexer::{Kind, Place, Token, fault};
use super::reach::replaced;
use super::text::PlacedText;
use super::uniforms::{param_names, uniform_type};
use crate::custom_sdf::CodeDiagnostic;
use std::collections::HashSet;

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
                    text.tokens(ty);
                    text.add(item.name, item.at);
                    text.tokens(sizes);
                    let target = if is_const { &mut text } else { &mut start };
                    if !value.is_empty() {
                        target.add(if is_const { "" } else { item.name }, item.at);
                        target.add(" = ", item.at);
                        target.tokens(&printed);
                        target.add(if is_const { "" } else { ";\n" }, item.at);
                    }
                    text.add(";\n", item.at);
                }
                ItemKind::Uniform { ty, .. } => {
                    changing.insert(item.name);
                    uniform(item, ty, &mut text, &mut start)?;
                }
            }
        }
        self.entry(&start, &mut text);
        Ok(text)
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

    fn function(&self, item: &Item, result: &str, text: &mut PlacedText) {
        let mut tokens = separate_arrays(&item.tokens);
        self.replace(&mut tokens);
        for (k, token) in tokens.iter().enumerate() {
            text.token(token);
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

/// Writes `float a[2], b;` as `float a[2]; float b;`: naga takes what follows an array for arrays, too.
fn separate_arrays<'a>(tokens: &[Token<'a>]) -> Vec<Token<'a>> {
    let mut result: Vec<Token> = Vec::new();
    let mut rest = tokens;
    while !rest.is_empty() {
        let length = 1 + rest.iter().position(|token| matches!(token.text, ";" | "{" | "}")).unwrap_or(rest.len() - 1);
        let (statement, after) = rest.split_at(length);
        rest = after;
        let has_array = matches!(statement, [ty, name, open, ..] if ty.is_name() && name.is_name() && !ty.is("return")
            && matches!(open.text, "[" | "=" | ","))
            && statement.iter().any(|token| token.is("["));
        let mut depth = 0_usize;
        for token in statement {
            match token.text {
                "(" | "[" => depth += 1,
                ")" | "]" => depth = depth.saturating_sub(1),
                _ => {}
            }
            if has_array && depth == 0 && token.is(",") {
                result.push(Token { text: ";", ..*token });
                result.push(statement[0]);
            } else {
                result.push(*token);
            }
        }
    }
    result
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

fn uniform(item: &Item, ty: &str, text: &mut PlacedText, start: &mut PlacedText) -> Result<(), CodeDiagnostic> {
    let Some(kind) = uniform_type(ty) else {
        let help = "Uniforms of a field are float, int, uint, bool, vec2, vec3 and vec4.";
        let message = format!("A field has no uniform of the type `{ty}`.");
        return Err(fault(item.at, message, "not in a field", help));
    };
    text.add(&format!("{ty} {};\n", item.name), item.at);
    let names = param_names(item.name, kind.components);
    let parts: Vec<String> = names.iter().map(|name| (kind.convert)(&constant_name(name))).collect();
    start.add(&format!("{} = {ty}({});\n", item.name, parts.join(", ")), item.at);
    Ok(())
}
