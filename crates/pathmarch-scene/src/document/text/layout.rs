//! Layout of nodes on their lines: removal of nodes, and insertion in the style of the text around.
//!
//! A node in braces on one line is followed by `;`, one on a line of its own is indented like its siblings. Everything
//! here looks at the text around a node, never into strings: it starts at the end of a node or at a brace, and skips
//! comments as the reader does.

use super::patch::Patch;
use crate::language::characters::{is_newline, is_space};
use crate::language::tree::{Block, Node, Span};
use std::ops::Range;

/// The bytes of a span.
pub(crate) fn bytes(span: Span) -> Range<usize> {
    span.start as usize..span.end as usize
}

/// Start of the line that contains byte `at`.
pub(crate) fn line_start(text: &str, at: usize) -> usize {
    let start = text[..at].char_indices().rev().find(|(_, c)| is_newline(*c) || *c == '\u{feff}');
    start.map_or(0, |(index, c)| index + c.len_utf8())
}

/// White space at the start of that line.
pub(crate) fn indent(text: &str, at: usize) -> &str {
    let start = line_start(text, at);
    let line = &text[start..];
    &line[..line.find(|c| !is_space(c)).unwrap_or(line.len())]
}

/// True if only white space precedes byte `at` on its line.
pub(crate) fn starts_line(text: &str, at: usize) -> bool {
    text[line_start(text, at)..at].chars().all(is_space)
}

/// Start of the white space before byte `at`, within its line.
pub(crate) fn before_spaces(text: &str, at: usize) -> usize {
    text[..at].trim_end_matches(is_space).len()
}

fn after_spaces(text: &str, at: usize) -> usize {
    text.len() - text[at..].trim_start_matches(is_space).len()
}

/// End of the line break that starts at byte `at`.
fn after_newline(text: &str, at: usize) -> usize {
    let rest = &text[at..];
    match rest.chars().next() {
        Some('\r') if rest.starts_with("\r\n") => at + 2,
        Some(c) if is_newline(c) => at + c.len_utf8(),
        _ => at,
    }
}

/// Start of the line break that ends at byte `at`.
fn before_newline(text: &str, at: usize) -> usize {
    let before = &text[..at];
    before.strip_suffix("\r\n").or_else(|| before.strip_suffix(is_newline)).unwrap_or(before).len()
}

/// Rest of a line after a node or an opening brace.
pub(crate) struct Tail {
    /// End of the semicolon, if any.
    pub(crate) semicolon: Option<usize>,
    /// True if only comments follow on the line.
    pub(crate) ends_line: bool,
    /// End of the line, or start of what follows on it.
    pub(crate) end: usize,
    /// True if it contains a `//` comment.
    pub(crate) has_comment: bool,
}

/// Scans the line after a node that ends at byte `at`.
pub(crate) fn tail(text: &str, at: usize) -> Tail {
    let mut tail = Tail { semicolon: None, ends_line: true, end: at, has_comment: false };
    loop {
        tail.end = after_spaces(text, tail.end);
        let rest = &text[tail.end..];
        match rest.chars().next() {
            None => return tail,
            Some(c) if is_newline(c) => return tail,
            Some('/') if rest.starts_with("//") => {
                tail.end += rest.find(is_newline).unwrap_or(rest.len());
                tail.has_comment = true;
                return tail;
            }
            Some('/') if rest.starts_with("/*") => tail.end = after_comment(text, tail.end),
            Some('\\') => {
                // The line goes on in the next one.
                let join = self::tail(text, tail.end + 1);
                tail.end = after_newline(text, join.end);
            }
            Some(';') if tail.semicolon.is_none() => {
                tail.end += 1;
                tail.semicolon = Some(tail.end);
            }
            Some(_) => {
                tail.ends_line = false;
                return tail;
            }
        }
    }
}

/// End of the block comment that starts at byte `start`.
fn after_comment(text: &str, start: usize) -> usize {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (start, 0_usize);
    while at < bytes.len() {
        match &bytes[at..bytes.len().min(at + 2)] {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            break;
        }
    }
    at
}

/// Start of the comment lines directly above a node, or of the node's own line without any. `from` is the end of what
/// precedes the node.
fn lead(text: &str, from: usize, node: usize) -> usize {
    let own = line_start(text, node);
    let mut first = None;
    let mut at = after_newline(text, from);
    while at < own {
        let start = after_spaces(text, at);
        let rest = &text[start..];
        let end = match rest.chars().next() {
            Some('/') if rest.starts_with("//") => start + rest.find(is_newline).unwrap_or(rest.len()),
            Some('/') if rest.starts_with("/*") => after_spaces(text, after_comment(text, start)),
            _ => start,
        };
        if !text[end..].starts_with(is_newline) {
            // Something commented out, or a continued line: its node is unknown.
            return own;
        }
        first = if end > start { first.or(Some(at)) } else { None };
        at = after_newline(text, end);
    }
    first.unwrap_or(own)
}

