//! Shape grids: unions of so many shapes that they are data, not code.
//!
//! Idea: of thousands of shapes only a few affect the distance near a point. A sparse grid lists for each cell those shapes,
//! in the order of the fold; cells far from every surface have one bound of the distance instead (Barbier et al. 2025,
//! "Lipschitz Pruning: Hierarchical Simplification of Primitive-Based SDFs"). `sparse_grid.rs` has the pruning rule and the
//! construction.
//!
//! Where we differ: a shape grid is one fold over a list, not a tree of operators, so that pruning is exact: near a surface
//! the value is that of the whole fold, up to rounding. Grids are sparse and stop at short lists. A cell without a list has
//! the surface point nearest to its centre. Rays end on it in coarse views, and shading estimates distances with it.
//!
//! Two kinds of shapes are in grids: those of an object that is one union, sharp or smooth, of at least [`MIN_SHAPES`]
//! bounded shapes without fractals; and all sphere-traced objects of one such shape each, if there are as many. Cost: a
//! descent of at most five cells and the fold of a short list. Rays build the parts of the grid that they pass. Memory is
//! bounded: [`SparseGrid::bytes`].

mod sparse_grid;

use super::bvh::{self, Bvh};
use super::far_field::FarField;
use super::{Batch, EvalStrategy, Field, RayKind, Surface, Tree};
use crate::blend::{Blend, BlendProfile};
use crate::bounds::Aabb;
use crate::number::{Dual, Real, Vec3};
use crate::operators::Operator;
use crate::registry::union;
use sparse_grid::FoundCell;
pub(crate) use sparse_grid::{AllCells, BITS, Cell, SPLITS, SparseGrid};
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

/// Least number of shapes of a shape grid.
pub(crate) const MIN_SHAPES: usize = 24;

/// Union of many shapes, evaluated by a sparse grid.
#[derive(Clone, Debug)]
pub(crate) struct ShapeGrid {
    /// Leaves of the field, in the order of the fold.
    pub(crate) leaves: Vec<u32>,
    /// Blend of the union; sharp if absent.
    pub(crate) smooth: Option<Blend>,
    /// True if each shape is an object of its own, whose distance is unsigned.
    pub(crate) separate: bool,
    /// Index of the first random choice among blended materials.
    pub(crate) first_choice: u32,
    /// Bounds of all shapes.
    pub(crate) bounds: Aabb,
    grid: Arc<OnceLock<SparseGrid>>,
    /// Grid before the last edits.
    previous: Option<Previous>,
}

/// Grid of an earlier version of a shape grid.
#[derive(Clone, Debug)]
struct Previous {
    grid: Arc<OnceLock<SparseGrid>>,
    /// True for each shape that differs.
    changed: Vec<bool>,
}

/// Reports whether an object is evaluated by itself.
fn is_single(strategy: EvalStrategy) -> bool {
    use EvalStrategy::{Analytic, LitByField, SphereTraced, Triangles};
    matches!(strategy, Analytic | SphereTraced | Triangles | LitByField)
}

/// Largest offset of the surface of a fold beyond its shapes, metres: a result that is so far below the next distance does not
/// change any more.
pub(crate) fn growth(smooth: Option<Blend>, shapes: usize) -> f32 {
    let Some(blend) = smooth else { return 0.0 };
    let steps = if blend.profile == BlendProfile::Stairs { 1.0 + 1.0 / blend.steps } else { 1.0 };
    (blend.amount * steps).min(blend.reach() * shapes.saturating_sub(1) as f32)
}

impl ShapeGrid {
    pub(super) fn new(
        leaves: Vec<u32>,
        smooth: Option<Blend>,
        separate: bool,
        first_choice: u32,
        bounds: Aabb,
    ) -> Self {
        Self { leaves, smooth, separate, first_choice, bounds, grid: Arc::default(), previous: None }
    }

    /// Lets the grid share what is unchanged with that of an earlier version of the field.
    fn follow(&mut self, field: &Field, old: &Self, old_field: &Field) {
        if (&self.leaves, self.smooth, self.separate) != (&old.leaves, old.smooth, old.separate) {
            return;
        }
        let differs = |&leaf: &u32| !field.leaves[leaf as usize].is_same_shape(&old_field.leaves[leaf as usize]);
        let mut changed: Vec<bool> = self.leaves.iter().map(differs).collect();
        let mut grid = old.grid.clone();
        if let Some(earlier) = old.previous.as_ref().filter(|_| grid.get().is_none()) {
            changed.iter_mut().zip(&earlier.changed).for_each(|(changed, earlier)| *changed |= earlier);
            grid = earlier.grid.clone();
        }
        self.previous = grid.get().is_some().then_some(Previous { grid, changed });
    }

