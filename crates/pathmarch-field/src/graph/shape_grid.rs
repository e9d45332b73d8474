//! Shape grids: unions of so many shapes that they are data, not code.
//!
//! Idea: of thousands of shapes only a few affect the distance near a point. A sparse grid lists for each cell those shapes,
//! in the order of the fold; cells far from every surface have one bound of the distance instead (Barbier et al. 2025,
//! "Lipschitz Pruning: Hierarchical Simplification of Primitive-Based SDFs"). `sparse_grid.rs` has the pruning rule and the
//! construction, `gather.rs` finds the unions.
//!
//! Where we differ: a shape grid is one fold over a list, not a tree of operators, so that pruning is exact: near a surface
//! the value is that of the whole fold, up to rounding. Grids are sparse and stop at short lists. A cell without a list has
//! the surface point nearest to its centre. Rays end on it in coarse views, and shading estimates distances with it.
//!
//! Two kinds of shapes are in grids: those of a union, sharp or smooth, of at least [`MIN_SHAPES`] bounded shapes without
//! fractals; and all sphere-traced objects of one such shape each, if there are as many. Other children of such a union, e.g.
//! a fractal, a plane or a difference, are code ([`Member::Code`]). Lists have them as well, in their places in the fold, so
//! that they are evaluated only where they matter. They may be unbounded; outside of the grid they are always evaluated.
//!
//! A union may be anywhere in the tree of an object. What is above it must not turn a bound into a surface: within
//! [`margin`](ShapeGrid::margin) of its surface a grid is exact, and farther away it is no nearer than that.
//!
//! Cost: a descent of at most five cells and the fold of a short list. Rays build the parts of the grid that they pass. Memory
//! is bounded: [`SparseGrid::bytes`].

mod code_values;
mod gather;
mod sparse_grid;

use super::bvh::Bvh;
use super::far_field::FarField;
use super::{Batch, EvalStrategy, Field, RayKind, Surface, Tree};
use crate::blend::{Blend, BlendProfile};
use crate::bounds::Aabb;
use crate::number::{Dual, Real, Vec3};
use crate::operators::Operator;
use crate::registry::union;
use code_values::CodeValues;
use sparse_grid::FoundCell;
pub(crate) use sparse_grid::{AllCells, BITS, Cell, SPLITS, SparseGrid};
use std::sync::{Arc, OnceLock};

/// Least number of shapes of a shape grid.
pub(crate) const MIN_SHAPES: usize = 24;

/// Member of the union of a shape grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Member {
    /// Shape that is data: this leaf of the field.
    Shape(u32),
    /// Any other tree, as code: an index into [`ShapeGrid::code`].
    Code(u32),
}

/// Union of many shapes, evaluated by a sparse grid.
#[derive(Clone, Debug)]
pub(crate) struct ShapeGrid {
    /// Members, in the order of the fold.
    pub(crate) members: Vec<Member>,
    /// Index of the random choice between each member and those before it, among blended materials.
    pub(crate) choices: Vec<u32>,
    /// Members that are code.
    pub(crate) code: Vec<Tree>,
    /// Blend of the union; sharp if absent.
    pub(crate) smooth: Option<Blend>,
    /// True if each shape is an object of its own, whose distance is unsigned.
    pub(crate) separate: bool,
    /// Distance from its surface within which it is exact, metres, whatever the size of the cells. Bounds are no nearer.
    pub(crate) margin: f32,
    /// Bounds of all shapes that are data, with the offset of the blend.
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
    /// Leaves that are data, in the order of the fold.
    pub(crate) fn leaves(&self) -> impl Iterator<Item = u32> {
        self.members.iter().filter_map(|member| match member {
            Member::Shape(leaf) => Some(*leaf),
            Member::Code(_) => None,
        })
    }

    /// Distance by which the surface of the shapes must be behind that of the code for the union to be the latter's, metres.
    ///
    /// A blend of width w changes nothing that is nearer by w, and each further blend needs another width; but once less than
    /// rounding is left of the shapes, more blends need no more.
    pub(crate) fn code_width(&self, cutoff: f32) -> f32 {
        let width = self.smooth.map_or(0.0, |blend| blend.amount);
        (width * self.code.len() as f32).min(cutoff + width)
    }

