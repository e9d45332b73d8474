//! Local coordinates of a leaf at a world point, with their derivatives.
//!
//! Textures and orbit traps are evaluated in local coordinates, so that they follow a shape that is moved or twisted.
//! Derivatives pass through modifiers by the chain rule, with those of [`EvalModifier::point`](crate::EvalModifier::point).
//! Cost: one transform; one more for each modifier around the leaf, with a search for the nearest of its domain copies.

use super::far_field::FarField;
use super::{Batch, Field, Modified, Pose, Tree};
use crate::number::Vec3;

/// Point in local coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// Point in local coordinates, metres.
    pub point: Vec3<f32>,
    /// World-space gradient of each of its three coordinates.
    pub gradients: [Vec3<f32>; 3],
    /// Length of a local unit, metres; of stretched coordinates, the cube root of the volume of a unit cube.
    pub unit_length: f32,
}

/// Least volume of a cube whose edges are gradients.
const MIN_VOLUME: f32 = 1e-30;

impl Coordinates {
    fn world(p: Vec3<f32>) -> Self {
        let axis = |k: usize| Vec3::constant(std::array::from_fn(|axis| f32::from(u8::from(axis == k))));
        Self { point: p, gradients: std::array::from_fn(axis), unit_length: 1.0 }
    }

    /// Coordinates of a pose in the world.
    fn of_pose(p: Vec3<f32>, pose: &Pose) -> Self {
        let gradients = pose.local_from_world().map(Vec3::constant);
        Self { point: pose.local(p), gradients, unit_length: pose.scale }
    }

    /// Composes with inner coordinates: a point in them and its gradients over these.
    fn inside(&self, point: Vec3<f32>, gradients: [Vec3<f32>; 3]) -> Self {
        let [x, y, z] = self.gradients;
        Self { point, gradients: gradients.map(|g| x * g.x + y * g.y + z * g.z), ..*self }
    }

    fn placed(&self, pose: &Pose) -> Self {
        self.inside(pose.local(self.point), pose.local_from_world().map(Vec3::constant))
    }

    /// The same coordinates, with the length of their unit.
    fn measured(self) -> Self {
        let [x, y, z] = self.gradients;
        let cross = Vec3::new(y.y * z.z - y.z * z.y, y.z * z.x - y.x * z.z, y.x * z.y - y.y * z.x);
        let volume = x.dot(cross).abs().max(MIN_VOLUME);
        Self { unit_length: volume.cbrt().recip(), ..self }
    }
}

impl Field {
    /// Coordinates of the world point `p` on this leaf.
    pub fn coordinates(&self, leaf: usize, p: Vec3<f32>) -> Option<Coordinates> {
        let shape = self.leaves.get(leaf)?;
        if !shape.modified {
            return Some(Coordinates::of_pose(p, &shape.pose));
        }
        let mut here = Coordinates::world(p);
        for modified in self.modifiers_around(leaf) {
            here = here.placed(&modified.pose);
            let copy = match modified.copies {
                1 => 0.0,
                _ => self.nearest_copy(modified, here.point, FarField::Estimate).1,
            };
            let point = f32::modifier(modified.modifier).point_gradient(here.point, copy, &modified.coefficients);
            here = here.inside(point.values(), [point.x.gradient, point.y.gradient, point.z.gradient]);
        }
        Some(here.placed(&shape.pose).measured())
    }

    /// Number of the innermost modifier around the leaf, from 1; 0 if there is none.
    pub fn enclosing_modifier(&self, leaf: usize) -> u32 {
        self.modifiers_around(leaf).last().map_or(0, |modified| modified.index + 1)
    }

    /// Modifiers around a leaf, the outermost first.
    fn modifiers_around(&self, leaf: usize) -> Vec<&Modified> {
        let mut around = Vec::new();
        if self.leaves.get(leaf).is_some_and(|leaf| leaf.modified) {
            // The tree has the first leaf of a mesh.
            let first = leaf as u32 - self.leaves[leaf].slot;
            self.objects.iter().any(|object| find(object, first, &mut around));
            around.reverse();
        }
        around
    }
}

/// Searches the tree for a leaf. Returns true if it is there, with the modifiers above it, the innermost first, in `around`.
fn find<'t>(tree: &'t Tree, leaf: u32, around: &mut Vec<&'t Modified>) -> bool {
    match tree {
        Tree::Leaf(index) => *index == leaf,
        Tree::Operator { children, .. } => children.iter().any(|child| find(child, leaf, around)),
        Tree::Modifier(modified) => {
            let found = find(&modified.inside, leaf, around);
            if found {
                around.push(modified);
            }
            found
        }
    }
}