    /// The grid. Its cells are built on first use.
    pub(crate) fn grid(&self, field: &Field) -> &SparseGrid {
        self.grid.get_or_init(|| SparseGrid::new(field, self))
    }

    /// All cells of the grid and all lists.
    pub(crate) fn all_cells(&self, field: &Field) -> AllCells {
        self.grid(field).all_cells(field, self)
    }

    /// The grid, if a part of it has been built.
    pub(crate) fn built_grid(&self) -> Option<&SparseGrid> {
        self.grid.get()
    }

    /// Distance of the union of the listed shapes.
    fn fold<N: Batch>(&self, field: &Field, list: impl IntoIterator<Item = u32>, p: Vec3<N>) -> N {
        let mut distances = list.into_iter().map(|number| {
            let distance: N = field.leaves[self.leaves[number as usize] as usize].distance(p);
            if self.separate { distance.abs() } else { distance }
        });
        let Some(first) = distances.next() else { return N::constant(f32::INFINITY) };
        let operator = union();
        distances.fold(first, |result, distance| N::operator(operator).distance(result, distance, self.smooth))
    }

    /// Surface of the union of the listed shapes; thresholds are as in [`Field::surface_at_hit`].
    fn fold_surface<N: Batch>(
        &self,
        field: &Field,
        list: impl IntoIterator<Item = u32>,
        p: Vec3<N>,
        threshold: &dyn Fn(u32) -> N,
    ) -> Surface<N> {
        let operator = union();
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for (position, number) in list.into_iter().enumerate() {
            let leaf = self.leaves[number as usize];
            let other = Surface { field: field.leaves[leaf as usize].surface(p), leaf: N::constant(leaf as f32) };
            if position == 0 {
                result = other;
                continue;
            }
            let (a, b) = (result.field, other.field);
            let (shown, shows) = if self.separate {
                let closer = b.value.abs().lt(a.value.abs());
                (Dual::select(closer, b, a), closer)
            } else {
                let least = match self.smooth {
                    Some(_) => threshold(self.first_choice + number - 1),
                    None => N::constant(0.5),
                };
                let shows = least.lt(N::operator(operator).weight(a.value, b.value, self.smooth));
                (N::operator(operator).gradient(a, b, self.smooth), shows)
            };
            result = Surface { field: shown, leaf: N::select(shows, other.leaf, result.leaf) };
        }
        result
    }

    fn all_shapes(&self) -> std::ops::Range<u32> {
        0..self.leaves.len() as u32
    }

    /// Distance from each point, metres; unsigned if the shapes are [separate](Self::separate).
    pub(super) fn distance<N: Batch>(&self, field: &Field, p: Vec3<N>, far_field: FarField) -> N {
        let grid = self.grid(field);
        let [x, y, z] = [p.x, p.y, p.z].map(N::lanes);
        let mut values = [0.0; 8];
        // List of each lane in a near cell.
        let mut lists: [Option<&[u32]>; 8] = [None; 8];
        let mut is_exact = true;
        for lane in 0..N::LANES {
            let point = [x[lane], y[lane], z[lane]];
            let found = grid.find(field, self, point);
            match (found.cell, far_field) {
                (FoundCell::Near(list), _) if found.inside => lists[lane] = Some(list),
                (_, FarField::Exact) => is_exact = false,
                (_, FarField::Bound) if !found.inside => values[lane] = self.bounds.distance(point),
                (FoundCell::Near(list), _) => lists[lane] = Some(list),
                (FoundCell::Far { surface, distance, .. }, FarField::Estimate) => {
                    values[lane] = length(point, surface).copysign(distance);
                }
                (FoundCell::Far { distance, .. }, _) => {
                    let bound = distance.abs() - grid.lipschitz * length(point, found.centre);
                    values[lane] = bound.max(0.0).copysign(distance);
                }
            }
        }
        if !is_exact {
            return self.fold(field, self.all_shapes(), p);
        }
        let far_field = N::from_lanes(values);
        let far_field = if self.separate { far_field.abs() } else { far_field };
        self.by_list::<N, N>(far_field, &lists, |list| self.fold(field, list.iter().copied(), p), N::select)
    }

