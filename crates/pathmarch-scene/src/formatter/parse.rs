//! Parses a text without mistakes of syntax into the formatter's tree.
//!
//! What may precede a thing that `/-` comments out (comments, line breaks) is moved before the `/-`.

use super::tree::{Block, Content, Item, Piece, Verbatim, line_start};
use crate::language::characters::{is_newline, is_space};
use crate::language::syntax;

/// Parses a text from byte `at`. Returns its tree and its line break, which is the first one that is not within a string or
/// a comment.
pub(super) fn parse(text: &str, at: usize) -> (Block<'_>, &'static str) {
    let mut parser = Parser { text, at, line: at, newline: None };
    (parser.block(), parser.newline.unwrap_or("\n"))
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    /// End of the last line break that is not within a string or a comment.
    line: usize,
    /// The first of them.
    newline: Option<&'static str>,
}

/// Items of a block so far.
#[derive(Default)]
struct Items<'t> {
    list: Vec<Item<'t>>,
    /// Line breaks since the last one.
    breaks: usize,
}

impl<'t> Items<'t> {
    fn push(&mut self, content: Content<'t>) {
        self.list.push(Item { breaks: std::mem::take(&mut self.breaks), content });
    }
}

impl<'t> Parser<'t> {
    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }
    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }
    fn skip_spaces(&mut self) {
        self.at = self.text.len() - self.rest().trim_start_matches(is_space).len();
    }
    fn skip_newline(&mut self) {
        let both = self.rest().starts_with("\r\n");
        self.at += if both { 2 } else { self.peek().map_or(0, char::len_utf8) };
        self.newline.get_or_insert(if both { "\r\n" } else { "\n" });
        self.line = self.at;
    }
    /// Bytes of the text, on the present line.
    fn verbatim(&self, start: usize, end: usize) -> Verbatim<'t> {
        let line = &self.text[self.line..];
        Verbatim::new(&self.text[start..end], &line[..line.find(|c| !is_space(c)).unwrap_or(line.len())])
    }

    /// Contents up to the closing brace, which is skipped, or to the end of the file.
    fn block(&mut self) -> Block<'t> {
        let start = self.at;
        let mut items = Items::default();
        loop {
            self.trivia(&mut items);
            match self.peek() {
                None => break,
                Some('}') => {
                    self.at += 1;
                    break;
                }
                Some(';') => self.at += 1,
                Some(_) => self.node(&mut items),
            }
        }
        Block { items: items.list, several_lines: self.text[start..self.at].contains(is_newline) }
    }

    /// White space and comments before a node.
    fn trivia(&mut self, items: &mut Items<'t>) {
        loop {
            self.skip_spaces();
            match self.peek() {
                Some(c) if is_newline(c) => {
                    self.skip_newline();
                    items.breaks += 1;
                }
                Some('/') if self.rest().starts_with("//") => items.push(self.line_comment()),
                Some('/') if self.rest().starts_with("/*") => items.push(Content::BlockComment(self.block_comment())),
                Some('\\') => {
                    let (comments, column) = self.join();
                    if !comments.is_empty() {
                        items.push(Content::LineComment(comments, column));
                    }
                    items.breaks += 1;
                }
                _ => return,
            }
        }
    }

    fn line_comment(&mut self) -> Content<'t> {
        let start = self.at;
        let rest = self.rest();
        self.at += rest.find(is_newline).unwrap_or(rest.len());
        Content::LineComment(self.text[start..self.at].trim_end_matches(is_space), self.column(start))
    }

    /// Column of a byte, characters from the start of its line.
    fn column(&self, at: usize) -> usize {
        self.text[line_start(self.text, at)..at].chars().count()
    }

    fn block_comment(&mut self) -> Verbatim<'t> {
        let start = self.at;
        self.at = syntax::after_comment(self.text, start);
        self.verbatim(start, self.at)
    }

    /// Skips `\` and the rest of its line; returns the comments there, and their column.
    fn join(&mut self) -> (&'t str, usize) {
        self.at += 1;
        self.skip_spaces();
        let start = self.at;
        while self.rest().starts_with("/*") {
            self.at = syntax::after_comment(self.text, self.at);
            self.skip_spaces();
        }
        if self.rest().starts_with("//") {
            self.line_comment();
        }
        let comments = self.text[start..self.at].trim_end_matches(is_space);
        self.skip_newline();
        (comments, self.column(start))
    }

    /// A node with what ends it, and the comments that follow `\` at its end.
    fn node(&mut self, items: &mut Items<'t>) {
        let mut pieces = Vec::new();
        if self.rest().starts_with("/-") {
            self.at += 2;
            self.trivia(items);
            pieces.push(Piece::SlashDash);
        }
        let name = self.at;
        self.at = syntax::after_name(self.text, name);
        pieces.push(Piece::Word(self.verbatim(name, self.at)));
        self.pieces(&mut pieces);
        let mut comments = Vec::new();
        while let Some(Piece::Join(..)) = pieces.last() {
            comments.extend(pieces.pop());
        }
        items.push(Content::Node(pieces));
        for comment in comments.into_iter().rev() {
            if let Piece::Join(text, column) = comment
                && !text.is_empty()
            {
                items.push(Content::LineComment(text, column));
            }
            items.breaks += 1;
        }
    }

    /// Pieces of a node after its name, and the semicolon that ends it.
    fn pieces(&mut self, pieces: &mut Vec<Piece<'t>>) {
        loop {
            self.skip_spaces();
            let rest = self.rest();
            match self.peek() {
                None | Some('}') => return,
                Some(c) if is_newline(c) => return,
                Some(';') => {
                    self.at += 1;
                    return;
                }
                Some('/') if rest.starts_with("//") => return,
                Some('/') if rest.starts_with("/*") => pieces.push(Piece::Word(self.block_comment())),
                Some('/') if rest.starts_with("/-") => {
                    self.at += 2;
                    self.trivia_of_piece(pieces);
                    pieces.push(Piece::SlashDash);
                }
                Some('\\') => {
                    let (comments, column) = self.join();
                    pieces.push(Piece::Join(comments, column));
                }
                Some('{') => {
                    self.at += 1;
                    pieces.push(Piece::Braces(self.block()));
                }
                Some(_) => pieces.push(self.entry()),
            }
        }
    }

    /// White space and comments between `/-` and the piece that it comments out.
    fn trivia_of_piece(&mut self, pieces: &mut Vec<Piece<'t>>) {
        let mut items = Items::default();
        self.trivia(&mut items);
        pieces.extend(items.list.into_iter().filter_map(|item| match item.content {
            Content::LineComment(text, column) => Some(Piece::Join(text, column)),
            Content::BlockComment(comment) => Some(Piece::Word(comment)),
            Content::Node(_) => None,
        }));
    }

    /// An argument or a property.
    fn entry(&mut self) -> Piece<'t> {
        let start = self.at;
        let entry = syntax::entry_at(self.text, start);
        let (value, end) = (entry.value_span.start as usize, entry.span.end as usize);
        self.at = end;
        let Some(name_end) = entry.name.map(|name| name.span.end as usize) else {
            return Piece::Word(self.verbatim(start, end));
        };
        let plain = self.text[name_end..value].chars().all(|c| is_space(c) || c == '=');
        if !plain || self.text[start..name_end].contains(is_newline) {
            return Piece::Word(self.verbatim(start, end));
        }
        Piece::Property(&self.text[start..name_end], self.verbatim(value, end))
    }
}
