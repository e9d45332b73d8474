//! Declarations of a code: its functions, variables, constants, structures and uniforms.
//!
//! A field needs few of the functions of a shader. The others, with their textures and lights, are never given to naga.

use super::control::{Control, control};
use super::lexer::{Kind, Place, Token, fault};
use crate::custom_sdf::CodeDiagnostic;
use std::collections::HashSet;

/// Largest nesting of brackets and braces: parsers work by recursion.
const MAX_NESTING: usize = 200;
/// Qualifiers that mean nothing to a field.
const QUALIFIERS: [&str; 8] = ["highp", "mediump", "lowp", "flat", "smooth", "invariant", "precise", "centroid"];
/// Word that starts a variable between the code that runs once for a picture and the distance function.
const VARYING: &str = "varying";
/// Words that start declarations of what a field does not have.
const STAGE: [&str; 7] = ["in", "out", "attribute", "buffer", "shared", "layout", "precision"];

/// Parameter of a function.
pub(super) struct Argument<'a> {
    pub(super) ty: &'a str,
    /// True for `out` and `inout`.
    pub(super) is_output: bool,
    /// True for `out`.
    pub(super) is_only_output: bool,
}

pub(super) enum ItemKind<'a> {
    Function {
        result: &'a str,
        arguments: Vec<Argument<'a>>,
    },
    /// Variable or constant: one declarator.
    Variable {
        is_const: bool,
        ty: Vec<Token<'a>>,
        sizes: Vec<Token<'a>>,
        value: Vec<Token<'a>>,
    },
    /// Types and names of members.
    Struct {
        members: Vec<(&'a str, &'a str)>,
    },
    Uniform {
        ty: &'a str,
        value: Vec<Token<'a>>,
        /// `None` if the code has none. A mistake in it matters only where the uniform is used.
        control: Option<Result<Control, CodeDiagnostic>>,
    },
}

/// Declaration.
pub(super) struct Item<'a> {
    pub(super) name: &'a str,
    pub(super) at: Place,
    pub(super) kind: ItemKind<'a>,
    /// Its tokens, for functions and structures.
    pub(super) tokens: Vec<Token<'a>>,
}

impl<'a> Item<'a> {
    /// Names that it may refer to.
    pub(super) fn references(&self) -> impl Iterator<Item = &Token<'a>> {
        let more: [&[Token<'a>]; 3] = match &self.kind {
            ItemKind::Variable { ty, sizes, value, .. } => [ty, sizes, value],
            _ => [&[], &[], &[]],
        };
        let names = |tokens: &'_ [Token<'a>]| {
            let after_dot = |k: usize| k > 0 && tokens[k - 1].is(".");
            (0..tokens.len()).filter(|&k| tokens[k].is_name() && !after_dot(k)).collect::<Vec<_>>()
        };
        [&self.tokens[..]].into_iter().chain(more).flat_map(move |tokens| names(tokens).into_iter().map(|k| &tokens[k]))
    }
}

/// Splits a code into its declarations. `has_varyings` is true for a code that sets its `varying` variables.
pub(super) fn items<'a>(tokens: &[Token<'a>], has_varyings: bool) -> Result<Vec<Item<'a>>, CodeDiagnostic> {
    check_brackets(tokens)?;
    let mut reader = Reader { tokens, at: 0, items: Vec::new(), has_varyings };
    while reader.at < tokens.len() {
        reader.declaration()?;
    }
    Ok(reader.items)
}

/// Removes what code that runs once for a picture declares, too: the variables that it shares with the distance function, and
/// its copies of functions. `is_in_vertex` is true for places in it.
pub(super) fn drop_repeated(items: &mut Vec<Item>, is_in_vertex: &dyn Fn(Place) -> bool) {
    let types = |item: &Item| match &item.kind {
        ItemKind::Function { arguments, .. } => Some(arguments.iter().map(|argument| argument.ty.to_owned()).collect()),
        _ => None::<Vec<String>>,
    };
    let outside: HashSet<(String, Option<Vec<String>>)> =
        items.iter().filter(|item| !is_in_vertex(item.at)).map(|item| (item.name.to_owned(), types(item))).collect();
    items.retain(|item| !is_in_vertex(item.at) || !outside.contains(&(item.name.to_owned(), types(item))));
}