    /// Surface of the union at each point; far from it a plane replaces it, unless `far_field` is exact.
    pub(super) fn surface<N: Batch>(
        &self,
        field: &Field,
        p: Vec3<N>,
        threshold: &dyn Fn(u32) -> N,
        far_field: FarField,
    ) -> Surface<N> {
        let grid = self.grid(field);
        let [x, y, z] = [p.x, p.y, p.z].map(N::lanes);
        // Distance, gradient and leaf of each lane.
        let mut values = [[0.0; 8]; 5];
        let mut lists: [Option<&[u32]>; 8] = [None; 8];
        let mut is_exact = true;
        for lane in 0..N::LANES {
            let point = [x[lane], y[lane], z[lane]];
            let found = grid.find(field, self, point);
            match found.cell {
                FoundCell::Near(list) if found.inside || far_field != FarField::Exact => lists[lane] = Some(list),
                FoundCell::Far { surface, distance, leaf } if far_field != FarField::Exact => {
                    let value = length(point, surface).copysign(distance);
                    let gradient: [f32; 3] = std::array::from_fn(|k| (point[k] - surface[k]) / value);
                    let [gx, gy, gz] = gradient;
                    for (slot, number) in values.iter_mut().zip([value, gx, gy, gz, leaf as f32]) {
                        slot[lane] = number;
                    }
                }
                _ => is_exact = false,
            }
        }
        if !is_exact {
            return self.fold_surface(field, self.all_shapes(), p, threshold);
        }
        let [value, gx, gy, gz, leaf] = values.map(N::from_lanes);
        let far_field = Surface { field: Dual { value, gradient: Vec3::new(gx, gy, gz) }, leaf };
        let fold = |list: &[u32]| self.fold_surface(field, list.iter().copied(), p, threshold);
        self.by_list::<N, Surface<N>>(far_field, &lists, fold, |mask, yes, no| Surface {
            field: Dual::select(mask, yes.field, no.field),
            leaf: N::select(mask, yes.leaf, no.leaf),
        })
    }

    /// Evaluates each distinct list once for all lanes and selects the results by lane.
    fn by_list<N: Batch, T: Copy>(
        &self,
        otherwise: T,
        lists: &[Option<&[u32]>; 8],
        value: impl Fn(&[u32]) -> T,
        select: impl Fn(N::Mask, T, T) -> T,
    ) -> T {
        let mut result = otherwise;
        let mut done = [false; 8];
        for lane in 0..N::LANES {
            let Some(list) = lists[lane].filter(|_| !done[lane]) else { continue };
            let mut has_list = [0.0; 8];
            let mut count = 0;
            for other in lane..N::LANES {
                if lists[other].is_some_and(|other| std::ptr::eq(other, list)) {
                    (done[other], has_list[other]) = (true, 1.0);
                    count += 1;
                }
            }
            let found = value(list);
            if count == N::LANES {
                return found;
            }
            result = select(N::constant(0.5).lt(N::from_lanes(has_list)), found, result);
        }
        result
    }
}

fn length(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| a[k] - b[k]);
    (x * x + y * y + z * z).sqrt()
}

/// Reports whether an operator is the union.
pub(super) fn is_union(operator: &dyn Operator) -> bool {
    operator.info().name == union().info().name
}

impl Field {
    /// Moves unions and separate objects of at least this many shapes to shape grids, and many analytic objects to the BVH.
    pub(super) fn gather_shape_grids(&mut self, least: usize) {
        let least = least.max(2);
        let mut strategies = std::mem::take(&mut self.strategies);
        // Fractals stay code, because their orbit traps are code. Meshes have data of their own.
        let finite_bounds = |leaf: u32| {
            let bounds = Some(self.leaf_bounds(leaf as usize)).filter(|b| b.is_finite() && !b.is_empty());
            let shape = &self.leaves[leaf as usize].shape;
            bounds.filter(|_| !shape.has_orbit() && shape.mesh().is_none())
        };
        let mut shape_grids = Vec::new();
        let (mut separate, mut analytic) = (Vec::new(), Vec::new());
        for (index, object) in self.objects.iter().enumerate() {
            match object {
                Tree::Leaf(_) if strategies[index] == EvalStrategy::LitByField => {}
                Tree::Leaf(leaf) if self.direct(object).is_none() && finite_bounds(*leaf).is_some() => {
                    separate.push((index, *leaf))
                }
                Tree::Leaf(leaf) if self.direct(object).is_some() && finite_bounds(*leaf).is_some() => {
                    analytic.push((index, *leaf));
                }
                Tree::Operator { operator, smooth, children, first_choice }
                    if strategies[index] == EvalStrategy::SphereTraced
                        && children.len() >= least
                        && is_union(*operator) =>
                {
                    let leaves: Option<Vec<u32>> = children
                        .iter()
                        .map(|child| match child {
                            Tree::Leaf(leaf) => finite_bounds(*leaf).map(|_| *leaf),
                            _ => None,
                        })
                        .collect();
                    if let Some(leaves) = leaves {
                        strategies[index] = EvalStrategy::ShapeGrid(shape_grids.len());
                        shape_grids.push(ShapeGrid::new(
                            leaves,
                            *smooth,
                            false,
                            *first_choice,
                            self.object_bounds[index],
                        ));
                    }
                }
                _ => {}
            }
        }
        if separate.len() >= least {
            let bounds = separate.iter().map(|&(index, _)| self.object_bounds[index]).fold(Aabb::NOTHING, Aabb::union);
            for &(index, _) in &separate {
                strategies[index] = EvalStrategy::InShapeGrid;
            }
            shape_grids.push(ShapeGrid::new(
                separate.into_iter().map(|(_, leaf)| leaf).collect(),
                None,
                true,
                0,
                bounds,
            ));
        }
        if analytic.len() >= least.max(bvh::MIN_OBJECTS) {
            for &(index, _) in &analytic {
                strategies[index] = EvalStrategy::InBvh;
            }
            self.bvh = Bvh::new(analytic.into_iter().map(|(index, leaf)| (leaf, self.object_bounds[index])).collect());
        }
        self.singles = (0..).zip(&strategies).filter(|(_, strategy)| is_single(**strategy)).map(|(k, _)| k).collect();
        (self.strategies, self.shape_grids) = (strategies, shape_grids);
    }

