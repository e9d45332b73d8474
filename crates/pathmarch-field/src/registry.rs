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
use std::collections::HashMap;
use std::sync::LazyLock;

/// All shapes, in the order of `shapes/mod.rs`.
pub fn shapes() -> &'static [&'static dyn Shape] {
    crate::shapes::ALL
}

/// All operators, in the order of `operators/mod.rs`.
pub fn operators() -> &'static [&'static dyn Operator] {
    crate::operators::ALL
}

/// All modifiers, in the order of `modifiers/mod.rs`.
pub fn modifiers() -> &'static [&'static dyn Modifier] {
    crate::modifiers::ALL
}

/// Kind of a node in an object: shape, operator or modifier.
#[derive(Clone, Copy, Debug)]
pub enum Solid<'a> {
    /// Shape.
    Shape(&'a (dyn Shape + 'static)),
    /// Operator on several solids.
    Operator(&'static dyn Operator),
    /// Modifier of one solid.
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
    /// Parameters, in order.
    pub fn params(self) -> &'a [Param] {
        match self {
            Self::Shape(shape) => shape.params(),
            Self::Operator(operator) => operator.params(),
            Self::Modifier(modifier) => modifier.params(),
        }
    }
    /// Reports whether it has children.
    pub fn is_operator(self) -> bool {
        !matches!(self, Self::Shape(_))
    }
}

/// All shapes, operators and modifiers.
pub fn solids() -> impl Iterator<Item = Solid<'static>> {
    let shapes = shapes().iter().map(|shape| Solid::Shape(*shape));
    let operators = operators().iter().map(|operator| Solid::Operator(*operator));
    shapes.chain(operators).chain(modifiers().iter().map(|modifier| Solid::Modifier(*modifier)))
}

/// Finds the shape, operator or modifier of this name.
pub fn solid(name: &str) -> Option<Solid<'static>> {
    static BY_NAME: LazyLock<HashMap<&str, Solid>> =
        LazyLock::new(|| solids().map(|solid| (&*solid.info().name, solid)).collect());
    BY_NAME.get(name).copied()
}

/// Finds the shape of this name.
pub fn shape(name: &str) -> Option<&'static dyn Shape> {
    shapes().iter().copied().find(|shape| shape.info().name == name)
}

/// Union, the operator that joins objects and the children of modifiers.
pub fn union() -> &'static dyn Operator {
    crate::operators::UNION
}

/// Finds the operator of this name.
pub fn operator(name: &str) -> Option<&'static dyn Operator> {
    operators().iter().copied().find(|operator| operator.info().name == name)
}
