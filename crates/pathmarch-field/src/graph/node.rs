//! Tree of a scene: shapes, operators and modifiers, each placed relative to its parent.

use super::pose::Placement;
use crate::blend::Blend;
use crate::modifiers::Modifier;
use crate::operators::Operator;
use crate::shapes::ShapeRef;

/// Node of a scene's tree.
#[derive(Clone, Debug)]
pub struct Node {
    /// Shape, operator or modifier.
    pub kind: Kind,
    /// Placement relative to its parent.
    pub placement: Placement,
}

/// Kind of a [`Node`].
#[derive(Clone, Debug)]
pub enum Kind {
    /// Shape with its parameters, in the order of [`Shape::params`](crate::Shape::params).
    Shape {
        /// Shape.
        shape: ShapeRef,
        /// Values of its parameters.
        params: Vec<f32>,
        /// Value of the caller's choice for hits on it; scenes store the material.
        tag: u32,
    },
    /// Operator over its children, folded from the first to the last.
    Operator {
        /// Operator or modifier.
        operator: &'static dyn Operator,
        /// Blend; sharp if absent.
        smooth: Option<Blend>,
        /// At least one.
        children: Vec<Node>,
    },
    /// Modifier of the union of its children.
    Modifier {
        /// Operator or modifier.
        modifier: &'static dyn Modifier,
        /// Values of its parameters, in the order of [`Modifier::params`].
        params: Vec<f32>,
        /// At least one.
        children: Vec<Node>,
    },
}