    /// Shares what an earlier version of the field has built and the changes since leave valid. The field's values do not
    /// change. Cost: a comparison of the shapes.
    pub fn follow(&mut self, old: &Self) {
        let mut shape_grids = std::mem::take(&mut self.shape_grids);
        if shape_grids.len() == old.shape_grids.len() && self.leaves.len() == old.leaves.len() {
            for (shape_grid, before) in shape_grids.iter_mut().zip(&old.shape_grids) {
                shape_grid.follow(self, before, old);
            }
        }
        self.shape_grids = shape_grids;
    }

    /// Objects outside of shape grids and the BVH.
    pub(crate) fn single_objects(&self) -> impl Iterator<Item = &Tree> {
        self.with_strategy(is_single)
    }

    /// Analytic objects among them.
    pub(crate) fn analytic_objects(&self) -> impl Iterator<Item = &Tree> {
        self.with_strategy(|strategy| strategy == EvalStrategy::Analytic)
    }

    /// Sphere-traced objects among them.
    pub(crate) fn sphere_traced_objects(&self) -> impl Iterator<Item = &Tree> {
        self.objects_sphere_traced_by(RayKind::Secondary)
    }

    /// Those that rays of a kind sphere-trace.
    pub(crate) fn objects_sphere_traced_by(&self, kind: RayKind) -> impl Iterator<Item = &Tree> {
        self.with_strategy(move |strategy| match strategy {
            EvalStrategy::SphereTraced => true,
            EvalStrategy::LitByField => kind == RayKind::Secondary,
            _ => false,
        })
    }

    fn with_strategy(&self, is_meant: impl Fn(EvalStrategy) -> bool) -> impl Iterator<Item = &Tree> {
        let singles = self.singles.iter().map(|&index| index as usize);
        singles.filter(move |&index| is_meant(self.strategies[index])).map(|index| &self.objects[index])
    }

    /// Objects outside of shape grids and the BVH, each with its entry of `included`.
    pub(crate) fn single_objects_with(&self, included: &[bool]) -> impl Iterator<Item = (&Tree, bool)> {
        self.singles.iter().map(|&index| (&self.objects[index as usize], included[index as usize]))
    }

    /// Indices of the shape grids with an included object.
    pub(crate) fn included_shape_grids(&self, included: &[bool]) -> Vec<usize> {
        let last = self.shape_grids.len().wrapping_sub(1);
        let number = |(strategy, included): (&EvalStrategy, &bool)| match strategy {
            _ if !included => None,
            EvalStrategy::ShapeGrid(shape_grid) => Some(*shape_grid),
            EvalStrategy::InShapeGrid => Some(last),
            _ => None,
        };
        let numbers: BTreeSet<usize> = self.strategies.iter().zip(included).filter_map(number).collect();
        numbers.into_iter().collect()
    }

    /// Hierarchy over many analytic objects.
    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Shape grids of the field.
    pub(crate) fn shape_grids(&self) -> &[ShapeGrid] {
        &self.shape_grids
    }

    /// Builds all shape grids now instead of on first use, e.g. before many distances.
    pub fn build_shape_grids(&self) {
        for shape_grid in &self.shape_grids {
            shape_grid.grid(self).build(self, shape_grid);
        }
    }

    /// Number of shapes that are printed as code, not stored as data.
    pub fn shapes_as_code(&self) -> usize {
        self.leaves.len()
            - self.bvh.leaves().count()
            - self.shape_grids.iter().map(|shape_grid| shape_grid.leaves.len()).sum::<usize>()
    }

    /// Memory of the shape grids that have been built, bytes.
    pub fn shape_grid_bytes(&self) -> usize {
        self.shape_grids.iter().filter_map(ShapeGrid::built_grid).map(SparseGrid::bytes).sum()
    }
}
