//! Writes parameters into the text, by patches of the few bytes of their values.
//!
//! Existing values keep their style: a number stays at its place, an argument stays an argument and a property a
//! property, three numbers are replaced one by one where they differ, and a colour stays `"#rrggbb"` while that can
//! express it exactly. Missing values are added as an argument if all before it are given, else as a property, or as a
//! node behind the other children.

pub(crate) mod check;
mod textures;

use crate::document::control::Value;
use crate::document::error::EditError;
use crate::document::parameters::{
    Parameter, Place, formula_text, has_one_size, number_arguments, parameter_value, read_number,
};
use crate::document::text::layout::{Chunk, Site, Style, before_spaces, bytes, insert_first, starts_line, tail};
use crate::document::text::literals::{formula, fresh, number, quoted, string_like};
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::{arguments, child, property};
use crate::language::read::colours::srgb;
use crate::language::read::custom_sdf::CustomSdfs;
use crate::language::tree::{self, Entry, Node};
use pathmarch_field::Outline;
use pathmarch_field::Solid;

/// A node and its text.
#[derive(Clone, Copy)]
pub(crate) struct Writer<'d> {
    pub(crate) text: &'d str,
    pub(crate) style: &'d Style,
    pub(crate) node: &'d Node<'static>,
    pub(crate) fields: &'d CustomSdfs,
}

impl<'d> Writer<'d> {
    /// Patches that set the parameter to an accepted value.
    pub(crate) fn write(&self, parameter: &Parameter, value: &Value) -> Result<Vec<Patch>, EditError> {
        match &parameter.place {
            Place::Solid(index) => match self.fields.solid(&self.node.name.value) {
                Some(solid) => Ok(self.write_parameter(solid, *index, value)),
                None => Ok(Vec::new()),
            },
            Place::Property(name) => Ok(self.write_property(name, value)),
            Place::Name | Place::Kind | Place::Arguments => Ok(self.write_arguments(value)),
            Place::Argument(index) => Ok(match arguments(self.node).nth(*index) {
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
            place @ (Place::Inside(_, inside) | Place::Decal(_, inside)) => self.write_inside(place, *inside, value),
        }
    }

    /// Patches that reset the parameter to its default.
    pub(crate) fn erase(&self, parameter: &Parameter) -> Result<Vec<Patch>, EditError> {
        match &parameter.place {
            Place::Solid(index) => match self.fields.solid(&self.node.name.value) {
                Some(solid) => Ok(self.erase_parameter(solid, *index)),
                None => Ok(Vec::new()),
            },
            Place::Property(name) => {
                Ok(property(self.node, name).map(|entry| self.remove(entry)).into_iter().collect())
            }
            Place::Name | Place::Kind | Place::Arguments => Ok(Vec::new()),
            // Another that others follow is given its default.
            Place::Argument(index) => {
                let arguments: Vec<_> = arguments(self.node).collect();
                Ok(match arguments.get(*index) {
                    Some(last) if *index + 1 == arguments.len() => vec![self.remove(last)],
                    Some(entry) => vec![self.replace(entry, &parameter.control.default)],
                    None => Vec::new(),
                })
            }
            Place::Texture(owner) => self.erase_texture(owner),
            place @ (Place::Inside(_, inside) | Place::Decal(_, inside)) => self.erase_inside(place, *inside),
            // The node that names the kind of a material also carries its first parameter.
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

    pub(crate) fn of(&self, node: &'d Node<'static>) -> Self {
        Self { node, ..*self }
    }

    /// Puts a node behind the others in the braces.
    pub(crate) fn insert(&self, template: &str) -> Result<Vec<Patch>, EditError> {
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
    /// Refuses braces that are never closed: their contents are unknown.
    pub(crate) fn check_braces(&self) -> Result<(), EditError> {
        match self.node.children.as_ref().is_some_and(|block| !block.closed) {
            true => Err(EditError::Unreadable(self.node.name.value.to_string())),
            false => Ok(()),
        }
    }
    /// Removes a node from the braces, and these if nothing else is in them.
    pub(crate) fn erase_node(&self, name: &str) -> Result<Vec<Patch>, EditError> {
        self.erase_child(|child| child.name.value == name)
    }
    /// The same for the first node that is the one.
    pub(crate) fn erase_child(&self, is_it: impl Fn(&Node<'static>) -> bool) -> Result<Vec<Patch>, EditError> {
        self.check_braces()?;
        let Some(block) = &self.node.children else { return Ok(Vec::new()) };
        let Some(index) = block.nodes.iter().position(is_it) else { return Ok(Vec::new()) };
        let patch = Site { block, top: false, index }.removal(self.text, false);
        let (start, end) = (block.span.start as usize, block.span.end as usize);
        let left = [&self.text[start + 1..patch.range.start], &self.text[patch.range.end..end - 1]];
        let empty = patch.text.is_empty() && left.iter().all(|piece| piece.trim().is_empty());
        Ok(vec![if empty { Patch::remove(before_spaces(self.text, start)..end) } else { patch }])
    }

    /// Removes an argument or a property; with its line, if that went on only for it.
    pub(crate) fn remove(&self, entry: &Entry) -> Patch {
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

    pub(crate) fn write_property(&self, name: &str, value: &Value) -> Vec<Patch> {
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

    pub(crate) fn write_arguments(&self, value: &Value) -> Vec<Patch> {
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
        let argument = if one_size { index + 1 - sizes } else { index };
        let name = &*solid.params()[index].name;
        if let Some(entry) = arguments.get(argument).copied().or_else(|| property(self.node, name)) {
            return vec![Patch::replace(bytes(entry.value_span), fresh(value))];
        }
        let is_text = solid.info().outline.is_some_and(Outline::has_string);
        let next = !is_text && argument == arguments.len() && self.one_size_of(solid, arguments.len() + 1) == one_size;
        match (next, arguments.last()) {
            (true, Some(last)) => vec![Patch::insert(bytes(last.span).end, format!(" {}", fresh(value)))],
            (true, None) => vec![Patch::insert(bytes(self.node.name.span).end, format!(" {}", fresh(value)))],
            (false, _) => self.write_property(name, value),
        }
    }

    /// True if the first of so many arguments gives several sizes.
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
        let argument = if one_size { (index + 1).saturating_sub(sizes) } else { index };
        if argument >= arguments.len() {
            return property(self.node, &param.name).map(|entry| self.remove(entry)).into_iter().collect();
        }
        let last = argument + 1 == arguments.len() && !(one_size && index < sizes);
        if last && self.one_size_of(solid, arguments.len() - 1) == one_size {
            return vec![self.remove(arguments[argument])];
        }
        self.write_parameter(solid, index, &parameter_value(param, param.default))
    }
}

/// The colour as "#rrggbb", if that expresses it exactly; with the case of the letters in `now`.
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
