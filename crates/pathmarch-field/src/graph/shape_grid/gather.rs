//! Choice of the shapes that are in shape grids.

use super::{Member, ShapeGrid, growth, is_single, is_union};
use crate::blend::Blend;
use crate::bounds::Aabb;
use crate::graph::analytic::AnalyticObject;
use crate::graph::bvh::{self, Bvh};
use crate::graph::{EvalStrategy, Field, Tree};

/// Members of a union, and its children that are code.
#[derive(Default)]
struct Gathered<'t> {
    members: Vec<Member>,
    choices: Vec<u32>,
    code: Vec<&'t mut Tree>,
}

impl Field {
    /// Moves unions and separate objects of at least this many shapes to shape grids, and many analytic objects to the BVH.
    pub(in crate::graph) fn gather_shape_grids(&mut self, least: usize) {
        let least = least.max(2);
        let mut strategies = std::mem::take(&mut self.strategies);
        let mut objects = std::mem::take(&mut self.objects);
        let mut shape_grids = Vec::new();
        let (mut separate, mut analytic) = (Vec::new(), Vec::new());
        for (index, object) in objects.iter_mut().enumerate() {
            match object {
                Tree::Leaf(_) if strategies[index] == EvalStrategy::LitByField => {}
                &mut Tree::Leaf(leaf) if self.is_data(leaf) => match self.direct(object) {
                    None => separate.push((index, leaf)),
                    Some(leaf) => analytic.push((index, leaf)),
                },
                _ if strategies[index] == EvalStrategy::SphereTraced => {
                    self.add_shape_grids(object, 0.0, least, &mut shape_grids);
                }
                _ => {}
            }
        }
        self.objects = objects;
        if separate.len() >= least {
            let bounds = separate.iter().map(|&(index, _)| self.object_bounds[index]).fold(Aabb::NOTHING, Aabb::union);
            for &(index, _) in &separate {
                strategies[index] = EvalStrategy::InShapeGrid;
            }
            let members = separate.into_iter().map(|(_, leaf)| Member::Shape(leaf)).collect();
            shape_grids.push(ShapeGrid {
                members,
                choices: Vec::new(),
                code: Vec::new(),
                smooth: None,
                separate: true,
                margin: 0.0,
                bounds,
                grid: Default::default(),
                previous: None,
            });
        }
        if analytic.len() >= least.max(bvh::MIN_OBJECTS) {
            for &(index, _) in &analytic {
                strategies[index] = EvalStrategy::InBvh;
            }
            self.bvh = Bvh::new(analytic.into_iter().map(|(index, leaf)| (leaf, self.object_bounds[index])).collect());
        }
        self.singles = (0..).zip(&strategies).filter(|(_, strategy)| is_single(**strategy)).map(|(k, _)| k).collect();
        let analytic = self.singles.iter().filter(|&&index| strategies[index as usize] == EvalStrategy::Analytic);
        let analytic_object =
            |&object: &u32| AnalyticObject { object, leaf: self.direct(&self.objects[object as usize]) };
        self.analytic = analytic.map(analytic_object).collect();
        (self.strategies, self.shape_grids) = (strategies, shape_grids);
    }

    /// Reports whether a leaf may be in a shape grid. Fractals stay code, because their orbit traps are code. Meshes have data of
    /// their own.
    fn is_data(&self, leaf: u32) -> bool {
        let bounds = self.tree_bounds(&Tree::Leaf(leaf));
        let shape = &self.leaves[leaf as usize].shape;
        bounds.is_finite() && !bounds.is_empty() && !shape.has_orbit() && shape.mesh().is_none()
    }

