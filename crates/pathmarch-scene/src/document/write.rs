//! Parameters into the text: the few bytes that say the value.
//!
//! What stands there is replaced in its own style: a number at its place, an argument stays an argument and a property a
//! property, three numbers one by one where they differ, a colour as `"#rrggbb"` while that can say it. What is missing is
//! added: an argument if all before it are given, else a property; a node in braces behind those that are there.

use super::control::{ControlKind, NumberRange, Value};
use super::error::EditError;
use super::layout::{Chunk, Site, Style, before_spaces, bytes, insert_first, starts_line, tail};
use super::number::{formula, fresh, number, quoted, string_like};
use super::patch::Patch;
use super::slots::{
    Place, Slot, arguments, child, formula_text, has_one_size, number_arguments, parameter_value, property, read_number,
};
use crate::language::arguments::{Range, srgb};
use crate::language::characters;
use crate::language::fields::Fields;
use crate::language::tree::{self, Entry, Node};
use pathmarch_field::Outline;
use pathmarch_field::Solid;

/// A node and the text that it stands in.
#[derive(Clone, Copy)]
pub(super) struct Writer<'d> {
    pub(super) text: &'d str,
    pub(super) style: &'d Style,
    pub(super) node: &'d Node<'static>,
    pub(super) fields: &'d Fields,
}

/// Whether the control takes this value.
pub(super) fn check(slot: &Slot, value: &Value) -> Result<(), EditError> {
    let control = &slot.control;
    let label = || control.label.to_string();
    let wrong = |expected: &str| Err(EditError::WrongValue { label: label(), expected: expected.to_owned() });
    let out = |range: String| Err(EditError::OutOfRange { label: label(), range });
    match (&control.kind, value) {
        (ControlKind::Number(range), Value::Number(value)) if !range.accepts(*value) => out(range.in_words()),
        (ControlKind::Triple { .. } | ControlKind::Colour { .. }, Value::Triple(values) | Value::Colour(values))
            if !values.iter().all(|value| value.is_finite()) =>
        {
            out("finite numbers".to_owned())
        }
        (ControlKind::Triple { direction: true }, Value::Triple([0.0, 0.0, 0.0])) => {
            out("a direction, of any length but 0".to_owned())
        }
        (ControlKind::Colour { max }, Value::Colour(values)) => match Range::from_to(0.0, *max) {
            range if values.iter().all(|value| range.accepts(*value)) => Ok(()),
            range => out(format!("a colour with every channel {}", range.in_words())),
        },
        (ControlKind::Size { min, max }, Value::Size(size)) => {
            match size.iter().all(|side| (min..=max).contains(&side)) {
                true => Ok(()),
                false => out(format!("whole numbers from {min} to {max}")),
            }
        }
        (ControlKind::Choice(words), Value::Text(text)) if !words.iter().any(|word| word == text) => {
            out(format!("one of {}", words.join(", ")))
        }
        (ControlKind::Material(names), Value::Text(text)) if !names.contains(text) => {
            out(format!("the name of a material, and there is none called {text}"))
        }
        (ControlKind::Text | ControlKind::Picture, Value::Text(text)) if text.is_empty() => {
            Err(EditError::Name(format!("`{}` must not be empty.", control.label)))
        }
        (_, Value::Formulas(texts)) if texts.iter().any(|text| text.trim().is_empty()) => {
            Err(EditError::Name(format!("`{}` must not be empty.", control.label)))
        }
        (ControlKind::Number(_), Value::Formulas(texts)) if texts.len() == 1 => Ok(()),
        (ControlKind::Triple { .. }, Value::Formulas(texts)) if texts.len() == 3 => Ok(()),
        (ControlKind::Colour { .. }, Value::Formulas(texts)) if matches!(texts.len(), 1 | 3) => Ok(()),
        (ControlKind::Size { .. }, Value::Formulas(texts)) if texts.len() == 2 => Ok(()),
        (ControlKind::Number(_), Value::Number(_))
        | (ControlKind::Triple { .. }, Value::Triple(_))
        | (
            ControlKind::Choice(_) | ControlKind::Text | ControlKind::Picture | ControlKind::Material(_),
            Value::Text(_),
        )
        | (ControlKind::Flag, Value::Flag(_)) => Ok(()),
        (ControlKind::Number(_), _) => wrong("a number"),
        (ControlKind::Triple { .. }, _) => wrong("three numbers"),
        (ControlKind::Colour { .. }, _) => wrong("a colour"),
        (ControlKind::Size { .. }, _) => wrong("a width and a height"),
        (ControlKind::Flag, _) => wrong("yes or no"),
        _ => wrong("a text"),
    }
}

