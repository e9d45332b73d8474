//! Motion of the objects of a field since an earlier one: rigid, or a deformation.
//!
//! **Idea.** Two fields of equal structure differ in numbers alone. If only poses differ, and all parts of an object have
//! moved alike, the motion is rigid and known exactly. For all others, the earlier field itself says where the surface was.
//! Cost: linear in the number of shapes.

use super::{EvalStrategy, Field, Leaf, Modified, Pose, Tree};
use glam::{Mat3, Vec3};

/// Similarity from present points to earlier ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// Rotation.
    pub rotation: Mat3,
    /// Factor of lengths.
    pub scale: f32,
    /// Translation after rotation and scale, metres.
    pub offset: Vec3,
}

/// Motion of an object since an earlier field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectMotion {
    /// None.
    Still,
    /// One motion of the whole.
    Rigid(Displacement),
    /// Any other change of its surface.
    Deforming,
}

impl Displacement {
    /// No displacement.
    pub const NONE: Self = Self { rotation: Mat3::IDENTITY, scale: 1.0, offset: Vec3::ZERO };

    /// Displacement of all that is fixed to a pose, from the present one to an earlier one.
    pub fn between(present: &Pose, earlier: &Pose) -> Self {
        if (earlier.at, earlier.axes, earlier.scale) == (present.at, present.axes, present.scale) {
            return Self::NONE;
        }
        let world_from_local = |pose: &Pose| Mat3::from_cols_array_2d(&pose.axes);
        let rotation = world_from_local(earlier) * world_from_local(present).transpose();
        let scale = earlier.scale / present.scale;
        Self { rotation, scale, offset: Vec3::from(earlier.at) - rotation * Vec3::from(present.at) * scale }
    }

    /// Earlier position of a present point.
    #[inline]
    pub fn earlier(&self, point: Vec3) -> Vec3 {
        self.rotation * point * self.scale + self.offset
    }

    /// Reports whether it equals another one up to rounding.
    fn is_close(&self, other: &Self) -> bool {
        let size = 1.0 + self.offset.abs().max_element();
        self.rotation.abs_diff_eq(other.rotation, 1e-5)
            && (self.scale - other.scale).abs() <= 1e-5 * self.scale
            && self.offset.abs_diff_eq(other.offset, 1e-5 * size)
    }
}

impl Field {
    /// Motion of an object since an earlier field. Between objects of different structure it is a deformation.
    pub fn object_motion(&self, earlier: &Self, object: usize) -> ObjectMotion {
        let (Some(present), Some(before)) = (self.objects.get(object), earlier.objects.get(object)) else {
            return ObjectMotion::Still;
        };
        let mut parts = Vec::new();
        if !self.has_equal_numbers(present, earlier, before, &mut parts) {
            return ObjectMotion::Deforming;
        }
        match parts.split_first() {
            None => ObjectMotion::Still,
            Some((first, others)) if others.iter().all(|part| first.is_close(part)) => {
                if *first == Displacement::NONE {
                    ObjectMotion::Still
                } else {
                    ObjectMotion::Rigid(*first)
                }
            }
            _ => ObjectMotion::Deforming,
        }
    }

    /// Reports whether two trees have equal structure and, but for poses, equal numbers; adds the displacements of the parts.
    fn has_equal_numbers(&self, present: &Tree, earlier: &Self, before: &Tree, parts: &mut Vec<Displacement>) -> bool {
        match (present, before) {
            (Tree::Leaf(a), Tree::Leaf(b)) => {
                let (a, b) = (&self.leaves[*a as usize], &earlier.leaves[*b as usize]);
                parts.push(Displacement::between(&a.pose, &b.pose));
                a.params == b.params && a.shape.info().name == b.shape.info().name
            }
            (Tree::Modifier(a), Tree::Modifier(b)) => {
                let mut inner = Vec::new();
                let is_equal = a.modifier.info().name == b.modifier.info().name
                    && a.coefficients == b.coefficients
                    && self.has_equal_numbers(&a.inside, earlier, &b.inside, &mut inner);
                parts.push(Displacement::between(&a.pose, &b.pose));
                // What moves inside of a modifier moves with it no more.
                is_equal && inner.iter().all(|part| *part == Displacement::NONE)
            }
            (
                Tree::Operator { operator: a, smooth: smooth_a, children: children_a, .. },
                Tree::Operator { operator: b, smooth: smooth_b, children: children_b, .. },
            ) => {
                let is_equal = a.info().name == b.info().name && smooth_a == smooth_b;
                let mut children = children_a.iter().zip(children_b);
                is_equal
                    && children_a.len() == children_b.len()
                    && children.all(|(a, b)| self.has_equal_numbers(a, earlier, b, parts))
            }
            _ => false,
        }
    }

    /// Field of some objects alone, all sphere-traced. They must not be meshes.
    pub fn of_objects(&self, objects: &[usize]) -> Self {
        let mut part = Self::all_sphere_traced(&[]);
        for (index, &object) in objects.iter().enumerate() {
            let Some(tree) = self.objects.get(object) else { continue };
            let tree = part.copied(self, tree, index as u32);
            let bounds = self.object_bounds[object];
            part.bounds = part.bounds.union(bounds);
            part.sphere_traced_bounds = part.sphere_traced_bounds.union(bounds);
            part.object_bounds.push(bounds);
            part.strategies.push(EvalStrategy::SphereTraced);
            part.singles.push(index as u32);
            part.objects.push(tree);
        }
        part
    }

    /// Copy of a tree of another field, with its leaves.
    fn copied(&mut self, other: &Self, tree: &Tree, object: u32) -> Tree {
        match tree {
            Tree::Leaf(leaf) => {
                self.leaves.push(Leaf { object, ..other.leaves[*leaf as usize].clone() });
                Tree::Leaf(self.leaves.len() as u32 - 1)
            }
            Tree::Operator { operator, smooth, children, .. } => {
                let children: Vec<Tree> = children.iter().map(|child| self.copied(other, child, object)).collect();
                let first_choice = self.choices;
                self.choices += children.len() as u32;
                Tree::Operator { operator: *operator, smooth: *smooth, children, first_choice, shape_grid: None }
            }
            Tree::Modifier(modified) => {
                let inside = self.copied(other, &modified.inside, object);
                self.modifiers += 1;
                Tree::Modifier(Box::new(Modified { inside, index: self.modifiers - 1, ..(**modified).clone() }))
            }
        }
    }
}
