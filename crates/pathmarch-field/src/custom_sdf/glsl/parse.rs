//! naga's module of a shader, and its messages in plain English.

use super::Shader;
use crate::custom_sdf::CodeDiagnostic;
use crate::custom_sdf::messages::{innermost, sentence};
use naga::front::glsl::{Error, ErrorKind, ExpectedToken, Frontend, Options, TokenValue};
use naga::valid::ValidationError;
use naga::{Module, ShaderStage, WithSpan};
use std::ops::Range;

/// Module of a shader; its functions are those that the distance needs, and the parameters are its overrides.
pub(in crate::custom_sdf) fn parse(shader: &Shader) -> Result<Module, Vec<CodeDiagnostic>> {
    let parsed = Frontend::default().parse(&Options::from(ShaderStage::Fragment), &shader.text.text);
    let mut module = parsed.map_err(|errors| {
        let mut faults: Vec<CodeDiagnostic> = Vec::new();
        for fault in errors.errors.iter().map(|error| parse_fault(error, shader)) {
            if !faults.contains(&fault) {
                faults.push(fault);
            }
        }
        faults
    })?;
    // The empty `main` that naga asks for, which is the last.
    module.entry_points.clear();
    let functions: Vec<_> = module.functions.drain().collect();
    for (_, function, span) in functions {
        if function.name.as_deref() != Some("main") {
            module.functions.append(function, span);
        }
    }
    Ok(module)
}

impl Shader {
    /// Place in the code of a range of the text for naga.
    pub(in crate::custom_sdf) fn place(&self, range: &Range<usize>) -> Option<Range<usize>> {
        self.text.place(range)
    }

    /// Mistake that naga found in a parsed module; its range is in the text for naga.
    pub(in crate::custom_sdf) fn validation_fault(&self, error: &WithSpan<ValidationError>) -> CodeDiagnostic {
        let own = |range: &Range<usize>| self.place(range).is_some();
        let spans = error.spans().filter_map(|(span, _)| span.to_range().filter(own));
        let range = spans.min_by_key(|range| range.len());
        CodeDiagnostic { message: innermost(error.as_inner()), label: "here".to_owned(), range, help: None }
    }
}

fn parse_fault(error: &Error, shader: &Shader) -> CodeDiagnostic {
    let range = error.meta.to_range().and_then(|range| shader.place(&range));
    let (message, help) = message(&error.kind, shader);
    CodeDiagnostic { message: sentence(&message), label: "here".to_owned(), range, help: help.map(str::to_owned) }
}

fn message(kind: &ErrorKind, shader: &Shader) -> (String, Option<&'static str>) {
    const UNDECLARED: &str =
        "Paste its declaration, too; a number that can be set is a `uniform` or a `param` of the field.";
    match kind {
        ErrorKind::EndOfFile => ("The code ends too early.".to_owned(), Some("A bracket or a `;` may be missing.")),
        ErrorKind::InvalidToken(found, expected) => {
            let found = shown(found);
            let help = (found == "`do`").then_some("Write the loop with `for` or `while`.");
            match expected.len() {
                0 => (format!("{found} is not possible here"), help),
                _ => (format!("Expected {}, found {found}", expectations(expected)), help),
            }
        }
        ErrorKind::UnknownVariable(name) => (format!("There is no variable `{name}`"), Some(UNDECLARED)),
        ErrorKind::UnknownType(name) => (format!("There is no type `{name}`"), Some("Paste its declaration, too.")),
        ErrorKind::UnknownField(name) => (format!("There is no member `{name}`"), None),
        ErrorKind::VariableAlreadyDeclared(name) => (format!("`{name}` is declared twice"), None),
        ErrorKind::NotImplemented(what) => (format!("This is not supported: {what}"), Some("Write it in another way.")),
        ErrorKind::SemanticError(text) => semantic(text, shader),
        ErrorKind::PreprocessorError(_) => ("This is no GLSL".to_owned(), None),
        other => (other.to_string(), None),
    }
}

/// Message of naga for a mistake in the meaning.
fn semantic(text: &str, shader: &Shader) -> (String, Option<&'static str>) {
    let Some(name) = text.strip_prefix("Unknown function '").and_then(|rest| rest.strip_suffix('\'')) else {
        let column = text
            .starts_with("Can't lookup field on this type")
            .then_some("Several components of a column are set one by one: m[0].x = …; m[0].y = ….");
        return (text.to_owned(), column);
    };
    let is_declared = shader.text.text.contains(&format!(" {name} ( "));
    let uses = shader.text.text.matches(&format!("{name} ( ")).count();
    if is_declared && uses > 1 {
        let help =
            "The numbers and types of the arguments must be those of a declaration; a function must not call itself.";
        return (format!("There is no function `{name}` with these arguments"), Some(help));
    }
    (format!("There is no function `{name}`"), Some("Paste the function, too."))
}

/// Tokens as they are written.
fn expectations(expected: &[ExpectedToken]) -> String {
    let words: Vec<String> = expected
        .iter()
        .map(|token| match token {
            ExpectedToken::Token(token) => shown(token),
            other => other.to_string(),
        })
        .collect();
    match words.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

/// A token as it is written.
fn shown(token: &TokenValue) -> String {
    use TokenValue as T;
    let text = match token {
        T::Identifier(name) => name,
        T::FloatConstant(float) => return format!("the number {}", float.value),
        T::IntConstant(integer) => return format!("the number {}", integer.value),
        T::BoolConstant(value) => return format!("`{value}`"),
        T::TypeName(_) => return "a type".to_owned(),
        T::LeftBrace => "{",
        T::RightBrace => "}",
        T::LeftParen => "(",
        T::RightParen => ")",
        T::LeftBracket => "[",
        T::RightBracket => "]",
        T::LeftAngle => "<",
        T::RightAngle => ">",
        T::Comma => ",",
        T::Semicolon => ";",
        T::Colon => ":",
        T::Dot => ".",
        T::Bang => "!",
        T::Dash => "-",
        T::Tilde => "~",
        T::Plus => "+",
        T::Star => "*",
        T::Slash => "/",
        T::Percent => "%",
        T::VerticalBar => "|",
        T::Caret => "^",
        T::Ampersand => "&",
        T::Question => "?",
        T::Assign => "=",
        T::Equal => "==",
        other => return format!("`{}`", format!("{other:?}").to_lowercase()),
    };
    format!("`{text}`")
}