fn check_brackets(tokens: &[Token]) -> Result<(), CodeDiagnostic> {
    let mut open: Vec<&Token> = Vec::new();
    for token in tokens.iter().filter(|token| token.kind == Kind::Punctuation) {
        let expected = match token.text {
            "(" | "[" | "{" => {
                open.push(token);
                if open.len() > MAX_NESTING {
                    return Err(fault(
                        token.at,
                        "This code is nested too deeply.",
                        "too deep",
                        "Name a part in a variable.",
                    ));
                }
                continue;
            }
            ")" => "(",
            "]" => "[",
            "}" => "{",
            _ => continue,
        };
        if open.pop().is_none_or(|open| !open.is(expected)) {
            let message = format!("This `{}` closes nothing.", token.text);
            return Err(fault(token.at, message, &format!("no `{expected}` is open here"), ""));
        }
    }
    match open.pop() {
        Some(token) => Err(fault(token.at, format!("This `{}` is not closed.", token.text), "opened here", "")),
        None => Ok(()),
    }
}

struct Reader<'t, 'a> {
    tokens: &'t [Token<'a>],
    at: usize,
    items: Vec<Item<'a>>,
    has_varyings: bool,
}

impl<'t, 'a> Reader<'t, 'a> {
    fn peek(&self) -> Option<&'t Token<'a>> {
        self.tokens.get(self.at)
    }

    fn next_is(&mut self, text: &str) -> bool {
        let is = self.peek().is_some_and(|token| token.is(text));
        self.at += usize::from(is);
        is
    }

