//! Reads the text of a scene as KDL 2: nodes with arguments, properties and children.
//!
//! Source: the KDL 2.0.1 specification (<https://kdl.dev/spec>), read by recursive descent, one pass, no backtracking
//! except over white space before `=`. Where we differ from the `kdl` crate, which tests hold this reader against:
//! after a mistake it goes on with the next argument or line and still returns a tree, so that one go finds the
//! mistakes of form and those of meaning; what a `/-` comments out is read once (the crate takes time doubling with
//! every nested one: 32 s for 160 bytes); nesting, nodes and mistakes are bounded, so no text overflows the stack.
//! Cost: linear; a scene of 10,000 objects (0.7 MB) is read, checked and built in about 45 ms.

pub(crate) mod reparse;
pub(crate) mod strings;
#[cfg(test)]
mod tests;

use crate::language::characters::{
    forbidden_in, is_forbidden, is_newline, is_space, is_word, looks_like_number, number,
};
use crate::language::diagnostics::report::{Draft, Report, draft, shown};
use crate::language::tree::{Block, Entry, Node, Span, Text, Value};
use std::borrow::Cow;

/// Braces within braces; deeper is refused.
pub(crate) const MAX_NESTING: usize = 64;
/// Nodes, arguments and properties of a file; more are refused. 100,000 shapes need a third of this.
const MAX_ITEMS: usize = 4_000_000;

pub(super) struct Reader<'t, 'r> {
    text: &'t str,
    at: usize,
    items: usize,
    stopped: bool,
    /// Depth of `/-` comments around the present place.
    commented_out: usize,
    pub(super) report: &'r mut Report,
}

/// The nodes of `text`; `None` where it is refused as a whole. Mistakes go into `report`.
pub(crate) fn read<'t>(text: &'t str, report: &mut Report) -> Option<Block<'t>> {
    let start = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let mut reader = Reader { text, at: start, items: 0, stopped: false, commented_out: 0, report };
    for (index, c) in forbidden_in(text, start) {
        reader.report.add(
            draft("pathmarch::syntax", Span::new(index, index + c.len_utf8()), "This character must not be in a file.")
                .label(format!("U+{:04X}, which does not show", u32::from(c)))
                .help("Delete it; in a string, write it as \\u{…}."),
        );
    }
    let nodes = reader.block(None, 0);
    (!reader.stopped).then_some(nodes)
}

/// End of the name of a node that starts at byte `at` of a text without mistakes.
pub(crate) fn after_name(text: &str, at: usize) -> usize {
    reading_at(text, at, |reader| {
        reader.annotation();
        reader.spaces();
        reader.value();
        reader.at
    })
}

/// Argument or property that starts at byte `at` of a text without mistakes.
pub(crate) fn entry_at(text: &str, at: usize) -> Entry<'_> {
    reading_at(text, at, |reader| reader.entry())
}

/// End of the block comment that starts at byte `at` of a text without mistakes.
pub(crate) fn after_comment(text: &str, at: usize) -> usize {
    reading_at(text, at, |reader| {
        reader.block_comment();
        reader.at
    })
}

/// Reads a part of a text that was read before, without a report.
fn reading_at<'t, T>(text: &'t str, at: usize, read: impl FnOnce(&mut Reader<'t, '_>) -> T) -> T {
    let mut report = Report::new("", "");
    read(&mut Reader { text, at, items: 0, stopped: false, commented_out: 1, report: &mut report })
}

fn syntax(span: Span, message: impl Into<String>) -> Draft {
    draft("pathmarch::syntax", span, message)
}

