//! Parsing of the one node that an edit has changed, in place of the whole text.
//!
//! **Idea.** While a slider is dragged, a few bytes change, all within the name, arguments and properties of one node. Only
//! these are parsed, and the spans of everything behind them are shifted: a hundredth of the time for 1,000 shapes.
//!
//! **Limits.** Refused where more might change: see [`reparse`]. The text is then parsed as a whole.

use super::read;
use crate::language::diagnostics::report::Report;
use crate::language::tree::{Block, Entry, Node, Span, Text};
use std::borrow::Cow;
use std::ops::Range;

/// The name and entries of a node of a file, which [`Header::swap`] exchanges with those in the file.
pub(crate) struct Header {
    /// Indexes of the nodes around the node, and its own.
    path: Vec<usize>,
    /// How it differs from that in the file.
    pub(crate) change: Change,
    name: Text<'static>,
    entries: Vec<Entry<'static>>,
}

/// Difference between two nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change {
    /// They differ in layout.
    Nothing,
    /// They differ in numbers.
    Numbers,
    /// They differ in names, strings or kinds of values.
    Words,
}

impl Change {
    fn between(a: &Node, b: &Node) -> Self {
        let mut pairs = a.entries.iter().zip(&b.entries);
        match a.name.value == b.name.value {
            true if pairs.clone().all(|(a, b)| a.is_same(b)) => Self::Nothing,
            true if pairs.all(|(a, b)| a.is_same_but_for_number(b)) => Self::Numbers,
            _ => Self::Words,
        }
    }
}

/// Parses the name and entries of the node that contains the bytes `old` of the text of `file`, which are `new` in `text`.
///
/// `None` if these bytes are not within the name and entries of one node, if they make a mistake, or if the number of entries
/// changes. There must be no mistake in the text of `file`.
pub(crate) fn reparse(file: &Block<'static>, text: &str, old: &Range<usize>, new: &Range<usize>) -> Option<Header> {
    let (path, node) = node_around(file, old)?;
    let before = node.span();
    let end = (before.end as usize + new.end).checked_sub(old.end)?;
    let header = text.get(before.start as usize..end)?;
    let mut report = Report::new("", header);
    let mut parsed = read(header, &mut report)?;
    let [parsed_node] = parsed.nodes.as_slice() else { return None };
    let all = Span::new(0, header.len());
    let is_whole = parsed_node.children.is_none() && parsed_node.span() == all && parsed_node.whole == all;
    if report.has_mistakes() || !is_whole || parsed_node.entries.len() != node.entries.len() {
        return None;
    }
    let change = Change::between(node, parsed_node);
    parsed.shift(before.start);
    let Node { name, entries, .. } = parsed.into_owned().nodes.pop()?;
    Some(Header { path, change, name, entries })
}

/// The node whose name and entries contain these bytes, and the indexes that lead to it.
fn node_around<'b>(file: &'b Block<'static>, bytes: &Range<usize>) -> Option<(Vec<usize>, &'b Node<'static>)> {
    let mut path = Vec::new();
    let mut block = file;
    loop {
        let index = block.nodes.partition_point(|node| (node.whole.end as usize) < bytes.end);
        let node = block.nodes.get(index)?;
        path.push(index);
        let header = node.span();
        if header.start as usize <= bytes.start && bytes.end <= header.end as usize {
            return Some((path, node));
        }
        block = node.children.as_ref()?;
    }
}

impl Header {
    /// Exchanges the name and entries with those of the node in the file, and shifts the spans of what is behind them. The
    /// second call undoes the first.
    pub(crate) fn swap(&mut self, file: &mut Block<'static>) {
        let Some(node) = self.node(file) else { return };
        let before = node.span();
        let gap = Text { value: Cow::Borrowed(""), span: Span::new(0, 0) };
        let (name, entries) = (std::mem::replace(&mut node.name, gap), std::mem::take(&mut node.entries));
        let (name, entries) = (std::mem::replace(&mut self.name, name), std::mem::replace(&mut self.entries, entries));
        let end = entries.last().map_or(name.span, |last| last.span).end;
        file.shift_behind(before.end, i64::from(end) - i64::from(before.end));
        if let Some(node) = self.node(file) {
            (node.name, node.entries) = (name, entries);
        }
    }

    /// The node in the file.
    fn node<'b>(&self, file: &'b mut Block<'static>) -> Option<&'b mut Node<'static>> {
        let (last, around) = self.path.split_last()?;
        let block = around.iter().try_fold(file, |block, &index| block.nodes.get_mut(index)?.children.as_mut())?;
        block.nodes.get_mut(*last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "scene 1\ncamera { at 0 1.5 6; fov 40 } // comment\nball \"r b\" x=2 { at 1 \\\n 2 /* c */ 3; /- f 1; u }\n\
        g name=#true 1 /-2 { h #\"raw\"#; i { j -1e3; k } };l\n";

    /// Nodes of a text without mistakes, and how they print with all spans.
    fn parsed(text: &str) -> Option<(Block<'static>, String)> {
        let mut report = Report::new("", text);
        let file = read(text, &mut report)?.into_owned();
        let printed = format!("{file:?}");
        (!report.has_mistakes()).then_some((file, printed))
    }

    #[test]
    fn every_small_edit_gives_the_nodes_of_the_whole_text() {
        let (mut file, before) = parsed(TEXT).expect("no mistakes");
        let others =
            ["", "7", " 8", "x", "\"q\"", "=", "y=1", ";", "{", "}", "//", "/*", "*/", "/-", "\n", "\\", "#true", "é"];
        let mut counts = [0; 3];
        for start in 0..TEXT.len() {
            for end in start..TEXT.len().min(start + 4) {
                for other in others {
                    let text = [&TEXT[..start], other, &TEXT[end..]].concat();
                    let Some(mut header) = reparse(&file, &text, &(start..end), &(start..start + other.len())) else {
                        continue;
                    };
                    counts[header.change as usize] += 1;
                    header.swap(&mut file);
                    let (whole, printed) = parsed(&text).unwrap_or_else(|| panic!("a mistake in {text}"));
                    assert_eq!(format!("{file:?}"), printed, "{text}");
                    header.swap(&mut file);
                    assert_eq!(format!("{file:?}"), before, "{text}");
                    assert_eq!(header.change == Change::Nothing, whole.has_same_nodes(&file), "{text}");
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
    }
}