/// The numbers of a value, in order.
fn numbers_of(value: &Value) -> Option<Vec<f32>> {
    match value {
        Value::Number(number) => Some(vec![*number]),
        Value::Triple(numbers) | Value::Colour(numbers) => Some(numbers.to_vec()),
        Value::Size(size) => Some(size.map(|side| side as f32).to_vec()),
        _ => None,
    }
}

/// A value that loses no formula: where the control has formulas, numbers that are what these are worth leave them as they
/// are, and others are refused. Only texts take the place of a formula.
pub(super) fn keeping_formulas(slot: &Slot, value: Value) -> Result<Value, EditError> {
    let control = &slot.control;
    let Value::Formulas(now) = &control.value else { return Ok(value) };
    if matches!(value, Value::None | Value::Formulas(_)) {
        return Ok(value);
    }
    let formula = now.iter().find(|text| characters::number(text).is_none());
    let refused = || {
        let (label, formula) = (control.label.to_string(), formula.cloned().unwrap_or_default());
        Err(EditError::Formula { label, formula })
    };
    // Handles that are dragged round what they do not move.
    let same = |new: f32, present: f32| (new - present).abs() <= 2e-3 * present.abs().max(1.0);
    let (Some(mut new), Some(mut present)) = (numbers_of(&value), numbers_of(&control.present)) else {
        return refused();
    };
    // A colour of one formula is grey.
    if now.len() == 1 && new.iter().chain(&present).all(|number| *number == new[0]) {
        new.truncate(1);
        present.truncate(1);
    }
    if now.len() != new.len() || new.len() != present.len() {
        return refused();
    }
    let mut texts = Vec::new();
    for (text, (new, present)) in now.iter().zip(new.into_iter().zip(present)) {
        match characters::number(text) {
            _ if same(new, present) => texts.push(text.clone()),
            Some(_) => texts.push(number(new)),
            None => return refused(),
        }
    }
    Ok(Value::Formulas(texts))
}

impl NumberRange {
    fn range(&self) -> Range {
        let Self { min, min_allowed, max, max_allowed, .. } = *self;
        Range { min, min_allowed, max, max_allowed }
    }
    /// Whether `value` is finite and within the range.
    pub fn accepts(&self, value: f32) -> bool {
        value.is_finite() && self.range().accepts(value) && (!self.whole || value.fract() == 0.0)
    }
    /// The range in words, as in "must be above 0".
    pub fn in_words(&self) -> String {
        format!("{}{}", if self.whole { "a whole number " } else { "" }, self.range().in_words())
    }
}

impl<'d> Writer<'d> {
    /// What makes the parameter have this value, which it takes.
    pub(super) fn write(&self, slot: &Slot, value: &Value) -> Result<Vec<Patch>, EditError> {
        match slot.place {
            Place::Parameter(index) => match self.fields.solid(&self.node.name.value) {
                Some(solid) => Ok(self.write_parameter(solid, index, value)),
                None => Ok(Vec::new()),
            },
            Place::Property(name) => Ok(self.write_property(name, value)),
            Place::Name | Place::Kind | Place::Arguments => Ok(self.write_arguments(value)),
            Place::Argument(index) => Ok(match arguments(self.node).nth(index) {
                Some(entry) => vec![self.replace(entry, value)],
                None => vec![Patch::insert(self.end_of_entries(), format!(" {}", fresh(value)))],
            }),
            Place::Node(name) => match child(self.node, name) {
                Some(child) => Ok(self.of(child).write_arguments(value)),
                None => self.insert(&format!("{name} {}", fresh(value))),
            },
            Place::NodeProperty(name, word) => match child(self.node, name) {
                Some(child) => Ok(self.of(child).write_property(word, value)),
                None => self.insert(&format!("{name} {word}={}", fresh(value))),
            },
            Place::Texture(owner) => match value {
                Value::Text(kind) => self.write_texture(owner, kind),
                _ => Ok(Vec::new()),
            },
            Place::Inside(owner, inside) => self.write_inside(owner, inside, value),
        }
    }

