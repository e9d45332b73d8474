//! Lamps: opaque objects of many analytic shapes, each intersected by itself.
//!
//! Idea: light is sampled well only if each lamp is known by its place and shape, and rays find a shape faster in the BVH than
//! a union or a repetition by sphere tracing. An opaque union looks the same from outside whether shapes keep the parts of their
//! surface inside others or not. So if all shapes of an object are lamps by the caller's word, sharp unions and
//! counted copies (`repeat`, `polar`) become shapes of their own in the [BVH](super::bvh).
//!
//! Where it does not apply, objects stay as they are: blends and other operators, modifiers that bend space, endless copies,
//! shapes without an analytic intersection, and more than [`MAX_LAMPS`] shapes in the scene. Cost: a leaf for each copy,
//! about 250 bytes.

use super::bvh::Bvh;
use super::shape_grid::is_union;
use super::{EvalStrategy, Field, Pose, Tree, Turn};
use crate::bounds::Aabb;
use crate::modifiers::Motion;
use crate::registry::union;

/// Largest number of shapes of all lamps.
const MAX_LAMPS: usize = 100_000;

impl Field {
    /// Gives each shape of the lamps a leaf of its own. Returns these leaves.
    pub(super) fn separate_lamps(&mut self, is_lamp: &dyn Fn(u32) -> bool) -> Vec<u32> {
        let mut lamps = Vec::new();
        for index in 0..self.objects.len() {
            if self.strategies[index] != EvalStrategy::SphereTraced {
                continue;
            }
            let most = MAX_LAMPS - lamps.len();
            let Some(shapes) = self.lamp_shapes(&self.objects[index], &Pose::WORLD, is_lamp, most) else { continue };
            let leaves = self.place(&shapes);
            let children = leaves.iter().map(|&leaf| Tree::Leaf(leaf)).collect();
            self.objects[index] =
                Tree::Operator { operator: union(), smooth: None, children, first_choice: 0, shape_grid: None };
            self.strategies[index] = EvalStrategy::InBvh;
            lamps.extend(leaves);
        }
        if !lamps.is_empty() {
            let traced = self
                .strategies
                .iter()
                .zip(&self.object_bounds)
                .filter(|(strategy, _)| matches!(strategy, EvalStrategy::SphereTraced | EvalStrategy::LitByField));
            self.sphere_traced_bounds = traced.map(|(_, bounds)| *bounds).fold(Aabb::NOTHING, Aabb::union);
        }
        lamps
    }

    /// Adds leaves to the BVH.
    pub(super) fn add_to_bvh(&mut self, leaves: Vec<u32>) {
        if leaves.is_empty() {
            return;
        }
        let all = self.bvh.leaves().chain(leaves);
        let bounded = all.map(|leaf| (leaf, self.leaf_bounds(leaf as usize))).collect();
        self.bvh = Bvh::new(bounded);
    }

    /// Leaves of a tree with their poses in the world, each as often as there are copies; `None` if the tree is no union of
    /// analytic lamps, or if there are more than `most`.
    fn lamp_shapes(
        &self,
        tree: &Tree,
        pose: &Pose,
        is_lamp: &dyn Fn(u32) -> bool,
        most: usize,
    ) -> Option<Vec<(u32, Pose)>> {
        match tree {
            Tree::Leaf(index) => {
                let leaf = &self.leaves[*index as usize];
                let is_bounded = leaf.shape.bounds(&leaf.params).is_finite();
                let is_whole = is_lamp(leaf.tag) && leaf.shape.is_analytic() && leaf.shape.mesh().is_none();
                (is_bounded && is_whole && most > 0).then(|| vec![(*index, pose.around(&leaf.pose))])
            }
            Tree::Operator { operator, smooth: None, children, .. } if is_union(*operator) => {
                let mut shapes = Vec::new();
                for child in children {
                    shapes.extend(self.lamp_shapes(child, pose, is_lamp, most - shapes.len())?);
                }
                Some(shapes)
            }
            Tree::Operator { .. } => None,
            Tree::Modifier(modified) => {
                let inside = self.lamp_shapes(&modified.inside, &Pose::WORLD, is_lamp, most)?;
                let motions =
                    modified.modifier.motions(&modified.params, modified.inside_bounds, most / inside.len().max(1))?;
                let outer = pose.around(&modified.pose);
                let copies = motions.iter().map(|motion| outer.around(&Pose::of(*motion)));
                Some(
                    copies.flat_map(|copy| inside.iter().map(move |(leaf, pose)| (*leaf, copy.around(pose)))).collect(),
                )
            }
        }
    }

    /// Makes a leaf of each shape: the declared one at first, then copies of it.
    fn place(&mut self, shapes: &[(u32, Pose)]) -> Vec<u32> {
        let place = |&(declared, pose): &(u32, Pose)| {
            let leaf = &mut self.leaves[declared as usize];
            if !leaf.lamp {
                leaf.copy_of = leaf.modified.then_some(declared);
                (leaf.pose, leaf.modified, leaf.lamp) = (pose, false, true);
                return declared;
            }
            let copy = super::Leaf { pose, copy_of: Some(declared), ..leaf.clone() };
            self.leaves.push(copy);
            self.leaves.len() as u32 - 1
        };
        shapes.iter().map(place).collect()
    }
}

impl Pose {
    /// Coordinates of the world.
    const WORLD: Self = Self {
        moved: false,
        turn: Turn::None,
        at: [0.0; 3],
        scale: 1.0,
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    };

    fn of(motion: Motion) -> Self {
        let (sine, cosine) = motion.turn.sin_cos();
        Self {
            moved: motion.offset != [0.0; 3],
            turn: if motion.turn == 0.0 { Turn::None } else { Turn::Turned },
            at: motion.offset,
            scale: 1.0,
            axes: [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]],
        }
    }

    /// Pose in the world of what has the pose `inside` within this one.
    fn around(&self, inside: &Self) -> Self {
        let turned = |v: [f32; 3]| std::array::from_fn(|k| (0..3).map(|axis| v[axis] * self.axes[axis][k]).sum());
        let offset: [f32; 3] = turned(inside.at);
        let turn = match (self.turn, inside.turn) {
            (Turn::None, turn) | (turn, Turn::None) => turn,
            (Turn::Scaled, Turn::Scaled) => Turn::Scaled,
            _ => Turn::Turned,
        };
        Self {
            moved: self.moved || inside.moved,
            turn,
            at: std::array::from_fn(|k| self.at[k] + self.scale * offset[k]),
            scale: self.scale * inside.scale,
            axes: inside.axes.map(turned),
        }
    }
}