/// Layout of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Style {
    /// Line break.
    pub(crate) newline: &'static str,
    /// Indentation of one level of braces.
    pub(crate) unit: String,
}

impl Style {
    /// The style of a text: that of its first line end, and of the first line in braces.
    pub(crate) fn of(text: &str, file: Option<&Block>) -> Self {
        let newline = match text.find('\n') {
            Some(at) if text[..at].ends_with('\r') => "\r\n",
            _ => "\n",
        };
        let nodes = file.map_or(&[][..], |file| &file.nodes);
        let indented = nodes.iter().find_map(|node| {
            let first = node.child_nodes().first()?.whole.start as usize;
            let outer = indent(text, node.whole.start as usize);
            let inner = indent(text, first).strip_prefix(outer)?;
            (starts_line(text, first) && !inner.is_empty()).then(|| inner.to_owned())
        });
        Self { newline, unit: indented.unwrap_or_else(|| "    ".to_owned()) }
    }
}

/// Text of one or more nodes, to be inserted.
#[derive(Clone, Debug)]
pub(crate) struct Chunk {
    /// Lines, without the indentation of the first.
    text: String,
    /// Indentation of all lines but the first.
    base: String,
    /// Starts of lines in `text` that are inside a string and must not be indented.
    fixed: Vec<usize>,
    /// True if it needs lines of its own.
    pub(crate) needs_lines: bool,
    /// True if a blank line goes before it.
    apart: bool,
}

impl Chunk {
    /// A new node: `\n` is a line break and `\t` a level of braces.
    pub(crate) fn new(template: &str, style: &Style) -> Self {
        let text = template.replace('\t', &style.unit).replace('\n', style.newline);
        let needs_lines = template.contains('\n');
        Self { text, base: String::new(), fixed: Vec::new(), needs_lines, apart: false }
    }
    /// A node with its text; with its comments, if it has lines of its own.
    pub(crate) fn of(text: &str, site: &Site, comments: bool) -> Self {
        let whole = bytes(site.node().whole);
        let range = if comments { site.range(text) } else { whole.clone() };
        let base = indent(text, whole.start).to_owned();
        let mut chunk = Self::piece(text, range.clone(), base, std::slice::from_ref(site.node()));
        chunk.needs_lines |= range.len() > whole.len() && chunk.text.contains("//");
        chunk
    }
    /// A piece of the text that has the indentation `base`, and the nodes in it.
    pub(crate) fn piece(text: &str, range: Range<usize>, base: String, nodes: &[Node]) -> Self {
        let mut fixed = Vec::new();
        for node in nodes {
            strings(node, &mut |span| {
                let string = bytes(span);
                let breaks = text[string.clone()].match_indices(is_newline).map(|(at, c)| string.start + at + c.len());
                fixed.extend(breaks.filter(|at| range.contains(at)).map(|at| at - range.start));
            });
        }
        let text = text[range].to_owned();
        let needs_lines = text.contains(is_newline);
        Self { text, base, fixed, needs_lines, apart: false }
    }
    /// An operator around several nodes, each on a line of its own if `lines`.
    pub(crate) fn wrapped(word: &str, chunks: &[Self], lines: bool, style: &Style) -> Self {
        let needs_lines = lines || chunks.iter().any(|chunk| chunk.needs_lines);
        let mut wrapped =
            Self { text: format!("{word} {{"), base: String::new(), fixed: Vec::new(), needs_lines, apart: false };
        for (index, chunk) in chunks.iter().enumerate() {
            let between = match (needs_lines, index) {
                (true, _) => format!("{}{}", style.newline, style.unit),
                (false, 0) => " ".to_owned(),
                (false, _) => "; ".to_owned(),
            };
            wrapped.text.push_str(&between);
            chunk.indented_into(&style.unit, &mut wrapped.text, &mut wrapped.fixed);
        }
        wrapped.text.push_str(if needs_lines { style.newline } else { " " });
        wrapped.text.push('}');
        wrapped
    }
    /// The same with a blank line before it, where it has lines to itself.
    pub(crate) fn apart(mut self, apart: bool) -> Self {
        self.apart = apart;
        self
    }
    /// The chunk with a piece of it replaced, on its first line.
    pub(crate) fn with(mut self, patch: &Patch) -> Self {
        self.text.replace_range(patch.range.clone(), &patch.text);
        for at in self.fixed.iter_mut().filter(|at| **at >= patch.range.end) {
            *at = *at + patch.text.len() - patch.range.len();
        }
        self
    }
    /// Its text with another indentation.
    pub(crate) fn indented(&self, indent: &str) -> String {
        let mut text = String::with_capacity(self.text.len());
        self.indented_into(indent, &mut text, &mut Vec::new());
        text
    }
    fn indented_into(&self, indent: &str, text: &mut String, fixed: &mut Vec<usize>) {
        let mut start = 0;
        while start < self.text.len() {
            let line = &self.text[start..];
            let length = line.find(is_newline).map_or(line.len(), |end| after_newline(line, end));
            let line = &line[..length];
            let in_string = self.fixed.contains(&start);
            if in_string {
                fixed.push(text.len());
            }
            match line.strip_prefix(&*self.base) {
                Some(rest) if start > 0 && !in_string && !rest.trim().is_empty() => {
                    text.push_str(indent);
                    text.push_str(rest);
                }
                _ => text.push_str(line),
            }
            start += length;
        }
    }
}