    /// What makes the parameter have its default.
    pub(super) fn erase(&self, slot: &Slot) -> Result<Vec<Patch>, EditError> {
        match slot.place {
            Place::Parameter(index) => match self.fields.solid(&self.node.name.value) {
                Some(solid) => Ok(self.erase_parameter(solid, index)),
                None => Ok(Vec::new()),
            },
            Place::Property(name) => {
                Ok(property(self.node, name).map(|entry| self.remove(entry)).into_iter().collect())
            }
            Place::Name | Place::Kind | Place::Arguments => Ok(Vec::new()),
            // Another that others follow is given its default.
            Place::Argument(index) => {
                let arguments: Vec<_> = arguments(self.node).collect();
                Ok(match arguments.get(index) {
                    Some(last) if index + 1 == arguments.len() => vec![self.remove(last)],
                    Some(entry) => vec![self.replace(entry, &slot.control.default)],
                    None => Vec::new(),
                })
            }
            Place::Texture(owner) => self.erase_texture(owner),
            Place::Inside(owner, inside) => self.erase_inside(owner, inside),
            // The node that says the kind of a material says its first parameter, too.
            Place::Node(name) if crate::materials::kind(name).is_some() && self.node.name.value == "material" => {
                let Some(child) = child(self.node, name) else { return Ok(Vec::new()) };
                Ok(arguments(child).map(|entry| self.of(child).remove(entry)).collect())
            }
            Place::Node(name) => self.erase_node(name),
            Place::NodeProperty(name, word) => match child(self.node, name) {
                Some(child) if child.entries.len() > 1 || child.children.is_some() => {
                    Ok(property(child, word).map(|entry| self.of(child).remove(entry)).into_iter().collect())
                }
                _ => self.erase_node(name),
            },
        }
    }

    pub(super) fn of(&self, node: &'d Node<'static>) -> Self {
        Self { node, ..*self }
    }

    /// Puts a node behind the others in the braces.
    pub(super) fn insert(&self, template: &str) -> Result<Vec<Patch>, EditError> {
        let chunk = Chunk::new(template, self.style);
        self.check_braces()?;
        let last = self.node.children.as_ref().and_then(|block| {
            let index = block.nodes.len().checked_sub(1)?;
            Some(Site { block, top: false, index })
        });
        Ok(vec![match last {
            Some(site) => site.insert_behind(self.text, &chunk, self.style),
            None => insert_first(self.text, self.node, &chunk, self.style),
        }])
    }
    /// Braces that are never closed hold who knows what.
    pub(super) fn check_braces(&self) -> Result<(), EditError> {
        match self.node.children.as_ref().is_some_and(|block| !block.closed) {
            true => Err(EditError::Unreadable(self.node.name.value.to_string())),
            false => Ok(()),
        }
    }
    /// Removes a node from the braces, and these if nothing else is in them.
    pub(super) fn erase_node(&self, name: &str) -> Result<Vec<Patch>, EditError> {
        self.check_braces()?;
        let Some(block) = &self.node.children else { return Ok(Vec::new()) };
        let Some(index) = block.nodes.iter().position(|child| child.name.value == name) else { return Ok(Vec::new()) };
        let patch = Site { block, top: false, index }.removal(self.text, false);
        let (start, end) = (block.span.start as usize, block.span.end as usize);
        let left = [&self.text[start + 1..patch.range.start], &self.text[patch.range.end..end - 1]];
        let empty = patch.text.is_empty() && left.iter().all(|piece| piece.trim().is_empty());
        Ok(vec![if empty { Patch::remove(before_spaces(self.text, start)..end) } else { patch }])
    }

    /// Removes an argument or a property; with its line, if that went on only for it.
    pub(super) fn remove(&self, entry: &Entry) -> Patch {
        let span = bytes(entry.span);
        let start = before_spaces(self.text, span.start);
        if starts_line(self.text, span.start) && tail(self.text, span.end).ends_line {
            let line = self.text[..start].trim_end_matches(['\r', '\n']);
            if let Some(joined) = line.strip_suffix('\\') {
                return Patch::remove(before_spaces(self.text, joined.len())..span.end);
            }
        }
        Patch::remove(start..span.end)
    }

    /// Behind the last argument and property.
    fn end_of_entries(&self) -> usize {
        self.node.span().end as usize
    }

    pub(super) fn write_property(&self, name: &str, value: &Value) -> Vec<Patch> {
        vec![match property(self.node, name) {
            Some(entry) => self.replace(entry, value),
            None => Patch::insert(self.end_of_entries(), format!(" {name}={}", fresh(value))),
        }]
    }

    fn replace(&self, entry: &Entry, value: &Value) -> Patch {
        let range = bytes(entry.value_span);
        let now = &self.text[range.clone()];
        let text = match (value, &entry.value) {
            (Value::Text(text), tree::Value::Text(_)) => string_like(text, now),
            (Value::Text(text), _) => quoted(text),
            (value, _) => fresh(value),
        };
        Patch::replace(range, text)
    }

