//! Macros of the preprocessor: their definition and expansion.
//!
//! An expanded token has the place of the macro's name in the code, arguments have their own. The work of all expansions is
//! limited, because macros that contain each other grow without bound.

use super::lexer::{Kind, Place, Token, fault};
use crate::custom_sdf::CodeDiagnostic;
use std::collections::HashMap;
use std::rc::Rc;

/// Largest number of tokens that all expansions of a code handle.
const MAX_WORK: u32 = 1 << 18;
/// Largest nesting of macros in arguments of macros.
const MAX_DEPTH: u32 = 64;

struct Macro<'a> {
    /// `None` for a macro without brackets.
    params: Option<Vec<&'a str>>,
    body: Vec<Token<'a>>,
}

/// Macros defined at a point of the code.
#[derive(Default)]
pub(super) struct Macros<'a> {
    known: HashMap<&'a str, Rc<Macro<'a>>>,
    work: u32,
}

/// Tokens to expand, the next one last.
enum Pending<'a> {
    Token(Token<'a>),
    /// The end of this macro's expansion.
    End(&'a str),
}

impl<'a> Macros<'a> {
    pub(super) fn contains(&self, name: &str) -> bool {
        self.known.contains_key(name)
    }

    pub(super) fn undefine(&mut self, name: &str) {
        self.known.remove(name);
    }

    /// Defines the macro of a line, `name` or `name(a, b)` and its body. A later definition replaces an earlier one.
    pub(super) fn define(&mut self, line: &[Token<'a>], directive: Place) -> Result<(), CodeDiagnostic> {
        let Some(name) = line.first().filter(|token| token.is_name()) else {
            return Err(fault(directive, "This `#define` has no name.", "expected a name", ""));
        };
        let mut rest = &line[1..];
        let mut params = None;
        if rest.first().is_some_and(|token| token.is("(") && !token.spaced) {
            let Some(end) = rest.iter().position(|token| token.is(")")) else {
                return Err(fault(name.at, "The parameters of this macro have no `)`.", "not closed", ""));
            };
            params = Some(rest[1..end].iter().filter(|token| token.is_name()).map(|token| token.text).collect());
            rest = &rest[end + 1..];
        }
        if let Some(paste) = rest.iter().find(|token| token.is("##")) {
            let help = "Write the joined names out.";
            return Err(fault(paste.at, "Macros that join names with `##` are not supported.", "not supported", help));
        }
        self.known.insert(name.text, Rc::new(Macro { params, body: rest.to_vec() }));
        Ok(())
    }

    /// Expands all macros in these tokens.
    pub(super) fn expand(&mut self, tokens: &[Token<'a>]) -> Result<Vec<Token<'a>>, CodeDiagnostic> {
        self.expand_at(tokens, &[], 0)
    }

    fn expand_at(
        &mut self,
        tokens: &[Token<'a>],
        outer: &[&'a str],
        depth: u32,
    ) -> Result<Vec<Token<'a>>, CodeDiagnostic> {
        let mut active: Vec<&str> = outer.to_vec();
        let mut pending: Vec<Pending> = tokens.iter().rev().copied().map(Pending::Token).collect();
        let mut done = Vec::new();
        while let Some(next) = pending.pop() {
            let token = match next {
                Pending::End(name) => {
                    active.retain(|other| *other != name);
                    continue;
                }
                Pending::Token(token) => token,
            };
            self.count(1, token.at, depth)?;
            let known =
                self.known.get(token.text).filter(|_| token.kind == Kind::Name && !active.contains(&token.text));
            let Some(found) = known.cloned() else {
                done.push(token);
                continue;
            };
            let arguments = match &found.params {
                None => Vec::new(),
                Some(params) => {
                    let Some(arguments) = arguments(&mut pending, &mut active) else {
                        done.push(token);
                        continue;
                    };
                    check_count(&token, params.len(), &arguments)?;
                    self.expanded(&arguments, &active, depth)?
                }
            };
            active.push(token.text);
            pending.push(Pending::End(token.text));
            self.substitute(&found, &token, &arguments, &mut pending, depth)?;
        }
        Ok(done)
    }

    /// Expands each argument by itself.
    fn expanded(
        &mut self,
        arguments: &[Vec<Token<'a>>],
        active: &[&'a str],
        depth: u32,
    ) -> Result<Vec<Vec<Token<'a>>>, CodeDiagnostic> {
        arguments.iter().map(|argument| self.expand_at(argument, active, depth + 1)).collect()
    }

    /// Pushes the body of a macro, with its arguments.
    fn substitute(
        &mut self,
        found: &Macro<'a>,
        call: &Token<'a>,
        arguments: &[Vec<Token<'a>>],
        pending: &mut Vec<Pending<'a>>,
        depth: u32,
    ) -> Result<(), CodeDiagnostic> {
        for token in found.body.iter().rev() {
            let param = found.params.iter().flatten().position(|param| *param == token.text);
            match param.and_then(|index| arguments.get(index)) {
                Some(argument) => {
                    self.count(argument.len() as u32, call.at, depth)?;
                    pending.extend(argument.iter().rev().copied().map(Pending::Token));
                }
                None => pending.push(Pending::Token(Token { at: call.at, starts_line: false, ..*token })),
            }
        }
        Ok(())
    }

    fn count(&mut self, tokens: u32, at: Place, depth: u32) -> Result<(), CodeDiagnostic> {
        self.work = self.work.saturating_add(tokens);
        if self.work <= MAX_WORK && depth <= MAX_DEPTH {
            return Ok(());
        }
        let help = "Macros that contain each other several times double with each step: use functions.";
        Err(fault(at, "The macros of this code expand to too much.", "too much from here", help))
    }
}

/// Takes the arguments of a call, without brackets; `None` if no bracket follows.
fn arguments<'a>(pending: &mut Vec<Pending<'a>>, active: &mut Vec<&'a str>) -> Option<Vec<Vec<Token<'a>>>> {
    let is_open = |pending: &Pending| matches!(pending, Pending::Token(token) if token.is("("));
    let next = pending.iter().rev().find(|pending| matches!(pending, Pending::Token(_)))?;
    if !is_open(next) {
        return None;
    }
    let (mut depth, mut all) = (0_u32, vec![Vec::new()]);
    while let Some(next) = pending.pop() {
        let token = match next {
            Pending::End(name) => {
                active.retain(|other| *other != name);
                continue;
            }
            Pending::Token(token) => token,
        };
        match token.text {
            "(" => depth += 1,
            ")" => depth -= 1,
            _ => {}
        }
        match token.text {
            "(" if depth == 1 => {}
            ")" if depth == 0 => return Some(all),
            "," if depth == 1 => all.push(Vec::new()),
            _ => all.last_mut().into_iter().for_each(|last| last.push(token)),
        }
    }
    // Not closed: the brackets are reported later.
    Some(all)
}

fn check_count(call: &Token, expected: usize, arguments: &[Vec<Token>]) -> Result<(), CodeDiagnostic> {
    let none = expected == 0 && arguments.len() == 1 && arguments[0].is_empty();
    if none || arguments.len() == expected {
        return Ok(());
    }
    let message = format!("The macro `{}` takes {expected} arguments, not {}.", call.text, arguments.len());
    Err(fault(call.at, message, "wrong number of arguments", ""))
}
