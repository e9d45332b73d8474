//! The tree that people write: shapes and operators, each where it stands under its parent.

use super::pose::{Frame, Pose};
use crate::blend::Blend;
use crate::modifiers::Modifier;
use crate::operators::Operator;
use crate::shapes::ShapeRef;

/// Where a node stands: scale first, then turn, then move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Direction that the shape's +y is turned to, before everything else; any length but zero.
    pub normal: Option<[f32; 3]>,
    /// Uniform factor, above zero.
    pub scale: Option<f32>,
    /// Degrees about the fixed x, then y, then z axis, right-handed.
    pub rotate: Option<[f32; 3]>,
    /// Position, metres.
    pub at: Option<[f32; 3]>,
}

impl Placement {
    /// The coordinates of what stands there.
    pub fn pose(&self) -> Pose {
        Frame::WORLD.inside(self).pose()
    }
}

/// One shape or operator of the tree people write.
#[derive(Clone, Debug)]
pub struct Node {
    /// What it is.
    pub kind: Kind,
    /// Where it stands, relative to its parent.
    pub placement: Placement,
}

/// What a [`Node`] is.
#[derive(Clone, Debug)]
pub enum Kind {
    /// A shape and its numbers, in the order of [`Shape::params`](crate::Shape::params).
    Shape {
        /// The shape.
        shape: ShapeRef,
        /// Its numbers.
        params: Vec<f32>,
        /// Whatever the caller wants to know of a hit here; the scene keeps the material in it.
        tag: u32,
    },
    /// An operator over its children, folded from the first to the last.
    Operator {
        /// The operator.
        operator: &'static dyn Operator,
        /// How it blends; sharp when absent.
        smooth: Option<Blend>,
        /// At least one.
        children: Vec<Node>,
    },
    /// An operator that changes the union of its children.
    Modifier {
        /// The operator.
        modifier: &'static dyn Modifier,
        /// Its numbers, in the order of [`Modifier::params`].
        params: Vec<f32>,
        /// At least one.
        children: Vec<Node>,
    },
}
