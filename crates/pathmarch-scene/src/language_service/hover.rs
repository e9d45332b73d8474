//! Help on the word at a place.

use super::OpenText;
use super::declarations::param_entry;
use super::locate::{Located, Part, locate, owners_in, owners_of};
use crate::language::formulas::expression::is_name;
use crate::language::keywords::MATERIAL;
use crate::language::tree::{Entry as Written, Span, Value};
use crate::reference::{self, Entry, IN_OBJECTS, parameter_entry};
use pathmarch_field::{Solid, registry};
use std::ops::Range;

/// Help on a word.
#[derive(Clone, Debug, PartialEq)]
pub struct Hover {
    /// Bytes of the word.
    pub range: Range<usize>,
    /// Its meanings.
    pub meanings: Vec<Entry>,
}

impl OpenText {
    /// Help on the word at byte `at`: what the reference says of it, or its declaration.
    pub fn hover(&self, at: usize) -> Option<Hover> {
        let located = locate(self.file.as_ref()?, at)?;
        let (span, meanings) = match located.part {
            Part::Name => (located.node.name.span, self.node_meanings(&located)),
            Part::Property(entry) => {
                (entry.name.as_ref()?.span, self.property_meaning(&located, entry).into_iter().collect())
            }
            Part::Value(entry) => (entry.value_span, self.value_meanings(&located, entry, at)),
        };
        let Span { start, end } = span;
        (!meanings.is_empty()).then_some(Hover { range: start as usize..end as usize, meanings })
    }

    fn node_meanings(&self, located: &Located) -> Vec<Entry> {
        let name = &*located.node.name.value;
        let declared = if located.parents.is_empty() { None } else { self.declared_solid(name) };
        declared.map_or_else(|| reference::entries_of(name, &owners_in(&located.parents)), |entry| vec![entry])
    }

    fn property_meaning(&self, located: &Located, entry: &Written) -> Option<Entry> {
        let name = &*entry.name.as_ref()?.value;
        let mut owners = owners_of(located.node);
        owners.extend(owners_in(&located.parents));
        let declared =
            || self.declared("shape", &located.node.name.value).or(self.declared("field", &located.node.name.value));
        let param = || declared().and_then(|node| self.parameter(name, &[node])).and_then(param_entry);
        reference::property(name, &owners[..1])
            .filter(|_| name != MATERIAL)
            .or_else(param)
            .or_else(|| reference::property(name, &owners))
    }

    fn value_meanings(&self, located: &Located, entry: &Written<'static>, at: usize) -> Vec<Entry> {
        if let (Some(name), Value::Text(text)) = (&entry.name, &entry.value)
            && name.value == MATERIAL
        {
            return self.declared_material(text).into_iter().collect();
        }
        let parameter = || {
            let word = word_at(&self.text, entry.value_span, at)?;
            param_entry(self.parameter(word, &located.parents)?)
        };
        if let Some(found) = parameter().or_else(|| self.property_meaning(located, entry)) {
            return vec![found];
        }
        match argument(located, entry) {
            Some(found) => vec![found],
            None => self.node_meanings(located),
        }
    }
}

/// The name of a formula at byte `at` of a text.
pub(super) fn word_at(text: &str, span: Span, at: usize) -> Option<&str> {
    let value = text.get(span.start as usize..span.end as usize)?;
    let at = at.checked_sub(span.start as usize)?;
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let start = at - value.get(..at)?.chars().rev().take_while(|c| is_part(*c)).map(char::len_utf8).sum::<usize>();
    let end = at + value[at..].chars().take_while(|c| is_part(*c)).map(char::len_utf8).sum::<usize>();
    Some(&value[start..end]).filter(|word| is_name(word))
}

/// Meaning of an argument of a shape or an operator.
fn argument(located: &Located, entry: &Written) -> Option<Entry> {
    let solid = registry::solid(&located.node.name.value).filter(|_| !located.parents.is_empty())?;
    let arguments = located.node.entries.iter().filter(|entry| entry.name.is_none());
    let (index, count) = (arguments.clone().position(|other| other.span == entry.span)?, arguments.count());
    let sizes = solid.info().size_params;
    // One size stands for the first parameters.
    let slot = if sizes > 1 && count < sizes && index > 0 { index + sizes - 1 } else { index };
    let param =
        solid.params().get(slot).filter(|_| !matches!(solid, Solid::Shape(shape) if shape.info().outline.is_some()))?;
    let entry = parameter_entry(IN_OBJECTS, param);
    Some(Entry { title: format!("{} of `{}`", entry.title, solid.info().name), ..entry })
}