    /// Makes shape grids of the unions in a tree that must be exact within `margin` of its surface, metres.
    fn add_shape_grids(&self, tree: &mut Tree, margin: f32, least: usize, shape_grids: &mut Vec<ShapeGrid>) {
        match tree {
            Tree::Leaf(_) => {}
            Tree::Modifier(modified) => {
                let margin = margin / modified.pose.scale;
                if let Some(margin) = modified.modifier.inner_margin(&modified.params, modified.inside_bounds, margin) {
                    self.add_shape_grids(&mut modified.inside, margin, least, shape_grids);
                }
            }
            // What is no Boolean operation may have its surface anywhere.
            Tree::Operator { operator, .. } if operator.boolean().is_none() => {}
            Tree::Operator { operator, smooth, children, first_choice, shape_grid } => {
                // A blend changes nothing that is nearer by its width.
                let inner_margin = margin + smooth.map_or(0.0, |blend| blend.amount);
                if is_union(*operator) && children.len() >= 2 {
                    let mut gathered = Gathered::default();
                    self.gather(children, *smooth, *first_choice, &mut gathered);
                    let Gathered { members, choices, code } = gathered;
                    if members.len() - code.len() >= least {
                        let add = |tree: &mut Tree| {
                            self.add_shape_grids(tree, inner_margin, least, shape_grids);
                            tree.clone()
                        };
                        let code = code.into_iter().map(add).collect();
                        *shape_grid = Some(shape_grids.len() as u32);
                        shape_grids.push(self.shape_grid(members, choices, code, *smooth, margin));
                        return;
                    }
                }
                for child in children {
                    self.add_shape_grids(child, inner_margin, least, shape_grids);
                }
            }
        }
    }

    fn shape_grid(
        &self,
        members: Vec<Member>,
        choices: Vec<u32>,
        code: Vec<Tree>,
        smooth: Option<Blend>,
        margin: f32,
    ) -> ShapeGrid {
        let growth = growth(smooth, members.len());
        let (grid, previous) = Default::default();
        let bounds = Aabb::NOTHING;
        let mut shape_grid =
            ShapeGrid { members, choices, code, smooth, separate: false, margin, bounds, grid, previous };
        let bounds = shape_grid.leaves().map(|leaf| self.tree_bounds(&Tree::Leaf(leaf)));
        shape_grid.bounds = bounds.fold(Aabb::NOTHING, Aabb::union).expanded(growth);
        shape_grid
    }

    /// Adds the children of a union to the members of one of this blend. Where the order of the fold stays, inner unions are taken
    /// apart.
    fn gather<'t>(
        &self,
        children: &'t mut [Tree],
        smooth: Option<Blend>,
        first_choice: u32,
        gathered: &mut Gathered<'t>,
    ) {
        for (child, next) in children.iter_mut().zip(first_choice..) {
            let choice = next.saturating_sub(1);
            if let Tree::Leaf(leaf) = child
                && self.is_data(*leaf)
            {
                gathered.members.push(Member::Shape(*leaf));
            } else if keeps_order(child, smooth, gathered.members.is_empty()) {
                if let Tree::Operator { children, first_choice, .. } = child {
                    self.gather(children, smooth, *first_choice, gathered);
                }
                continue;
            } else {
                gathered.members.push(Member::Code(gathered.code.len() as u32));
                gathered.code.push(child);
            }
            gathered.choices.push(choice);
        }
    }

    /// Reports whether two trees have the same distance everywhere. False if that is unknown.
    pub(super) fn is_same_tree(&self, tree: &Tree, old: &Self, before: &Tree) -> bool {
        match (tree, before) {
            (Tree::Leaf(a), Tree::Leaf(b)) => self.leaves[*a as usize].is_same_shape(&old.leaves[*b as usize]),
            (Tree::Modifier(a), Tree::Modifier(b)) => {
                a.modifier.info().name == b.modifier.info().name
                    && (&a.coefficients, a.copies, a.pose) == (&b.coefficients, b.copies, b.pose)
                    && self.is_same_tree(&a.inside, old, &b.inside)
            }
            (
                Tree::Operator { operator: a, smooth: smooth_a, children: children_a, .. },
                Tree::Operator { operator: b, smooth: smooth_b, children: children_b, .. },
            ) => {
                a.info().name == b.info().name
                    && smooth_a == smooth_b
                    && children_a.len() == children_b.len()
                    && children_a.iter().zip(children_b).all(|(a, b)| self.is_same_tree(a, old, b))
            }
            _ => false,
        }
    }
}

/// Reports whether a child of a union of this blend may be taken apart: the order of sharp unions does not matter, and the first
/// child is where the fold starts.
fn keeps_order(child: &Tree, smooth: Option<Blend>, is_first: bool) -> bool {
    match child {
        Tree::Operator { operator, smooth: inner, .. } => {
            is_union(*operator) && *inner == smooth && (smooth.is_none() || is_first)
        }
        _ => false,
    }
}
