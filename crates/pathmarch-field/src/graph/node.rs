//! Tree of a scene: shapes, operators and modifiers, each placed relative to its parent.

use super::pose::{Frame, Pose};
use crate::blend::Blend;
use crate::modifiers::Modifier;
use crate::operators::Operator;
use crate::shapes::ShapeRef;

/// Placement of a node: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Direction to which the shape's +y is turned first; any length above zero.
    pub normal: Option<[f32; 3]>,
    /// Uniform scale, above zero.
    pub scale: Option<f32>,
    /// Rotation about the fixed x, then y, then z axis, degrees, right-handed.
    pub rotate: Option<[f32; 3]>,
    /// Translation, metres.
    pub at: Option<[f32; 3]>,
}

impl Placement {
    /// Local coordinates of the node.
    pub fn pose(&self) -> Pose {
        Frame::WORLD.inside(self).pose()
    }
}

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
