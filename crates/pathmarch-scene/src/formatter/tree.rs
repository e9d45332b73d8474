//! Tree of a text with its comments, without white space.

use super::MAX_WIDTH;
use crate::language::characters::{is_newline, is_space};

/// Contents of braces, or of the file.
pub(super) struct Block<'t> {
    pub(super) items: Vec<Item<'t>>,
    /// True if it has a line break, even within a string or a comment.
    pub(super) several_lines: bool,
}

/// A node or a comment between nodes.
pub(super) struct Item<'t> {
    /// Number of line breaks before it, since the item before or the opening brace.
    pub(super) breaks: usize,
    pub(super) content: Content<'t>,
}

pub(super) enum Content<'t> {
    /// Comments up to the end of the line, and the column that they start in.
    LineComment(&'t str, usize),
    /// `/* … */`
    BlockComment(Verbatim<'t>),
    /// A node: name, arguments, properties, braces and what is between them.
    Node(Vec<Piece<'t>>),
}

/// Piece of a node.
pub(super) enum Piece<'t> {
    /// `/-`, which comments out the node or the next word or braces.
    SlashDash,
    /// Name of the node, argument, property, or block comment.
    Word(Verbatim<'t>),
    /// Property, without the white space around `=`.
    Property(&'t str, Verbatim<'t>),
    /// `\` at the end of a line, the comments after it, and the column that they start in.
    Join(&'t str, usize),
    Braces(Block<'t>),
}

/// A piece of the text that is not changed. If it has several lines: the indentation of the line that it belongs to, which
/// starts behind the last line break that is not within a string or a comment.
pub(super) struct Verbatim<'t> {
    pub(super) text: &'t str,
    indent: Option<&'t str>,
}

impl<'t> Verbatim<'t> {
    /// A piece of a text whose line has this indentation.
    pub(super) fn new(text: &'t str, indent: &'t str) -> Self {
        Self { text, indent: text.contains(is_newline).then_some(indent) }
    }
    pub(super) fn has_several_lines(&self) -> bool {
        self.indent.is_some()
    }
    /// The text with its lines moved from the old indentation to a new one, if all of them have the old one.
    pub(super) fn moved(&self, indent: &str) -> String {
        let Some(old) = self.indent else { return self.text.to_owned() };
        let blank = |line: &str| line.chars().all(|c| is_space(c) || is_newline(c));
        let mut lines = self.text.split_inclusive(is_newline);
        let mut moved = lines.next().unwrap_or_default().to_owned();
        for line in lines {
            match line.strip_prefix(old) {
                _ if blank(line) => moved.push_str(line),
                Some(rest) => moved.extend([indent, rest]),
                None => return self.text.to_owned(),
            }
        }
        moved
    }
}

/// Start of the line that contains byte `at`.
pub(super) fn line_start(text: &str, at: usize) -> usize {
    text[..at].char_indices().rev().find(|(_, c)| is_newline(*c)).map_or(0, |(index, c)| index + c.len_utf8())
}

impl Block<'_> {
    /// Its braces on one line, if they are on one line in the file.
    pub(super) fn on_one_line(&self) -> Option<String> {
        if self.items.is_empty() {
            return Some("{}".to_owned());
        }
        let inner = if self.several_lines { None } else { on_one_line(&self.items) };
        inner.map(|inner| format!("{{ {inner} }}"))
    }
}

/// Longest line that can fit, bytes: a character has at most four.
const MAX_BYTES: usize = 4 * MAX_WIDTH;

/// Items beside each other, without a comment at the end of the line; `None` if one has several lines, or all together
/// cannot fit in a line.
pub(super) fn on_one_line(items: &[Item]) -> Option<String> {
    let last_node = items.iter().rposition(|item| matches!(item.content, Content::Node(_)));
    let mut line = String::new();
    for (index, item) in items.iter().enumerate() {
        let text = match &item.content {
            Content::LineComment(..) => return None,
            Content::BlockComment(comment) if comment.has_several_lines() => return None,
            Content::BlockComment(comment) => comment.text.to_owned(),
            Content::Node(pieces) => node_on_one_line(pieces)?,
        };
        let is_node = matches!(item.content, Content::Node(_));
        line.push_str(if index > 0 { " " } else { "" });
        line.push_str(&text);
        line.push_str(if is_node && last_node > Some(index) { ";" } else { "" });
        if line.len() > MAX_BYTES {
            return None;
        }
    }
    Some(line)
}

fn node_on_one_line(pieces: &[Piece]) -> Option<String> {
    let mut line = String::new();
    for piece in pieces {
        if !line.is_empty() && !line.ends_with("/-") {
            line.push(' ');
        }
        match piece {
            Piece::SlashDash => line.push_str("/-"),
            Piece::Word(word) if !word.has_several_lines() => line.push_str(word.text),
            Piece::Property(name, value) if !value.has_several_lines() => line.extend([name, "=", value.text]),
            Piece::Braces(block) => line.push_str(&block.on_one_line()?),
            Piece::Word(_) | Piece::Property(..) | Piece::Join(..) => return None,
        }
        if line.len() > MAX_BYTES {
            return None;
        }
    }
    Some(line)
}
