//! Parameters of shapes and operators, which arguments and properties give.

use super::Parameter;
use super::controls::parameter_control;
use super::place::Place;
use super::values::{number, read_number};
use crate::document::control::{Control, Value};
use crate::document::tree::nodes::{arguments, property};
use crate::language::Values;
use crate::language::keywords::AXES;
use crate::language::tree::{self, Entry, Node};
use pathmarch_field::Outline;
use pathmarch_field::{Param, Solid, Unit};

/// Parameters of a shape or an operator with their values in `node`.
pub(super) fn solid_parameters(solid: Solid, node: &Node<'static>, values: &Values) -> Vec<Parameter> {
    let given = entries(solid, node);
    let parameter = |(param, (index, entry)): (&Param, (usize, Option<&Entry<'static>>))| {
        let control = parameter_control(param);
        let value = entry.and_then(|entry| read(param, entry));
        let present = match &value {
            Some(Value::Formulas(_)) => entry.and_then(|entry| number(entry, values)).map(Value::Number),
            plain => plain.clone(),
        };
        let present = present.unwrap_or_else(|| control.default.clone());
        let (given, value) = (value.is_some(), value.unwrap_or_else(|| control.default.clone()));
        Parameter { control: Control { value, present, given, ..control }, place: Place::Solid(index) }
    };
    solid.params().iter().zip(given.into_iter().enumerate()).map(parameter).collect()
}

/// Value that an entry gives to a parameter.
fn read(param: &Param, entry: &Entry) -> Option<Value> {
    match (&entry.value, param.unit) {
        (tree::Value::Text(word), Unit::Axis) => {
            AXES.iter().any(|axis| axis == word).then(|| Value::Text(word.to_string()))
        }
        (_, Unit::Axis) => None,
        (tree::Value::Text(text), _) => Some(Value::Formulas(vec![text.to_string()])),
        _ => read_number(entry).map(Value::Number),
    }
}

/// True if the first argument of a shape gives several sizes.
pub(crate) fn has_one_size(solid: Solid, node: &Node<'static>) -> bool {
    let sizes = solid.info().size_params;
    let named = solid.params()[..sizes].iter().any(|param| property(node, &param.name).is_some());
    sizes > 1 && !named && (1..sizes).contains(&arguments(node).count())
}

/// Arguments that are parameters: all, except the words of a text and the notation of a path.
pub(crate) fn number_arguments<'n>(
    solid: Solid,
    node: &'n Node<'static>,
) -> impl Iterator<Item = &'n Entry<'static>> + use<'n> {
    let is_text = solid.info().outline.is_some_and(Outline::has_string);
    arguments(node).filter(move |_| !is_text)
}

/// Entry that gives each parameter its value, if any.
fn entries<'n>(solid: Solid, node: &'n Node<'static>) -> Vec<Option<&'n Entry<'static>>> {
    let sizes = solid.info().size_params;
    let one_size = has_one_size(solid, node);
    let entry = |index: usize, param: &Param| {
        let argument = match one_size {
            true if index < sizes => 0,
            true => index + 1 - sizes,
            false => index,
        };
        number_arguments(solid, node).nth(argument).or_else(|| property(node, &param.name))
    };
    solid.params().iter().enumerate().map(|(index, param)| entry(index, param)).collect()
}

/// Values of the parameters, as far as they are given.
pub(crate) fn parameter_values(solid: Solid, node: &Node<'static>) -> Vec<Option<Value>> {
    let given = entries(solid, node).into_iter().zip(solid.params());
    given.map(|(entry, param)| entry.and_then(|entry| read(param, entry))).collect()
}
