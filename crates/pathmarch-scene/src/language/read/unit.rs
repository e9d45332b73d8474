//! Unit of length.

use super::arguments::choice;
use super::context::Context;
use crate::language::tree::Node;
use crate::unit::LengthUnit;

/// Reads `unit "cm"`; metres after a mistake.
pub(crate) fn unit(node: &Node, context: &mut Context) -> LengthUnit {
    let names = LengthUnit::ALL.map(LengthUnit::name);
    choice(node, "unit of length", &names, context).and_then(LengthUnit::of).unwrap_or_default()
}