    /// Lets the grid share what is unchanged with that of an earlier version of the field.
    fn follow(&mut self, field: &Field, old: &Self, old_field: &Field) {
        let key = |grid: &Self| (grid.smooth, grid.separate, grid.margin, grid.code.len());
        if self.members != old.members || key(self) != key(old) {
            return;
        }
        let differs = |member: &Member| match *member {
            Member::Shape(leaf) => !field.leaves[leaf as usize].is_same_shape(&old_field.leaves[leaf as usize]),
            Member::Code(index) => {
                !field.is_same_tree(&self.code[index as usize], old_field, &old.code[index as usize])
            }
        };
        let mut changed: Vec<bool> = self.members.iter().map(differs).collect();
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

    /// Distance of the union of the listed members.
    fn fold<N: Batch>(
        &self,
        field: &Field,
        list: impl IntoIterator<Item = u32>,
        p: Vec3<N>,
        code: &CodeValues<N, impl Fn(u32) -> N>,
    ) -> N {
        let mut distances = list.into_iter().map(|number| {
            let distance: N = match self.members[number as usize] {
                Member::Shape(leaf) => field.leaves[leaf as usize].distance(p),
                Member::Code(index) => code.get(index),
            };
            if self.separate { distance.abs() } else { distance }
        });
        let Some(first) = distances.next() else { return N::constant(f32::INFINITY) };
        let operator = union();
        distances.fold(first, |result, distance| N::operator(operator).distance(result, distance, self.smooth))
    }

    /// Surface of the union of the listed members; thresholds are as in [`Field::surface_at_hit`].
    fn fold_surface<N: Batch>(
        &self,
        field: &Field,
        list: impl IntoIterator<Item = u32>,
        p: Vec3<N>,
        threshold: &dyn Fn(u32) -> N,
        code: &CodeValues<Surface<N>, impl Fn(u32) -> Surface<N>>,
    ) -> Surface<N> {
        let operator = union();
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for (position, number) in list.into_iter().enumerate() {
            let other = match self.members[number as usize] {
                Member::Shape(leaf) => {
                    Surface { field: field.leaves[leaf as usize].surface(p), leaf: N::constant(leaf as f32) }
                }
                Member::Code(index) => code.get(index),
            };
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
                    Some(_) => threshold(self.choices[number as usize]),
                    None => N::constant(0.5),
                };
                let shows = least.lt(N::operator(operator).weight(a.value, b.value, self.smooth));
                (N::operator(operator).gradient(a, b, self.smooth), shows)
            };
            result = Surface { field: shown, leaf: N::select(shows, other.leaf, result.leaf) };
        }
        result
    }

    /// Positions of all members in the fold.
    fn all_members(&self) -> std::ops::Range<u32> {
        0..self.members.len() as u32
    }

    /// Positions of those that are code.
    fn all_code(&self) -> impl Iterator<Item = u32> {
        self.all_members().filter(|&number| matches!(self.members[number as usize], Member::Code(_)))
    }

    /// Distance from each point, metres; unsigned if the shapes are [separate](Self::separate).
    pub(super) fn distance<N: Batch>(&self, field: &Field, p: Vec3<N>, far_field: FarField) -> N {
        let grid = self.grid(field);
        let code = CodeValues::new(|index| field.tree_distance(&self.code[index as usize], p, far_field));
        let [x, y, z] = [p.x, p.y, p.z].map(N::lanes);
        let mut values = [0.0; 8];
        // List of each lane in a near cell.
        let mut lists: [Option<&[u32]>; 8] = [None; 8];
        let mut is_outside = [0.0; 8];
        let mut is_exact = true;
        for lane in 0..N::LANES {
            let point = [x[lane], y[lane], z[lane]];
            let found = grid.find(field, self, point);
            is_outside[lane] = f32::from(!found.inside);
            match (found.cell, far_field) {
                (FoundCell::Near(list), _) if found.inside => lists[lane] = Some(list),
                (_, FarField::Exact) => is_exact = false,
                (_, FarField::Bound) if !found.inside => values[lane] = self.bounds.distance(point) - grid.code_width,
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
            return self.fold(field, self.all_members(), p, &code);
        }
        let far_field = N::from_lanes(values);
        let far_field = if self.separate { far_field.abs() } else { far_field };
        let listed = |list: &[u32]| self.fold(field, list.iter().copied(), p, &code);
        let result = self.by_list::<N, N>(far_field, &lists, listed, N::select);
        if self.code.is_empty() || !is_outside.contains(&1.0) {
            return result;
        }
        let beyond = result.min(self.fold(field, self.all_code(), p, &code));
        N::select(N::constant(0.5).lt(N::from_lanes(is_outside)), beyond, result)
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
        let code = CodeValues::new(|index| field.tree_surface(&self.code[index as usize], p, threshold, far_field));
        let [x, y, z] = [p.x, p.y, p.z].map(N::lanes);
        // Distance, gradient and leaf of each lane.
        let mut values = [[0.0; 8]; 5];
        let mut lists: [Option<&[u32]>; 8] = [None; 8];
        let mut is_outside = [0.0; 8];
        let mut is_exact = true;
        for lane in 0..N::LANES {
            let point = [x[lane], y[lane], z[lane]];
            let found = grid.find(field, self, point);
            is_outside[lane] = f32::from(!found.inside);
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
            return self.fold_surface(field, self.all_members(), p, threshold, &code);
        }
        let [value, gx, gy, gz, leaf] = values.map(N::from_lanes);
        let far_field = Surface { field: Dual { value, gradient: Vec3::new(gx, gy, gz) }, leaf };
        let select = |mask, yes: Surface<N>, no: Surface<N>| Surface {
            field: Dual::select(mask, yes.field, no.field),
            leaf: N::select(mask, yes.leaf, no.leaf),
        };
        let listed = |list: &[u32]| self.fold_surface(field, list.iter().copied(), p, threshold, &code);
        let result = self.by_list::<N, Surface<N>>(far_field, &lists, listed, select);
        if self.code.is_empty() || !is_outside.contains(&1.0) {
            return result;
        }
        let beyond = self.fold_surface(field, self.all_code(), p, threshold, &code);
        let is_nearer = beyond.field.value.lt(result.field.value);
        select(N::constant(0.5).lt(N::from_lanes(is_outside)) & is_nearer, beyond, result)
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

    /// The field with shape grids for a picture of few samples, such as one in motion: cells that are missing are coarse. They
    /// are built in a third of the time, and evaluations in them take longer. The surface is the same, but distances differ by
    /// rounding. What this field builds, its copies share, but only coarse ones use coarse cells.
    pub fn with_coarse_grids(self) -> Self {
        Self { coarse_grids: true, ..self }
    }

    /// True if shape grids may be [coarse](Self::with_coarse_grids).
    pub fn has_coarse_grids(&self) -> bool {
        self.coarse_grids && !self.shape_grids.is_empty()
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

    /// Index of the grid of separate objects, if one of them is included.
    pub(crate) fn included_shape_grid(&self, included: &[bool]) -> Option<usize> {
        let mut included = self.strategies.iter().zip(included).filter(|(_, included)| **included);
        included.any(|(strategy, _)| *strategy == EvalStrategy::InShapeGrid).then(|| self.shape_grids.len() - 1)
    }

    /// Grid of separate objects.
    pub(crate) fn separate_shape_grid(&self) -> Option<&ShapeGrid> {
        self.shape_grids.last().filter(|shape_grid| shape_grid.separate)
    }

    /// Hierarchy over many analytic objects.
    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Shape grids of the field. That of separate objects is the last one.
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
            - self.shape_grids.iter().map(|shape_grid| shape_grid.leaves().count()).sum::<usize>()
    }

    /// Memory of the shape grids that have been built, bytes.
    pub fn shape_grid_bytes(&self) -> usize {
        self.shape_grids.iter().filter_map(ShapeGrid::built_grid).map(SparseGrid::bytes).sum()
    }
}