    pub(super) fn write_arguments(&self, value: &Value) -> Vec<Patch> {
        let arguments: Vec<_> = arguments(self.node).collect();
        let each = |values: &[f32]| {
            let changed = arguments.iter().zip(values).filter(|(entry, value)| read_number(entry) != Some(**value));
            changed.map(|(entry, value)| Patch::replace(bytes(entry.value_span), number(*value))).collect()
        };
        match (value, &arguments[..]) {
            (_, []) => vec![Patch::insert(bytes(self.node.name.span).end, format!(" {}", fresh(value)))],
            (Value::Triple(values) | Value::Colour(values), [_, _, _]) => each(values),
            (Value::Formulas(texts), entries) if texts.len() == entries.len() => {
                let now = |entry: &Entry| formula_text(entry);
                let changed = entries.iter().zip(texts).filter(|(entry, text)| now(entry).as_ref() != Some(*text));
                changed.map(|(entry, text)| Patch::replace(bytes(entry.value_span), formula(text))).collect()
            }
            (Value::Number(value), [_]) => each(&[*value]),
            (Value::Size([width, height]), [_, _]) => each(&[*width as f32, *height as f32]),
            (Value::Colour(values), [only]) => match &only.value {
                tree::Value::Text(now) => match hex(*values, now) {
                    Some(hex) => vec![Patch::replace(bytes(only.value_span), quoted(&hex))],
                    None => vec![self.replace(only, value)],
                },
                _ => vec![self.replace(only, value)],
            },
            (value, [only]) => vec![self.replace(only, value)],
            (value, [first, .., last]) => {
                vec![Patch::replace(bytes(first.span).start..bytes(last.span).end, fresh(value))]
            }
        }
    }

    fn write_parameter(&self, solid: Solid, index: usize, value: &Value) -> Vec<Patch> {
        let sizes = solid.info().size_params;
        let one_size = has_one_size(solid, self.node);
        let arguments: Vec<_> = number_arguments(solid, self.node).collect();
        if one_size && index < sizes {
            let range = bytes(arguments[0].value_span);
            let now = &self.text[range.clone()];
            let sizes: Vec<String> =
                (0..sizes).map(|size| if size == index { fresh(value) } else { now.to_owned() }).collect();
            return vec![Patch::replace(range, sizes.join(" "))];
        }
        let slot = if one_size { index + 1 - sizes } else { index };
        let name = &*solid.params()[index].name;
        if let Some(entry) = arguments.get(slot).copied().or_else(|| property(self.node, name)) {
            return vec![Patch::replace(bytes(entry.value_span), fresh(value))];
        }
        let is_text = solid.info().outline == Some(Outline::Text);
        let next = !is_text && slot == arguments.len() && self.one_size_of(solid, arguments.len() + 1) == one_size;
        match (next, arguments.last()) {
            (true, Some(last)) => vec![Patch::insert(bytes(last.span).end, format!(" {}", fresh(value)))],
            (true, None) => vec![Patch::insert(bytes(self.node.name.span).end, format!(" {}", fresh(value)))],
            (false, _) => self.write_property(name, value),
        }
    }

    /// Whether the first of so many arguments would stand for several sizes.
    fn one_size_of(&self, solid: Solid, arguments: usize) -> bool {
        let sizes = solid.info().size_params;
        let named = solid.params()[..sizes].iter().any(|param| property(self.node, &param.name).is_some());
        sizes > 1 && !named && (1..sizes).contains(&arguments)
    }

    /// Only the last argument can go: another that others follow is given its default.
    fn erase_parameter(&self, solid: Solid, index: usize) -> Vec<Patch> {
        let sizes = solid.info().size_params;
        let one_size = has_one_size(solid, self.node);
        let arguments: Vec<_> = number_arguments(solid, self.node).collect();
        let param = &solid.params()[index];
        let slot = if one_size { (index + 1).saturating_sub(sizes) } else { index };
        if slot >= arguments.len() {
            return property(self.node, &param.name).map(|entry| self.remove(entry)).into_iter().collect();
        }
        let last = slot + 1 == arguments.len() && !(one_size && index < sizes);
        if last && self.one_size_of(solid, arguments.len() - 1) == one_size {
            return vec![self.remove(arguments[slot])];
        }
        self.write_parameter(solid, index, &parameter_value(param, param.default))
    }
}

/// The colour as "#rrggbb", if that says it exactly; with the case of the letters in `now`.
fn hex(colour: [f32; 3], now: &str) -> Option<String> {
    let byte = |linear: f32| {
        let encoded = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round().clamp(0.0, 255.0) as u8
    };
    let [r, g, b] = colour.map(byte);
    let text = match now.chars().any(|c| c.is_ascii_uppercase()) {
        true => format!("#{r:02X}{g:02X}{b:02X}"),
        false => format!("#{r:02x}{g:02x}{b:02x}"),
    };
    (srgb(&text) == Some(colour)).then_some(text)
}
