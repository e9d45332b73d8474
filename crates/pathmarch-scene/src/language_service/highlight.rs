//! Tokens of a text, to colour it: also of a text with mistakes, and in one pass.

use crate::language::characters::{is_newline, is_space, is_word, number};
use std::ops::Range;

/// Kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// Name of a node.
    Node,
    /// Name of a property.
    Property,
    /// Number.
    Number,
    /// String with its quotes.
    String,
    /// `#true`, `#false` and the like.
    Keyword,
    /// Comment; also the `/-` in front of a node.
    Comment,
    /// Other word.
    Word,
}

/// A coloured part of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    /// Bytes of the text.
    pub range: Range<usize>,
    /// Kind.
    pub kind: TokenKind,
}

/// Tokens in the order of the text; what is between them has no colour.
pub fn highlight(text: &str) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut at = 0;
    // The next word is the name of a node.
    let mut starts = true;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let (length, kind) = if rest.starts_with("//") {
            (rest.find(is_newline).unwrap_or(rest.len()), Some(TokenKind::Comment))
        } else if rest.starts_with("/*") {
            (block_comment(rest), Some(TokenKind::Comment))
        } else if rest.starts_with("/-") {
            (2, Some(TokenKind::Comment))
        } else if c == '"' {
            (string(rest, 0), Some(TokenKind::String))
        } else if c == '#' {
            let hashes = rest.len() - rest.trim_start_matches('#').len();
            if rest[hashes..].starts_with('"') {
                (hashes + string(&rest[hashes..], hashes), Some(TokenKind::String))
            } else {
                let word: usize = rest[hashes..].chars().take_while(|c| is_word(*c)).map(char::len_utf8).sum();
                (hashes + word, Some(TokenKind::Keyword))
            }
        } else if is_word(c) {
            let length = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            let kind = if starts {
                TokenKind::Node
            } else if rest[length..].starts_with('=') {
                TokenKind::Property
            } else if number(&rest[..length]).is_some() {
                TokenKind::Number
            } else {
                TokenKind::Word
            };
            (length, Some(kind))
        } else {
            if is_newline(c) || matches!(c, ';' | '{' | '}') {
                starts = true;
            }
            (c.len_utf8(), None)
        };
        if let Some(kind) = kind {
            tokens.push(Token { range: at..at + length, kind });
            starts &= kind == TokenKind::Comment;
        } else if !is_space(c) && !is_newline(c) && !matches!(c, ';' | '{' | '}') {
            starts = false;
        }
        at += length;
    }
    tokens
}

/// Length of a comment that may contain others.
fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        if text[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if text[at..].starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += text[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    text.len()
}

/// Length of a string with its quotes; `hashes` stood in front of it. One that is not closed ends with its line.
fn string(text: &str, hashes: usize) -> usize {
    let quotes = if text.starts_with("\"\"\"") { "\"\"\"" } else { "\"" };
    let end = format!("{quotes}{}", "#".repeat(hashes));
    let mut at = quotes.len();
    while let Some(c) = text[at..].chars().next() {
        if text[at..].starts_with(&end) {
            return at + end.len();
        }
        if c == '\\' && hashes == 0 {
            at += text[at + 1..].chars().next().map_or(0, char::len_utf8);
        } else if is_newline(c) && quotes.len() == 1 {
            return at;
        }
        at += c.len_utf8();
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::TokenKind::{Comment, Keyword, Node, Number, Property, String, Word};
    use super::*;

    fn kinds(text: &str) -> Vec<(&str, TokenKind)> {
        highlight(text).into_iter().map(|token| (&text[token.range], token.kind)).collect()
    }

    #[test]
    fn every_part_has_its_kind() {
        let text = "object \"a\" /* x /* y */ */ material=red { sphere -0.5 { at 1 2e3 z }; /- box }\n// end";
        assert_eq!(
            kinds(text),
            [
                ("object", Node),
                ("\"a\"", String),
                ("/* x /* y */ */", Comment),
                ("material", Property),
                ("red", Word),
                ("sphere", Node),
                ("-0.5", Number),
                ("at", Node),
                ("1", Number),
                ("2e3", Number),
                ("z", Word),
                ("/-", Comment),
                ("box", Node),
                ("// end", Comment),
            ]
        );
        assert_eq!(
            kinds("a #true #\"x\"y\"# \"\"\"\nb\n\"\"\""),
            [("a", Node), ("#true", Keyword), ("#\"x\"y\"#", String), ("\"\"\"\nb\n\"\"\"", String)]
        );
    }

    #[test]
    fn a_text_with_mistakes_ends_no_colours() {
        for (text, last) in
            [("a \"open\nb 1", "1"), ("a /* open", "/* open"), ("a \"\\", "\"\\"), ("é \"\"\"ü", "\"\"\"ü")]
        {
            assert_eq!(kinds(text).last().map(|(word, _)| *word), Some(last), "{text}");
        }
    }
}
