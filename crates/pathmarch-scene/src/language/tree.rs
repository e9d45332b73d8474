//! Tree of nodes, which [`super::syntax`] parses. Names and strings borrow from the text where possible.

use miette::SourceSpan;
use std::borrow::Cow;

/// Bytes `start..end` of the text, which is below 4 GiB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) start: u32,
    pub(crate) end: u32,
}

impl Span {
    pub(crate) fn new(start: usize, end: usize) -> Self {
        Self { start: start as u32, end: end as u32 }
    }
    /// Span from the start of this one to the end of `last`.
    pub(crate) fn to(self, last: Self) -> Self {
        Self { start: self.start, end: last.end.max(self.end) }
    }
}

impl From<Span> for SourceSpan {
    fn from(span: Span) -> Self {
        (span.start as usize..span.end as usize).into()
    }
}

/// A string with its span, quotes included.
#[derive(Clone, Debug)]
pub(crate) struct Text<'t> {
    pub(crate) value: Cow<'t, str>,
    pub(crate) span: Span,
}

/// Value of an argument or a property.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value<'t> {
    Text(Cow<'t, str>),
    Number(f64),
    Bool(bool),
    Null,
    /// Already reported as a mistake.
    Bad,
}

/// An argument, or a property where it has a name.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'t> {
    pub(crate) name: Option<Text<'t>>,
    pub(crate) value: Value<'t>,
    /// Span of the value alone.
    pub(crate) value_span: Span,
    pub(crate) span: Span,
}

/// `name argument property=value { children }`
#[derive(Clone, Debug)]
pub(crate) struct Node<'t> {
    pub(crate) name: Text<'t>,
    pub(crate) entries: Vec<Entry<'t>>,
    pub(crate) children: Option<Block<'t>>,
    /// Span of the whole node, including braces and anything that `/-` comments out after its name.
    pub(crate) whole: Span,
}

/// The nodes between braces, or those of the file.
#[derive(Clone, Debug)]
pub(crate) struct Block<'t> {
    pub(crate) nodes: Vec<Node<'t>>,
    /// True if a node in it could not be read, so that something may seem to be missing.
    pub(crate) broken: bool,
    /// Span of the braces and their contents; for the file, all of it without a byte order mark.
    pub(crate) span: Span,
    /// True if its closing brace exists.
    pub(crate) closed: bool,
}

impl<'t> Node<'t> {
    /// Span of the name, arguments and properties, without braces.
    pub(crate) fn span(&self) -> Span {
        self.entries.last().map_or(self.name.span, |last| self.name.span.to(last.span))
    }
    /// The nodes in its braces, none without braces.
    pub(crate) fn child_nodes(&self) -> &[Node<'t>] {
        self.children.as_ref().map_or(&[], |block| &block.nodes)
    }
    /// True if its braces, or something in them, could not be read.
    pub(crate) fn broken(&self) -> bool {
        match &self.children {
            Some(block) => block.broken,
            None => self.entries.iter().any(|entry| entry.value == Value::Bad),
        }
    }
}

fn owned(text: Cow<str>) -> Cow<'static, str> {
    Cow::Owned(text.into_owned())
}

impl Text<'_> {
    fn into_owned(self) -> Text<'static> {
        Text { value: owned(self.value), span: self.span }
    }
}

impl Entry<'_> {
    /// Name and value, without spans.
    fn content(&self) -> (Option<&str>, &Value<'_>) {
        (self.name.as_ref().map(|name| &*name.value), &self.value)
    }
    /// True if both have the same name and value, wherever in a text they are.
    pub(crate) fn is_same(&self, other: &Entry) -> bool {
        self.content() == other.content()
    }
    /// [`Self::is_same`], where all numbers count as one.
    pub(crate) fn is_same_but_for_number(&self, other: &Entry) -> bool {
        let (a, b) = (self.content(), other.content());
        a == b || a.0 == b.0 && matches!((a.1, b.1), (Value::Number(_), Value::Number(_)))
    }
    fn into_owned(self) -> Entry<'static> {
        let value = match self.value {
            Value::Text(text) => Value::Text(owned(text)),
            Value::Number(number) => Value::Number(number),
            Value::Bool(value) => Value::Bool(value),
            Value::Null => Value::Null,
            Value::Bad => Value::Bad,
        };
        Entry { name: self.name.map(Text::into_owned), value, value_span: self.value_span, span: self.span }
    }
}

impl Block<'_> {
    /// Shifts all spans, for a text that follows another.
    pub(crate) fn shift(&mut self, by: u32) {
        self.move_spans(&|at| at + by);
    }
    /// Shifts what is at byte `from` or behind it, for a text that became longer before that, or shorter.
    pub(crate) fn shift_behind(&mut self, from: u32, by: i64) {
        self.move_spans(&|at| if at < from { at } else { (i64::from(at) + by) as u32 });
    }
    /// Moves the starts and ends of all spans.
    fn move_spans(&mut self, place: &impl Fn(u32) -> u32) {
        let moved = |span: &mut Span| *span = Span { start: place(span.start), end: place(span.end) };
        moved(&mut self.span);
        for node in &mut self.nodes {
            moved(&mut node.name.span);
            moved(&mut node.whole);
            for entry in &mut node.entries {
                moved(&mut entry.span);
                moved(&mut entry.value_span);
                entry.name.iter_mut().for_each(|name| moved(&mut name.span));
            }
            node.children.iter_mut().for_each(|block| block.move_spans(place));
        }
    }
    /// True if both contain the same nodes, wherever in a text these are.
    pub(crate) fn has_same_nodes(&self, other: &Block) -> bool {
        let same = |(a, b): (&Node, &Node)| {
            let entries = a.entries.iter().map(Entry::content).eq(b.entries.iter().map(Entry::content));
            let children = match (&a.children, &b.children) {
                (Some(a), Some(b)) => a.has_same_nodes(b),
                (a, b) => a.is_none() && b.is_none(),
            };
            a.name.value == b.name.value && entries && children
        };
        self.nodes.len() == other.nodes.len() && self.nodes.iter().zip(&other.nodes).all(same)
    }
    /// The same without the text.
    pub(crate) fn into_owned(self) -> Block<'static> {
        let nodes = self.nodes.into_iter().map(|node| Node {
            name: node.name.into_owned(),
            entries: node.entries.into_iter().map(Entry::into_owned).collect(),
            children: node.children.map(Block::into_owned),
            whole: node.whole,
        });
        Block { nodes: nodes.collect(), broken: self.broken, span: self.span, closed: self.closed }
    }
}