/// Calls `each` with the spans of all names and values in a node, which may contain line breaks.
fn strings(node: &Node, each: &mut impl FnMut(Span)) {
    each(node.name.span);
    for entry in &node.entries {
        each(entry.span);
    }
    for child in node.child_nodes() {
        strings(child, each);
    }
}

/// A node among its siblings.
pub(crate) struct Site<'n> {
    /// Block that contains it.
    pub(crate) block: &'n Block<'static>,
    /// True if that is the file.
    pub(crate) top: bool,
    /// Index in the block.
    pub(crate) index: usize,
}

impl Site<'_> {
    pub(crate) fn node(&self) -> &Node<'static> {
        &self.block.nodes[self.index]
    }
    /// End of what precedes it.
    fn from(&self, text: &str) -> usize {
        match self.index.checked_sub(1) {
            Some(before) => tail(text, self.block.nodes[before].whole.end as usize).end,
            None if self.top => self.block.span.start as usize,
            None => tail(text, self.block.span.start as usize + 1).end,
        }
    }
    /// The node with its comments, without indentation of the first line: those of its lines if it has them to itself, else
    /// those before its semicolon.
    pub(crate) fn range(&self, text: &str) -> Range<usize> {
        if let Some(lines) = self.lines(text) {
            return after_spaces(text, lines.start)..before_spaces(text, lines.end);
        }
        let whole = bytes(self.node().whole);
        match tail(text, whole.end).semicolon {
            Some(semicolon) if !text[whole.end..semicolon].contains(is_newline) => {
                whole.start..before_spaces(text, semicolon - 1)
            }
            _ => whole,
        }
    }
    /// Lines of its own: comments directly above, the node, and the rest of its last line, without the last line break.
    /// `None` if it shares a line.
    pub(crate) fn lines(&self, text: &str) -> Option<Range<usize>> {
        let whole = bytes(self.node().whole);
        let tail = tail(text, whole.end);
        (starts_line(text, whole.start) && tail.ends_line).then(|| lead(text, self.from(text), whole.start)..tail.end)
    }

    /// Removes the node; with the comment lines above it if `comments`.
    pub(crate) fn removal(&self, text: &str, comments: bool) -> Patch {
        let whole = bytes(self.node().whole);
        let behind = tail(text, whole.end);
        if let Some(lines) = self.lines(text) {
            let start = if comments { lines.start } else { line_start(text, whole.start) };
            let end = after_newline(text, lines.end);
            let above = before_newline(text, start);
            if end == lines.end {
                // The last line of a file without a new line at its end.
                return Patch::remove(above..end);
            }
            // Of the blank lines around it one stays, and none next to a brace.
            let next = after_spaces(text, end);
            let next_blank = text[next..].starts_with(is_newline);
            let above_blank = above == start || starts_line(text, above);
            if next_blank && (above_blank || text[..start].trim_end().ends_with('{')) {
                return Patch::remove(start..after_newline(text, next));
            }
            if above_blank && text[next..].starts_with('}') {
                return Patch::remove(line_start(text, above)..end);
            }
            return Patch::remove(start..end);
        }
        let space = before_spaces(text, whole.start);
        let preceded = text[..space].ends_with(';') && self.index > 0;
        let own_line = starts_line(text, whole.start);
        match behind.semicolon {
            // The next node takes its place.
            Some(semicolon) if !behind.ends_line => Patch::remove(whole.start..after_spaces(text, semicolon)),
            _ if own_line => Patch::remove(whole.start..after_spaces(text, whole.end)),
            _ => {
                let end = behind.semicolon.unwrap_or(whole.end);
                Patch::remove(if preceded { space - 1 } else { space }..end)
            }
        }
    }

    /// Puts a chunk behind the node.
    pub(crate) fn insert_behind(&self, text: &str, chunk: &Chunk, style: &Style) -> Patch {
        let whole = bytes(self.node().whole);
        let behind = tail(text, whole.end);
        let own_line = starts_line(text, whole.start);
        let indent = self.indent(text, style);
        let newline = style.newline;
        if behind.ends_line {
            let piece = chunk.indented(&indent);
            let blank = if chunk.apart { newline } else { "" };
            return Patch::insert(behind.end, format!("{blank}{newline}{indent}{piece}"));
        }
        let at = behind.semicolon.unwrap_or_else(|| before_spaces(text, behind.end));
        let rest = after_spaces(text, at);
        let last = text[rest..].starts_with('}');
        if chunk.needs_lines {
            let piece = chunk.indented(&indent);
            let outer = if last { self.outer_indent(text).to_owned() } else { indent.clone() };
            return Patch::replace(at..rest, format!("{newline}{indent}{piece}{newline}{outer}"));
        }
        let piece = chunk.indented("");
        Patch::insert(
            at,
            match behind.semicolon {
                Some(_) => format!(" {piece};"),
                None if own_line && self.several_lines(text) => format!("{newline}{indent}{piece}"),
                None => format!("; {piece}"),
            },
        )
    }

    fn several_lines(&self, text: &str) -> bool {
        text[bytes(self.block.span)].contains(is_newline)
    }
    /// Indentation of the line that its braces begin on.
    fn outer_indent<'x>(&self, text: &'x str) -> &'x str {
        if self.top { "" } else { indent(text, self.block.span.start as usize) }
    }
    /// Indentation of a sibling on a line of its own.
    pub(crate) fn indent(&self, text: &str, style: &Style) -> String {
        inner_indent(text, self.block, self.top, Some(self.index), style)
    }
}

