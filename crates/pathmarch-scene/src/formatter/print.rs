//! Prints the formatter's tree.

use super::MAX_WIDTH;
use super::columns::EndComment;
use super::tree::{Block, Content, Item, Piece, Verbatim, on_one_line};

/// Indentation of one level of braces.
const INDENT: &str = "    ";

/// The text of a file, and the comments at the ends of its lines.
pub(super) fn print(file: &Block, newline: &str) -> (String, Vec<EndComment>) {
    let mut printer = Printer { text: String::new(), line_start: 0, depth: 0, newline, end_comments: Vec::new() };
    printer.lines(&file.items, 0);
    if !printer.text.is_empty() {
        printer.text.push_str(newline);
    }
    (printer.text, printer.end_comments)
}

struct Printer<'n> {
    text: String,
    /// Start of the last line, and its depth.
    line_start: usize,
    depth: usize,
    newline: &'n str,
    end_comments: Vec<EndComment>,
}

impl Printer<'_> {
    /// Starts a line at a depth; the first line of the file has started already.
    fn line(&mut self, depth: usize) {
        if !self.text.is_empty() {
            self.text.push_str(self.newline);
        }
        self.line_start = self.text.len();
        self.depth = depth;
        self.text.push_str(&INDENT.repeat(depth));
    }
    /// A space, unless something asks for none.
    fn space(&mut self) {
        if !self.text[self.line_start..].trim_start().is_empty() && !self.text.ends_with("/-") {
            self.text.push(' ');
        }
    }
    /// True if a text fits behind the last line.
    fn fits(&self, text: &str) -> bool {
        let line = &self.text[self.line_start..];
        // A character has at most four bytes.
        line.len() + text.len() <= 4 * MAX_WIDTH && line.chars().count() + text.chars().count() <= MAX_WIDTH
    }
    fn verbatim(&mut self, part: &Verbatim) {
        let start = self.text.len();
        self.text.push_str(&part.moved(&INDENT.repeat(self.depth)));
        if part.has_several_lines() {
            self.line_start = super::tree::line_start(&self.text, self.text.len()).max(start);
        }
    }

    /// Items in lines.
    fn lines(&mut self, items: &[Item], depth: usize) {
        let mut first = true;
        for group in groups(items) {
            if group[0].breaks > 1 && !first {
                self.text.push_str(self.newline);
            }
            first = false;
            self.line(depth);
            self.group(group, depth);
        }
    }

    /// Items that share a line, if it fits.
    fn group(&mut self, group: &[Item], depth: usize) {
        let (items, comment) = match group.split_last() {
            Some((Item { content: Content::LineComment(text, column), .. }, items)) => (items, Some((text, column))),
            _ => (group, None),
        };
        match on_one_line(items).filter(|line| self.fits(line)) {
            Some(line) => self.text.push_str(&line),
            None => self.one_by_one(items, depth),
        }
        if let Some((text, column)) = comment {
            self.end_comment(text, *column, !items.is_empty());
        }
    }

    /// A line for each node, with the block comments before it.
    fn one_by_one(&mut self, items: &[Item], depth: usize) {
        let mut after_node = false;
        for item in items {
            if after_node {
                self.line(depth);
            }
            after_node = matches!(item.content, Content::Node(_));
            match &item.content {
                Content::Node(pieces) => self.node(pieces, depth),
                Content::BlockComment(comment) => {
                    self.space();
                    self.verbatim(comment);
                }
                // Ends its line, so it is not among others.
                Content::LineComment(text, _) => self.text.push_str(text),
            }
        }
    }

    fn end_comment(&mut self, text: &str, column: usize, follows: bool) {
        if follows {
            self.space();
            if text.starts_with("//") {
                self.end_comments.push(EndComment { at: self.text.len(), old_column: column });
            }
        }
        self.text.push_str(text);
    }

    fn node(&mut self, pieces: &[Piece], depth: usize) {
        for piece in pieces {
            self.space();
            match piece {
                Piece::SlashDash => self.text.push_str("/-"),
                Piece::Word(word) => self.verbatim(word),
                Piece::Property(name, value) => {
                    self.text.extend([name, "="]);
                    self.verbatim(value);
                }
                Piece::Join(comments, _) => {
                    self.text.push('\\');
                    if !comments.is_empty() {
                        self.text.extend([" ", comments]);
                    }
                    self.line(depth + 1);
                }
                Piece::Braces(block) => self.braces(block, depth),
            }
        }
    }

    fn braces(&mut self, block: &Block, depth: usize) {
        if let Some(line) = block.on_one_line().filter(|line| self.fits(line)) {
            return self.text.push_str(&line);
        }
        self.text.push('{');
        let on_brace = comments_on_brace(&block.items);
        for item in &block.items[..on_brace] {
            match &item.content {
                Content::LineComment(text, column) => self.end_comment(text, *column, true),
                Content::BlockComment(comment) => {
                    self.space();
                    self.verbatim(comment);
                }
                Content::Node(_) => {}
            }
        }
        let items = &block.items[on_brace..];
        if block.several_lines {
            self.lines(items, depth + 1);
        } else {
            self.line(depth + 1);
            self.one_by_one(items, depth + 1);
        }
        self.line(depth);
        self.text.push('}');
    }
}

/// Number of comments on the line of an opening brace, if no node follows them there.
fn comments_on_brace(items: &[Item]) -> usize {
    let same_line = groups(items).next().filter(|group| group[0].breaks == 0);
    let only_comments = |group: &&[Item]| group.iter().all(|item| !matches!(item.content, Content::Node(_)));
    same_line.filter(only_comments).map_or(0, <[Item]>::len)
}

/// Items that share a line in the file.
fn groups<'i, 't>(items: &'i [Item<'t>]) -> impl Iterator<Item = &'i [Item<'t>]> {
    items.chunk_by(|before, item| item.breaks == 0 && !matches!(before.content, Content::LineComment(..)))
}
