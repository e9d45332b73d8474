//! Tokens of GLSL, with their places in the code.

use crate::custom_sdf::CodeDiagnostic;
use std::ops::Range;

/// Byte range in the code of a field; empty for what the code does not contain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Place {
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Place {
    pub(super) fn range(self) -> Option<Range<usize>> {
        (self.start < self.end).then_some(self.start as usize..self.end as usize)
    }
    /// The range from the start of `self` to the end of `other`.
    pub(super) fn to(self, other: Self) -> Self {
        match other.start >= self.start && other.range().is_some() {
            true => Self { start: self.start, end: other.end },
            false => self,
        }
    }
}

/// Mistake at a place.
pub(super) fn fault(at: Place, message: impl Into<String>, label: &str, help: &str) -> CodeDiagnostic {
    CodeDiagnostic {
        message: message.into(),
        label: label.to_owned(),
        range: at.range(),
        help: Some(help.to_owned()).filter(|help| !help.is_empty()),
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Name,
    Number,
    Punctuation,
    /// A character that GLSL does not have.
    Unknown,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind,
    pub(super) text: &'a str,
    pub(super) at: Place,
    pub(super) starts_line: bool,
    /// True if white space precedes it.
    pub(super) spaced: bool,
}

impl Token<'_> {
    pub(super) fn is(&self, text: &str) -> bool {
        self.text == text
    }
    pub(super) fn is_name(&self) -> bool {
        self.kind == Kind::Name
    }
}

/// Punctuation of several characters, the longest first.
const LONG: [&str; 24] = [
    "<<=", ">>=", "++", "--", "&&", "||", "^^", "<=", ">=", "==", "!=", "<<", ">>", "+=", "-=", "*=", "/=", "%=", "&=",
    "|=", "^=", "##", "::", "->",
];
const SHORT: &str = "()[]{}.,;:?+-*/%<>=!~&|^#";
/// Words after a uniform that describe its slider, in a comment, too.
const CONTROLS: [&str; 4] = ["slider", "checkbox", "color", "floatslider"];

/// Tokens of a code. Comments are white space, except those with the slider of a uniform, as in `// slider[0,1,2]`.
pub(super) fn tokens(code: &str) -> Vec<Token<'_>> {
    tokens_at(code, true)
}

/// Tokens of a code that is not the field's own.
pub(super) fn foreign_tokens(code: &str) -> Vec<Token<'_>> {
    tokens_at(code, false)
}

fn tokens_at(code: &str, own: bool) -> Vec<Token<'_>> {
    let mut all = Vec::new();
    let (mut at, mut starts_line, mut spaced) = (0, true, false);
    while let Some(first) = code[at..].chars().next() {
        let rest = &code[at..];
        let blank = blank_length(rest, first);
        if blank > 0 {
            starts_line |= ends_line(&rest[..blank]);
            spaced = true;
            at += blank;
            continue;
        }
        let (kind, length) = token(rest, first);
        let at_place = Place { start: at as u32, end: (at + length) as u32 };
        let at_place = if own { at_place } else { Place::default() };
        all.push(Token { kind, text: &rest[..length], at: at_place, starts_line, spaced });
        (starts_line, spaced) = (false, false);
        at += length;
    }
    all
}

/// True for white space that ends a line; a backslash continues one.
fn ends_line(blank: &str) -> bool {
    blank.starts_with('\n') || blank.starts_with('\r')
}

/// Length of the white space or comment at the start of a text, bytes; 0 if there is none.
fn blank_length(text: &str, first: char) -> usize {
    if let Some(rest) = text.strip_prefix('\\') {
        let line = rest.trim_start_matches([' ', '\t', '\r']);
        return if line.starts_with('\n') { text.len() - line.len() + 1 } else { 0 };
    }
    if first.is_whitespace() {
        return first.len_utf8();
    }
    if let Some(comment) = text.strip_prefix("//") {
        let inner = comment.trim_start_matches([' ', '\t']);
        let is_control =
            CONTROLS.iter().any(|word| inner.strip_prefix(word).is_some_and(|rest| rest.trim_start().starts_with('[')));
        return match is_control {
            true => text.len() - inner.len(),
            false => text.find('\n').unwrap_or(text.len()),
        };
    }
    if let Some(comment) = text.strip_prefix("/*") {
        return comment.find("*/").map_or(text.len(), |end| end + 4);
    }
    0
}

/// Kind and length of the token at the start of a text.
fn token(text: &str, first: char) -> (Kind, usize) {
    let second = text.chars().nth(1).unwrap_or(' ');
    if first.is_ascii_digit() || (first == '.' && second.is_ascii_digit()) {
        return (Kind::Number, number_length(text));
    }
    if first.is_ascii_alphabetic() || first == '_' {
        let end = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        return (Kind::Name, end.unwrap_or(text.len()));
    }
    if let Some(long) = LONG.iter().find(|long| text.starts_with(**long)) {
        return (Kind::Punctuation, long.len());
    }
    let kind = if SHORT.contains(first) { Kind::Punctuation } else { Kind::Unknown };
    (kind, first.len_utf8())
}

fn number_length(text: &str) -> usize {
    let is_hex = text.starts_with("0x") || text.starts_with("0X");
    let mut previous = ' ';
    let end = text.find(|c: char| {
        let exponent = !is_hex && matches!(previous, 'e' | 'E') && matches!(c, '+' | '-');
        previous = c;
        !(c.is_ascii_alphanumeric() || c == '.' || exponent)
    });
    end.unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(code: &str) -> Vec<&str> {
        tokens(code).iter().map(|token| token.text).collect()
    }

    #[test]
    fn numbers_names_and_operators_are_told_apart() {
        assert_eq!(texts("a.x+=.5e-3-1.;"), ["a", ".", "x", "+=", ".5e-3", "-", "1.", ";"]);
        assert_eq!(texts("i<<=2u;0x1eu-1"), ["i", "<<=", "2u", ";", "0x1eu", "-", "1"]);
        assert_eq!(texts("a//b\n/* c\n */d"), ["a", "d"]);
    }

    #[test]
    fn a_slider_in_a_comment_is_read() {
        assert_eq!(texts("a; // slider[0,1]\n// a slider"), ["a", ";", "slider", "[", "0", ",", "1", "]"]);
    }

    #[test]
    fn lines_continue_behind_a_backslash() {
        let tokens = tokens("#define A \\\n b\nc");
        let starts: Vec<bool> = tokens.iter().map(|token| token.starts_line).collect();
        assert_eq!(starts, [true, false, false, false, true]);
    }
}