impl<'t> Reader<'t, '_> {
    pub(super) fn at(&self) -> usize {
        self.at
    }
    pub(super) fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }
    pub(super) fn skip(&mut self, bytes: usize) {
        self.at += bytes;
    }
    pub(super) fn move_to(&mut self, at: usize) {
        self.at = at;
    }
    pub(super) fn text_length(&self) -> usize {
        self.text.len()
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }
    fn starts_with(&self, what: &str) -> bool {
        self.rest().starts_with(what)
    }
    fn since(&self, start: usize) -> Span {
        Span::new(start, self.at)
    }
    /// Consumes characters of a class, and returns them.
    fn take_while(&mut self, class: impl Fn(char) -> bool) -> &'t str {
        let rest = self.rest();
        // Bytes while they are characters.
        let ascii = rest.bytes().position(|byte| !byte.is_ascii() || !class(char::from(byte))).unwrap_or(rest.len());
        let taken = match rest.as_bytes().get(ascii) {
            Some(byte) if !byte.is_ascii() => {
                &rest[..rest[ascii..].find(|c| !class(c)).map_or(rest.len(), |end| ascii + end)]
            }
            _ => &rest[..ascii],
        };
        self.at += taken.len();
        taken
    }
    /// Stops reading, with this as the reason.
    fn refuse(&mut self, reason: Draft) {
        if !self.stopped {
            self.report.add(reason);
        }
        self.stopped = true;
        self.at = self.text.len();
    }
    fn count_item(&mut self, span: Span) {
        self.items += 1;
        if self.items > MAX_ITEMS {
            self.refuse(
                draft("pathmarch::too_large", span, format!("The file has more than {MAX_ITEMS} nodes and arguments."))
                    .label("one too many"),
            );
        }
    }

    /// Consumes white space, comments and `\` line ends within a line. Returns true if there was any.
    fn spaces(&mut self) -> bool {
        let start = self.at;
        loop {
            self.take_while(|c| is_space(c) || is_forbidden(c));
            match self.text.as_bytes().get(self.at) {
                Some(b'/') if self.starts_with("/*") => self.block_comment(),
                Some(b'\\') => self.line_join(),
                _ => return self.at > start,
            }
        }
    }
    fn block_comment(&mut self) {
        let start = self.at;
        let bytes = self.text.as_bytes();
        let mut depth = 0_usize;
        while self.at < bytes.len() {
            match &bytes[self.at..bytes.len().min(self.at + 2)] {
                b"/*" => depth += 1,
                b"*/" => depth -= 1,
                _ => {
                    self.at += 1;
                    continue;
                }
            }
            self.at += 2;
            if depth == 0 {
                return;
            }
        }
        let span = Span::new(start, start + 2);
        self.report.add(syntax(span, "This comment is not closed.").label("expected a closing */"));
    }
    fn line_comment(&mut self) {
        self.take_while(|c| !is_newline(c));
    }
    /// `\`, spaces, perhaps a comment, and the end of the line.
    fn line_join(&mut self) {
        let start = self.at;
        self.at += 1;
        self.spaces_on_line();
        if self.starts_with("//") {
            self.line_comment();
        }
        match self.peek() {
            None => {}
            Some(c) if is_newline(c) => self.newline(c),
            Some(_) => {
                self.report.add(
                    syntax(Span::new(start, start + 1), "This \\ does not end its line.")
                        .label("expected a new line after it"),
                );
            }
        }
    }
    /// As [`Self::spaces`] without line joins.
    fn spaces_on_line(&mut self) {
        loop {
            self.take_while(|c| is_space(c) || is_forbidden(c));
            if !self.starts_with("/*") {
                return;
            }
            self.block_comment();
        }
    }
    fn newline(&mut self, c: char) {
        self.at += if self.starts_with("\r\n") { 2 } else { c.len_utf8() };
    }
    /// White space, comments and new lines.
    fn line_spaces(&mut self) {
        loop {
            self.spaces();
            match self.peek() {
                Some(c) if is_newline(c) => self.newline(c),
                Some('/') if self.starts_with("//") => self.line_comment(),
                _ => return,
            }
        }
    }

    /// Nodes up to the brace that closes `open`, or to the end of the file without `open`.
    fn block(&mut self, open: Option<Span>, depth: usize) -> Block<'t> {
        let start = open.map_or(self.at, |open| open.start as usize);
        let mut block = Block { nodes: Vec::new(), broken: false, span: self.since(start), closed: false };
        if let Some(open) = open.filter(|_| depth > MAX_NESTING) {
            let message = format!("Braces are nested more than {MAX_NESTING} levels deep.");
            self.refuse(draft("pathmarch::nesting", open, message).label("one level too many"));
            return block;
        }
        loop {
            self.line_spaces();
            let here = self.at;
            match self.peek() {
                None => {
                    if let Some(open) = open.filter(|_| !self.stopped) {
                        self.report.add(syntax(open, "This { is never closed.").label("expected a matching }"));
                        block.broken = true;
                    }
                    block.closed = open.is_none();
                    block.span = self.since(start);
                    return block;
                }
                Some('}') => {
                    self.at += 1;
                    if open.is_some() {
                        block.closed = true;
                        block.span = self.since(start);
                        return block;
                    }
                    let message = "This } closes nothing.";
                    self.report.add(syntax(self.since(here), message).label("no { is open here"));
                }
                Some('{') => {
                    self.at += 1;
                    let span = self.since(here);
                    self.report.add(
                        syntax(span, "Braces without a node.")
                            .label("expected a node's name before it")
                            .help("A brace opens on the same line as the node it belongs to."),
                    );
                    self.block(Some(span), depth + 1);
                    block.broken = true;
                }
                Some(';') => {
                    self.at += 1;
                    let message = "There is nothing before this semicolon.";
                    self.report.add(syntax(self.since(here), message).label("delete it"));
                }
                Some('/') if self.starts_with("/-") => {
                    self.at += 2;
                    let span = self.since(here);
                    self.line_spaces();
                    if matches!(self.peek(), None | Some('}' | '{' | ';')) {
                        self.nothing_commented_out(span);
                    } else {
                        self.commented_out += 1;
                        self.node(depth);
                        self.commented_out -= 1;
                    }
                }
                Some(_) => match self.node(depth) {
                    Some(node) => block.nodes.push(node),
                    None => block.broken = true,
                },
            }
        }
    }

    fn nothing_commented_out(&mut self, span: Span) {
        self.report.add(
            syntax(span, "This /- comments out nothing.").label("expected a node, an argument or braces after it"),
        );
    }

    /// One node with its end of line; `None` where it has no name that could be read.
    fn node(&mut self, depth: usize) -> Option<Node<'t>> {
        let first = self.at;
        self.annotation();
        self.spaces();
        let start = self.at;
        let name = match self.value() {
            Value::Text(value) => Some(Text { value, span: self.since(start) }),
            Value::Bad => None,
            _ => {
                self.report.add(
                    syntax(self.since(start), "A node cannot start with a value.").label("expected a node's name"),
                );
                None
            }
        };
        let span = self.since(start);
        self.count_item(span);
        let mut entries = Vec::new();
        let mut children = None;
        let mut closed = false;
        let mut whole = self.since(first);
        loop {
            let spaced = self.spaces();
            let here = self.at;
            match self.peek() {
                None | Some('}') => break,
                Some(';') => {
                    self.at += 1;
                    break;
                }
                Some(c) if is_newline(c) => {
                    self.newline(c);
                    break;
                }
                Some('/') if self.starts_with("//") => {
                    self.line_comment();
                    break;
                }
                Some('/') if self.starts_with("/-") => {
                    self.at += 2;
                    let span = self.since(here);
                    self.line_spaces();
                    match self.peek() {
                        None | Some('}' | ';') => self.nothing_commented_out(span),
                        Some('{') => {
                            self.at += 1;
                            let open = Span::new(self.at - 1, self.at);
                            self.commented_out += 1;
                            self.block(Some(open), depth + 1);
                            self.commented_out -= 1;
                            closed = true;
                        }
                        Some(_) => {
                            self.commented_out += 1;
                            self.entry();
                            self.commented_out -= 1;
                        }
                    }
                    whole = self.since(first);
                }
                Some('{') => {
                    self.at += 1;
                    let open = self.since(here);
                    let block = self.block(Some(open), depth + 1);
                    if children.is_some() {
                        self.report.add(
                            syntax(open, "This node has braces already.").label("put everything into the first ones"),
                        );
                    }
                    children.get_or_insert(block);
                    closed = true;
                    whole = self.since(first);
                }
                Some(_) if closed => {
                    self.report.add(
                        syntax(
                            Span::new(here, here + self.peek().map_or(0, char::len_utf8)),
                            "Something follows the braces of a node.",
                        )
                        .label("expected a new line or ; before it"),
                    );
                    break;
                }
                Some(_) => {
                    let entry = self.entry();
                    if !spaced && entry.value != Value::Bad {
                        self.report.add(syntax(entry.span, "A space is missing.").label("expected a space before it"));
                    }
                    entries.push(entry);
                    whole = self.since(first);
                }
            }
        }
        Some(Node { name: name?, entries, children, whole })
    }

    /// `(type)`, which no node or value of a scene has.
    fn annotation(&mut self) {
        if self.peek() != Some('(') {
            return;
        }
        let start = self.at;
        self.at += 1;
        self.spaces();
        let name_start = self.at;
        let name = if self.peek() == Some(')') { Value::Null } else { self.value() };
        self.spaces();
        if self.peek() == Some(')') {
            self.at += 1;
            if !matches!(name, Value::Text(_) | Value::Bad) {
                let message = "Parentheses hold the name of a type.";
                self.report.add(syntax(self.since(start), message).label("expected a name in it"));
            }
        } else if name != Value::Bad {
            let span = Span::new(start, self.at.max(name_start));
            self.report.add(syntax(span, "These parentheses are not closed.").label("expected a )"));
        }
        if self.commented_out == 0 {
            self.report.add(
                draft("pathmarch::annotation", self.since(start), "Scenes have no types.")
                    .label("a type in parentheses")
                    .help("Delete it."),
            );
        }
    }

    /// An argument or a property.
    fn entry(&mut self) -> Entry<'t> {
        let start = self.at;
        self.annotation();
        self.spaces();
        let value_start = self.at;
        let value = self.value();
        let value_span = self.since(value_start);
        self.count_item(value_span);
        let after_value = self.at;
        self.spaces();
        if self.peek() != Some('=') {
            self.at = after_value;
            return Entry { name: None, value, value_span, span: self.since(start) };
        }
        self.at += 1;
        let name = match value {
            Value::Text(value) => Some(Text { value, span: value_span }),
            Value::Bad => None,
            _ => {
                let message = "The name of a property cannot be a value.";
                self.report.add(syntax(value_span, message).label("expected a name before ="));
                None
            }
        };
        self.spaces();
        self.annotation();
        self.spaces();
        let value_start = self.at;
        let missing = self.peek().is_none_or(|c| is_newline(c) || matches!(c, ';' | '{' | '}'));
        let mut value = if missing { Value::Bad } else { self.value() };
        let value_span = self.since(value_start);
        if missing {
            self.report.add(syntax(self.since(start), "This property has no value.").label("expected a value after ="));
        }
        if name.is_none() {
            value = Value::Bad;
        }
        Entry { name, value, value_span, span: self.since(start) }
    }

    /// A string, a number or a keyword. Always takes at least one character, unless there is none.
    fn value(&mut self) -> Value<'t> {
        let start = self.at;
        match self.peek() {
            Some('"') => self.quoted(),
            Some('#') if self.rest().trim_start_matches('#').starts_with('"') => self.quoted(),
            Some('#') => {
                self.take_while(|c| c == '#');
                self.take_while(is_word);
                match &self.text[start..self.at] {
                    "#true" => Value::Bool(true),
                    "#false" => Value::Bool(false),
                    "#null" => Value::Null,
                    "#inf" => Value::Number(f64::INFINITY),
                    "#-inf" => Value::Number(f64::NEG_INFINITY),
                    "#nan" => Value::Number(f64::NAN),
                    word => {
                        let colour = word.len() > 3 && word[1..].chars().all(|c| c.is_ascii_hexdigit());
                        let help = match colour {
                            true => format!("Put a colour in quotes: \"{word}\"."),
                            false => "Words with # are #true, #false, #null, #inf, #-inf and #nan.".to_owned(),
                        };
                        let message = format!("{} is not a value.", shown(word));
                        self.report.add(syntax(self.since(start), message).label("unknown word").help(help));
                        Value::Bad
                    }
                }
            }
            Some(c) if is_word(c) => {
                let word = self.take_while(is_word);
                self.word(word, self.since(start))
            }
            None => {
                let message = "The file ends too early.";
                self.report.add(syntax(self.since(start), message).label("expected a name or a value"));
                Value::Bad
            }
            Some(c) => {
                self.at += c.len_utf8();
                self.take_while(|c| {
                    !is_space(c)
                        && !is_newline(c)
                        && !is_forbidden(c)
                        && !matches!(c, '{' | '}' | ';' | '"' | '/' | '=')
                });
                let message = format!("{} is not allowed here.", shown(&self.text[start..self.at]));
                self.report.add(
                    syntax(self.since(start), message)
                        .label("expected a name or a value")
                        .help("Put text with such characters in quotes."),
                );
                Value::Bad
            }
        }
    }

    fn word(&mut self, word: &'t str, span: Span) -> Value<'t> {
        if looks_like_number(word) {
            if let Some(value) = number(word) {
                return Value::Number(value);
            }
            let unsigned = word.trim_start_matches(['+', '-']);
            let help = if word.ends_with(',') {
                "Spaces separate numbers, commas do not."
            } else if unsigned.starts_with('.') {
                "Write a digit before the point, as in 0.5."
            } else if word.ends_with('.') {
                "Write a digit after the point, as in 1.0."
            } else {
                "Numbers look like 2, -0.5 or 1e-3; text that starts with a digit needs quotes."
            };
            self.report.add(syntax(span, format!("{} is not a number.", shown(word))).label("not a number").help(help));
            return Value::Bad;
        }
        if matches!(word, "true" | "false" | "null" | "inf" | "-inf" | "nan") {
            self.report.add(
                syntax(span, format!("`{word}` needs quotes, or a #."))
                    .label("neither a name nor a value")
                    .help(format!("Write \"{word}\" for the text, #{word} for the value.")),
            );
            return Value::Bad;
        }
        Value::Text(Cow::Borrowed(word))
    }
}
