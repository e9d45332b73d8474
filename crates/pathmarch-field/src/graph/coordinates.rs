//! Where a point of the world is in a leaf's own coordinates, and how these change with it.
//!
//! What is told of a surface beside its distance lives there: the orbit of a fractal, a texture, which so stays with a shape
//! that is moved or twisted. Through modifiers the derivatives are those of [`Modifier::point`](crate::Modifier), by the chain
//! rule. Cost: one transform; for each modifier around the leaf one more, and where it holds copies, a search for the
//! nearest.

use super::{Batch, Field, Modified, Pose, Tree};
use crate::number::Vec3;

/// A point in other coordinates than the world's.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// The point.
    pub point: Vec3<f32>,
    /// The gradient of each of its three coordinates over the world, per metre.
    pub gradients: [Vec3<f32>; 3],
}

impl Coordinates {
    fn world(p: Vec3<f32>) -> Self {
        let axis = |k: usize| Vec3::constant(std::array::from_fn(|axis| f32::from(u8::from(axis == k))));
        Self { point: p, gradients: std::array::from_fn(axis) }
    }

    /// The point of gradients over these coordinates.
    fn inside(&self, point: Vec3<f32>, gradients: [Vec3<f32>; 3]) -> Self {
        let [x, y, z] = self.gradients;
        Self { point, gradients: gradients.map(|g| x * g.x + y * g.y + z * g.z) }
    }

    fn placed(&self, pose: &Pose) -> Self {
        self.inside(pose.local(self.point), pose.local_from_world().map(Vec3::constant))
    }
}

impl Field {
    /// Where `p` is in the coordinates of the leaf of this number.
    pub fn coordinates(&self, leaf: usize, p: Vec3<f32>) -> Option<Coordinates> {
        let shape = self.leaves.get(leaf)?;
        let mut here = Coordinates::world(p);
        for modified in self.around(leaf) {
            here = here.placed(&modified.pose);
            let place = if modified.copies > 1 { self.nearest_inside(modified, here.point).1 } else { 0.0 };
            let point = f32::modifier(modified.modifier).point_gradient(here.point, place, &modified.coefficients);
            here = here.inside(point.values(), [point.x.gradient, point.y.gradient, point.z.gradient]);
        }
        Some(here.placed(&shape.pose))
    }

    /// The number of the modifier that holds the leaf, counted from 1; 0 for one that stands in the world.
    pub fn enclosing_modifier(&self, leaf: usize) -> u32 {
        self.around(leaf).last().map_or(0, |modified| modified.index + 1)
    }

    /// The modifiers around a leaf, the outermost first.
    fn around(&self, leaf: usize) -> Vec<&Modified> {
        let mut around = Vec::new();
        if self.leaves.get(leaf).is_some_and(|leaf| leaf.modified) {
            self.objects.iter().any(|object| find(object, leaf as u32, &mut around));
            around.reverse();
        }
        around
    }
}

/// Whether the leaf is in the tree; then `around` has the modifiers on the way, the innermost first.
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
