//! Registry: the lists of all shapes, operators and modifiers, and lookup by name.
//!
//! One file declares one shape: a unit struct that implements [`ShapeDef`](crate::shapes::ShapeDef). The `mod` line that
//! names the file in `shapes/mod.rs` registers it; the parser, the reference page, the CPU and GPU code and the tests all
//! read that list. Operators and modifiers do the same in `operators/mod.rs` and `modifiers/mod.rs`.

use crate::info::Info;
use crate::modifiers::Modifier;
use crate::operators::Operator;
use crate::parameter::Param;
use crate::shapes::Shape;

/// Every shape, in the order of `shapes/mod.rs`.
pub fn shapes() -> &'static [&'static dyn Shape] {
    crate::shapes::ALL
}

/// Every operator, in the order of `operators/mod.rs`.
pub fn operators() -> &'static [&'static dyn Operator] {
    crate::operators::ALL
}

/// Every modifier, in the order of `modifiers/mod.rs`.
pub fn modifiers() -> &'static [&'static dyn Modifier] {
    crate::modifiers::ALL
}

/// Anything that stands in an object.
#[derive(Clone, Copy, Debug)]
pub enum Solid<'a> {
    /// A shape.
    Shape(&'a (dyn Shape + 'static)),
    /// An operator of several solids.
    Operator(&'static dyn Operator),
    /// An operator that changes what it holds.
    Modifier(&'static dyn Modifier),
}

impl<'a> Solid<'a> {
    /// Name, documentation, source.
    pub fn info(self) -> &'a Info {
        match self {
            Self::Shape(shape) => shape.info(),
            Self::Operator(operator) => operator.info(),
            Self::Modifier(modifier) => modifier.info(),
        }
    }
    /// The parameters, in order.
    pub fn params(self) -> &'a [Param] {
        match self {
            Self::Shape(shape) => shape.params(),
            Self::Operator(operator) => operator.params(),
            Self::Modifier(modifier) => modifier.params(),
        }
    }
    /// Whether it holds solids.
    pub fn is_operator(self) -> bool {
        !matches!(self, Self::Shape(_))
    }
}

/// Every shape, operator and modifier.
pub fn solids() -> impl Iterator<Item = Solid<'static>> {
    let shapes = shapes().iter().map(|shape| Solid::Shape(*shape));
    let operators = operators().iter().map(|operator| Solid::Operator(*operator));
    shapes.chain(operators).chain(modifiers().iter().map(|modifier| Solid::Modifier(*modifier)))
}

/// The shape, operator or modifier of this name.
pub fn solid(name: &str) -> Option<Solid<'static>> {
    solids().find(|solid| solid.info().name == name)
}

/// The shape of this name.
pub fn shape(name: &str) -> Option<&'static dyn Shape> {
    shapes().iter().copied().find(|shape| shape.info().name == name)
}

/// The operator that joins what no other joins.
pub fn union() -> &'static dyn Operator {
    crate::operators::UNION
}

/// The operator of this name.
pub fn operator(name: &str) -> Option<&'static dyn Operator> {
    operators().iter().copied().find(|operator| operator.info().name == name)
}