    /// Takes the tokens up to one of these, outside all brackets; leaves that one.
    fn until(&mut self, ends: &[&str]) -> &'t [Token<'a>] {
        let (start, mut depth) = (self.at, 0_usize);
        while let Some(token) = self.peek() {
            if depth == 0 && ends.contains(&token.text) {
                break;
            }
            match token.text {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth = depth.saturating_sub(1),
                _ => {}
            }
            self.at += 1;
        }
        &self.tokens[start..self.at]
    }

    /// Takes a pair of brackets and its contents.
    fn group(&mut self) -> &'t [Token<'a>] {
        let start = self.at;
        self.at += 1;
        self.until(&[")", "]", "}"]);
        self.at = (self.at + 1).min(self.tokens.len());
        &self.tokens[start..self.at]
    }

    fn name(&mut self, what: &str) -> Result<Token<'a>, CodeDiagnostic> {
        match self.peek() {
            Some(token) if token.is_name() => {
                self.at += 1;
                Ok(*token)
            }
            found => {
                let at = found.or(self.tokens.last()).map_or(Place::default(), |token| token.at);
                let help = "Outside functions a field has functions, variables, constants, structures and uniforms.";
                Err(fault(at, format!("There is no {what} here."), &format!("expected a {what}"), help))
            }
        }
    }

    fn declaration(&mut self) -> Result<(), CodeDiagnostic> {
        if self.next_is(";") {
            return Ok(());
        }
        let (mut is_const, mut is_uniform, mut is_stage) = (false, false, false);
        while let Some(token) = self.peek() {
            match token.text {
                "const" => is_const = true,
                "uniform" => is_uniform = true,
                VARYING => is_stage = !self.has_varyings,
                word if STAGE.contains(&word) => is_stage = true,
                word if QUALIFIERS.contains(&word) => {}
                _ => break,
            }
            self.at += 1;
            if token.is("layout") && self.peek().is_some_and(|next| next.is("(")) {
                self.group();
            }
        }
        if is_stage && !is_uniform {
            self.until(&[";"]);
            return Ok(());
        }
        if is_uniform {
            return self.uniform();
        }
        if self.peek().is_some_and(|token| token.is("struct")) {
            return self.structure(is_const);
        }
        let start = self.at;
        self.name("type")?;
        while self.peek().is_some_and(|token| token.is("[")) {
            self.group();
        }
        let ty = self.tokens[start..self.at].to_vec();
        let name = self.name("name")?;
        match self.peek().is_some_and(|token| token.is("(")) {
            true => self.function(start, name),
            false => {
                self.at -= 1;
                self.variables(is_const, &ty)
            }
        }
    }

    fn function(&mut self, start: usize, name: Token<'a>) -> Result<(), CodeDiagnostic> {
        let arguments = arguments(self.group());
        if self.next_is(";") {
            return Ok(());
        }
        if self.peek().is_none_or(|token| !token.is("{")) {
            let at = self.peek().map_or(name.at, |token| token.at);
            return Err(fault(at, format!("The function `{}` has no body.", name.text), "expected `{`", ""));
        }
        self.group();
        let kind = ItemKind::Function { result: self.tokens[start].text, arguments };
        let tokens = self.tokens[start..self.at].to_vec();
        self.items.push(Item { name: name.text, at: name.at, kind, tokens });
        Ok(())
    }

    fn variables(&mut self, is_const: bool, ty: &[Token<'a>]) -> Result<(), CodeDiagnostic> {
        loop {
            let name = self.name("name")?;
            let start = self.at;
            while self.peek().is_some_and(|token| token.is("[")) {
                self.group();
            }
            let sizes = self.tokens[start..self.at].to_vec();
            let value = if self.next_is("=") { self.until(&[",", ";"]).to_vec() } else { Vec::new() };
            let kind = ItemKind::Variable { is_const, ty: ty.to_vec(), sizes, value };
            self.items.push(Item { name: name.text, at: name.at, kind, tokens: Vec::new() });
            if !self.next_is(",") {
                break;
            }
        }
        self.end()
    }

    fn end(&mut self) -> Result<(), CodeDiagnostic> {
        if self.next_is(";") {
            return Ok(());
        }
        let at = self.peek().or(self.tokens.last()).map_or(Place::default(), |token| token.at);
        Err(fault(at, "A `;` is missing here.", "expected `;`", ""))
    }

    fn structure(&mut self, is_const: bool) -> Result<(), CodeDiagnostic> {
        let start = self.at;
        self.at += 1;
        let name = self.name("name")?;
        if self.peek().is_none_or(|token| !token.is("{")) {
            return Err(fault(name.at, "This structure has no members.", "expected `{` behind it", ""));
        }
        let members = members(self.group());
        let tokens = self.tokens[start..self.at].to_vec();
        self.items.push(Item { name: name.text, at: name.at, kind: ItemKind::Struct { members }, tokens });
        if self.peek().is_some_and(|token| token.is_name()) {
            return self.variables(is_const, &[name]);
        }
        self.end()
    }

    fn uniform(&mut self) -> Result<(), CodeDiagnostic> {
        let ty = self.name("type")?;
        let mut declared = Vec::new();
        if self.peek().is_some_and(|token| token.is("{")) {
            return Err(fault(
                ty.at,
                "Blocks of uniforms are not supported.",
                "not supported",
                "Declare them one by one.",
            ));
        }
        loop {
            let name = self.name("name")?;
            let value = if self.next_is("=") { self.until(&[",", ";"]).to_vec() } else { Vec::new() };
            declared.push((name, value));
            if !self.next_is(",") {
                break;
            }
        }
        self.until(&[";"]);
        self.end()?;
        let mut found = None;
        if self.peek().is_some_and(|token| token.is_name())
            && self.tokens.get(self.at + 1).is_some_and(|token| token.is("["))
        {
            let word = self.name("control")?;
            found = Some(control(&word, self.group()));
            while self.peek().is_some_and(|token| token.text.starts_with("Lock") || token.text.starts_with("NotLock")) {
                self.at += 1;
            }
        }
        self.items.extend(declared.into_iter().map(|(name, value)| Item {
            name: name.text,
            at: name.at,
            kind: ItemKind::Uniform { ty: ty.text, value, control: found.clone() },
            tokens: Vec::new(),
        }));
        Ok(())
    }
}

/// Parameters in the brackets of a function.
fn arguments<'a>(group: &[Token<'a>]) -> Vec<Argument<'a>> {
    let inner = group.get(1..group.len().saturating_sub(1)).unwrap_or_default();
    let argument = |tokens: &[Token<'a>]| {
        let has = |word: &str| tokens.iter().any(|token| token.is(word));
        let is_type = |token: &&Token| {
            token.is_name()
                && !["in", "out", "inout", "const"].contains(&token.text)
                && !QUALIFIERS.contains(&token.text)
        };
        let ty = tokens.iter().find(is_type)?.text;
        Some(Argument { ty, is_output: has("out") || has("inout"), is_only_output: has("out") })
            .filter(|_| ty != "void")
    };
    inner.split(|token| token.is(",")).filter_map(argument).collect()
}

/// Types and names of the members in the braces of a structure.
fn members<'a>(group: &[Token<'a>]) -> Vec<(&'a str, &'a str)> {
    let mut all = Vec::new();
    for line in group.split(|token| token.is(";")) {
        let mut names = line.iter().filter(|token| token.is_name() && !QUALIFIERS.contains(&token.text));
        if let Some(ty) = names.next() {
            all.extend(names.map(|name| (ty.text, name.text)));
        }
    }
    all
}