/// Indentation of nodes on lines of their own in a block; like that of the node `like`, if it has a line of its own.
fn inner_indent(text: &str, block: &Block, top: bool, like: Option<usize>, style: &Style) -> String {
    let on_line = |node: &&Node| starts_line(text, node.whole.start as usize);
    let like = like.and_then(|index| block.nodes.get(index)).filter(on_line);
    match like.or_else(|| block.nodes.iter().find(on_line)) {
        Some(node) => indent(text, node.whole.start as usize).to_owned(),
        None if top => String::new(),
        None => format!("{}{}", indent(text, block.span.start as usize), style.unit),
    }
}

/// Puts a chunk before everything in a node's braces, which are made if there are none.
pub(crate) fn insert_first(text: &str, node: &Node<'static>, chunk: &Chunk, style: &Style) -> Patch {
    let newline = style.newline;
    let Some(block) = &node.children else {
        let at = node.whole.end as usize;
        if !chunk.needs_lines {
            return Patch::insert(at, format!(" {{ {} }}", chunk.indented("")));
        }
        let outer = indent(text, node.whole.start as usize);
        let inner = format!("{outer}{}", style.unit);
        let piece = chunk.indented(&inner);
        return Patch::insert(at, format!(" {{{newline}{inner}{piece}{newline}{outer}}}"));
    };
    let open = block.span.start as usize + 1;
    let interior = open..block.span.end as usize - 1;
    let outer = indent(text, block.span.start as usize);
    let inner = inner_indent(text, block, false, Some(0), style);
    let empty = text[interior.clone()].trim().is_empty();
    let several_lines = text[interior.clone()].contains(is_newline);
    if empty && (chunk.needs_lines || several_lines) {
        let piece = chunk.indented(&inner);
        return Patch::replace(interior, format!("{newline}{inner}{piece}{newline}{outer}"));
    }
    if empty {
        return Patch::replace(interior, format!(" {} ", chunk.indented("")));
    }
    let behind = tail(text, open);
    let piece = chunk.indented(&inner);
    if behind.ends_line {
        return Patch::insert(behind.end, format!("{newline}{inner}{piece}"));
    }
    if chunk.needs_lines {
        return Patch::replace(open..after_spaces(text, open), format!("{newline}{inner}{piece}{newline}{inner}"));
    }
    Patch::insert(open, format!(" {};", chunk.indented("")))
}
