//! Crowds: unions of so many shapes that they are numbers, not code.
//!
//! Idea: of thousands of shapes only a few matter near a point. A sparse grid over the crowd keeps for each of its cells which
//! ones, and in what order they are folded; cells far from every surface keep one bound of the distance instead (Barbier
//! et al. 2025, "Lipschitz Pruning: Hierarchical Simplification of Primitive-Based SDFs"). `grid.rs`
//! has the rule and the building.
//!
//! Where we differ: a crowd is one fold over a list and not a tree of operators, so that what matters can be told exactly; near
//! a surface the value is that of the whole fold, up to its rounding. Grids are sparse and stop at short lists. A cell without
//! a list keeps the point of the surface nearest to its centre, which stands for the crowd where a view is so coarse that a
//! ray ends there, and where shading asks for a distance rather than for a bound.
//!
//! A crowd is an object that is one union, sharp or smooth, of at least [`LEAST`] shapes that have ends and are no fractals, or all objects that are one
//! such shape each and are marched. Cost: a descent of at most five cells and the fold of a short list; building 10,000 shapes
//! takes a fraction of a second, done when something is first marched. Memory is bounded: [`Grid::bytes`].

mod grid;

use super::bvh::{self, Bvh};
use super::{Batch, Field, Role, Surface, Tree};
use crate::blend::{Blend, BlendProfile};
use crate::bounds::Aabb;
use crate::number::{Dual, Real, Vec3};
use crate::operators::Combine;
use crate::registry::union;
pub(crate) use grid::{BITS, Cell, Grid, SPLITS};
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

/// Shapes of a union from which on they are a crowd.
pub(crate) const LEAST: usize = 24;

/// Many shapes and what is known of them.
#[derive(Clone, Debug)]
pub(crate) struct Crowd {
    /// In the order of the fold.
    pub(crate) leaves: Vec<u32>,
    /// How the union blends; sharp when absent.
    pub(crate) smooth: Option<Blend>,
    /// Whether each is an object of its own, whose surface counts from both sides.
    pub(crate) apart: bool,
    /// Number of the first choice among blended materials.
    pub(crate) first_choice: u32,
    /// A box that holds all of them.
    pub(crate) bounds: Aabb,
    grid: Arc<OnceLock<Grid>>,
}

/// What stands for the distance far from all surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Afar {
    /// Something nearer to zero, of its sign.
    Bound,
    /// About the distance itself.
    Estimate,
    /// The whole fold.
    Exact,
}

/// How far the fold of any number of shapes reaches beyond them: once the result is that far below the next distance, that does
/// not change it, and what is nearer lowers it by no more than what is left.
pub(crate) fn growth(smooth: Option<Blend>, shapes: usize) -> f32 {
    let Some(blend) = smooth else { return 0.0 };
    let steps = if blend.profile == BlendProfile::Stairs { 1.0 + 1.0 / blend.steps } else { 1.0 };
    (blend.amount * steps).min(blend.reach() * shapes.saturating_sub(1) as f32)
}

impl Crowd {
    pub(super) fn new(leaves: Vec<u32>, smooth: Option<Blend>, apart: bool, first_choice: u32, bounds: Aabb) -> Self {
        Self { leaves, smooth, apart, first_choice, bounds, grid: Arc::default() }
    }

    /// The grid, built when it is first asked for.
    pub(crate) fn grid(&self, field: &Field) -> &Grid {
        self.grid.get_or_init(|| Grid::new(field, self))
    }

    /// The grid, if it was built.
    pub(crate) fn built(&self) -> Option<&Grid> {
        self.grid.get()
    }

    /// The distance of the shapes in the list.
    fn fold<N: Batch>(&self, field: &Field, list: impl IntoIterator<Item = u32>, p: Vec3<N>) -> N {
        let mut distances = list.into_iter().map(|number| {
            let distance: N = field.leaves[self.leaves[number as usize] as usize].distance(p);
            if self.apart { distance.abs() } else { distance }
        });
        let Some(first) = distances.next() else { return N::constant(f32::INFINITY) };
        let operator = union();
        distances.fold(first, |result, distance| N::operator(operator).distance(result, distance, self.smooth))
    }

    /// The surface of the shapes in the list; thresholds are as in [`Field::surface_met`].
    fn fold_surface<N: Batch>(
        &self,
        field: &Field,
        list: impl IntoIterator<Item = u32>,
        p: Vec3<N>,
        threshold: &dyn Fn(u32) -> N,
    ) -> Surface<N> {
        let operator = union();
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for (place, number) in list.into_iter().enumerate() {
            let leaf = self.leaves[number as usize];
            let other = Surface { field: field.leaves[leaf as usize].surface(p), leaf: N::constant(leaf as f32) };
            if place == 0 {
                result = other;
                continue;
            }
            let (a, b) = (result.field, other.field);
            let (shown, shows) = if self.apart {
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

    fn everyone(&self) -> std::ops::Range<u32> {
        0..self.leaves.len() as u32
    }

    /// The distance from each point, unsigned where the shapes are [apart](Self::apart).
    pub(super) fn distance<N: Batch>(&self, field: &Field, p: Vec3<N>, afar: Afar) -> N {
        let grid = match (afar, self.built()) {
            (Afar::Exact, None) => return self.fold(field, self.everyone(), p),
            (_, Some(grid)) => grid,
            (_, None) => self.grid(field),
        };
        let [x, y, z] = [p.x, p.y, p.z].map(N::lanes);
        let mut values = [0.0; 8];
        // The list of each lane that has one.
        let mut lists: [Option<&[u32]>; 8] = [None; 8];
        let mut is_exact = true;
        for lane in 0..N::LANES {
            let point = [x[lane], y[lane], z[lane]];
            let found = grid.find(point);
            match (found.cell, afar) {
                (Cell::Near { start, length }, _) if found.inside => lists[lane] = Some(grid.list(*start, *length)),
                (_, Afar::Exact) => is_exact = false,
                (_, Afar::Bound) if !found.inside => values[lane] = self.bounds.distance(point),
                (Cell::Near { start, length }, _) => lists[lane] = Some(grid.list(*start, *length)),
                (Cell::Far { surface, distance, .. }, Afar::Estimate) => {
                    values[lane] = length(point, *surface).copysign(*distance);
                }
                (Cell::Far { distance, .. }, _) => {
                    let bound = distance.abs() - grid.lipschitz * length(point, found.centre);
                    values[lane] = bound.max(0.0).copysign(*distance);
                }
                (Cell::Split { .. }, _) => {}
            }
        }
        if !is_exact {
            return self.fold(field, self.everyone(), p);
        }
        let afar = N::from_lanes(values);
        let afar = if self.apart { afar.abs() } else { afar };
        self.by_list::<N, N>(afar, &lists, |list| self.fold(field, list.iter().copied(), p), N::select)
    }

    /// The surface of the crowd as seen from each point; where none is near, a plane stands for it unless `afar` is exact.
    pub(super) fn surface<N: Batch>(
        &self,
        field: &Field,
        p: Vec3<N>,
        threshold: &dyn Fn(u32) -> N,
        afar: Afar,
    ) -> Surface<N> {
        let grid = match (afar, self.built()) {
            (Afar::Exact, None) => return self.fold_surface(field, self.everyone(), p, threshold),
            (_, Some(grid)) => grid,
            (_, None) => self.grid(field),
        };
        let [x, y, z] = [p.x, p.y, p.z].map(N::lanes);
        // Distance, gradient, leaf.
        let mut values = [[0.0; 8]; 5];
        let mut lists: [Option<&[u32]>; 8] = [None; 8];
        let mut is_exact = true;
        for lane in 0..N::LANES {
            let point = [x[lane], y[lane], z[lane]];
            let found = grid.find(point);
            match found.cell {
                Cell::Near { start, length } if found.inside || afar != Afar::Exact => {
                    lists[lane] = Some(grid.list(*start, *length));
                }
                Cell::Far { surface, distance, leaf } if afar != Afar::Exact => {
                    let value = length(point, *surface).copysign(*distance);
                    let gradient: [f32; 3] = std::array::from_fn(|k| (point[k] - surface[k]) / value);
                    let [gx, gy, gz] = gradient;
                    for (slot, number) in values.iter_mut().zip([value, gx, gy, gz, *leaf as f32]) {
                        slot[lane] = number;
                    }
                }
                _ => is_exact = false,
            }
        }
        if !is_exact {
            return self.fold_surface(field, self.everyone(), p, threshold);
        }
        let [value, gx, gy, gz, leaf] = values.map(N::from_lanes);
        let afar = Surface { field: Dual { value, gradient: Vec3::new(gx, gy, gz) }, leaf };
        let fold = |list: &[u32]| self.fold_surface(field, list.iter().copied(), p, threshold);
        self.by_list::<N, Surface<N>>(afar, &lists, fold, |mask, yes, no| Surface {
            field: Dual::select(mask, yes.field, no.field),
            leaf: N::select(mask, yes.leaf, no.leaf),
        })
    }

    /// Evaluates each list that some lane has, once for all lanes, and chooses by lane.
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
            let mut own = [0.0; 8];
            let mut count = 0;
            for other in lane..N::LANES {
                if lists[other].is_some_and(|other| std::ptr::eq(other, list)) {
                    (done[other], own[other]) = (true, 1.0);
                    count += 1;
                }
            }
            let found = value(list);
            if count == N::LANES {
                return found;
            }
            result = select(N::constant(0.5).lt(N::from_lanes(own)), found, result);
        }
        result
    }
}

fn length(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| a[k] - b[k]);
    (x * x + y * y + z * z).sqrt()
}

/// Whether an operator is the union.
pub(super) fn joins(operator: &dyn Combine) -> bool {
    operator.info().name == union().info().name
}

impl Field {
    /// Makes crowds of what has at least so many shapes.
    pub(super) fn gather(&mut self, least: usize) {
        let least = least.max(2);
        let mut roles = std::mem::take(&mut self.roles);
        // Fractals stay code: what is asked of their orbits is.
        let has_end = |leaf: u32| {
            let bounds = Some(self.leaf_bounds(leaf as usize)).filter(|b| b.is_finite() && !b.is_empty());
            bounds.filter(|_| !self.leaves[leaf as usize].shape.has_orbit())
        };
        let mut crowds = Vec::new();
        let (mut apart, mut closed) = (Vec::new(), Vec::new());
        for (index, object) in self.objects.iter().enumerate() {
            match object {
                Tree::Leaf(leaf) if self.direct(object).is_none() && has_end(*leaf).is_some() => {
                    apart.push((index, *leaf))
                }
                Tree::Leaf(leaf) if self.direct(object).is_some() && has_end(*leaf).is_some() => {
                    closed.push((index, *leaf));
                }
                Tree::Combine { operator, smooth, children, first_choice }
                    if roles[index] == Role::Marched && children.len() >= least && joins(*operator) =>
                {
                    let leaves: Option<Vec<u32>> = children
                        .iter()
                        .map(|child| match child {
                            Tree::Leaf(leaf) => has_end(*leaf).map(|_| *leaf),
                            _ => None,
                        })
                        .collect();
                    if let Some(leaves) = leaves {
                        roles[index] = Role::Crowd(crowds.len());
                        crowds.push(Crowd::new(leaves, *smooth, false, *first_choice, self.object_bounds[index]));
                    }
                }
                _ => {}
            }
        }
        if apart.len() >= least {
            let bounds = apart.iter().map(|&(index, _)| self.object_bounds[index]).fold(Aabb::NOTHING, Aabb::union);
            for &(index, _) in &apart {
                roles[index] = Role::InCrowd;
            }
            crowds.push(Crowd::new(apart.into_iter().map(|(_, leaf)| leaf).collect(), None, true, 0, bounds));
        }
        if closed.len() >= least.max(bvh::LEAST) {
            for &(index, _) in &closed {
                roles[index] = Role::InBvh;
            }
            self.bvh = Bvh::new(closed.into_iter().map(|(index, leaf)| (leaf, self.object_bounds[index])).collect());
        }
        (self.roles, self.crowds) = (roles, crowds);
    }

    /// Objects that are in no crowd and none themselves.
    pub(crate) fn alone(&self) -> impl Iterator<Item = &Tree> {
        self.of_role(|role| matches!(role, Role::Direct | Role::Marched))
    }

    /// Those of them that rays meet in closed form.
    pub(crate) fn direct_alone(&self) -> impl Iterator<Item = &Tree> {
        self.of_role(|role| role == Role::Direct)
    }

    /// Those of them that are marched.
    pub(crate) fn marched_alone(&self) -> impl Iterator<Item = &Tree> {
        self.of_role(|role| role == Role::Marched)
    }

    fn of_role(&self, is_meant: impl Fn(Role) -> bool) -> impl Iterator<Item = &Tree> {
        self.objects.iter().zip(&self.roles).filter(move |(_, role)| is_meant(**role)).map(|(object, _)| object)
    }

    /// Those in no crowd, and what `counts` says of each.
    pub(crate) fn alone_with(&self, counts: &[bool]) -> impl Iterator<Item = (&Tree, bool)> {
        let all = self.objects.iter().zip(&self.roles).zip(counts);
        all.filter(|((_, role), _)| matches!(role, Role::Direct | Role::Marched))
            .map(|((object, _), counts)| (object, *counts))
    }

    /// Numbers of the crowds of which any object counts.
    pub(crate) fn crowds_that_count(&self, counts: &[bool]) -> Vec<usize> {
        let last = self.crowds.len().wrapping_sub(1);
        let number = |(role, counts): (&Role, &bool)| match role {
            _ if !counts => None,
            Role::Direct | Role::Marched | Role::InBvh => None,
            Role::Crowd(crowd) => Some(*crowd),
            Role::InCrowd => Some(last),
        };
        let numbers: BTreeSet<usize> = self.roles.iter().zip(counts).filter_map(number).collect();
        numbers.into_iter().collect()
    }

    /// Over the objects of closed form that are in it.
    pub(crate) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Those of many shapes.
    pub(crate) fn crowds(&self) -> &[Crowd] {
        &self.crowds
    }

    /// Builds what finds the shapes near a point, where there are many: for those who will ask for many distances.
    pub fn index(&self) {
        for crowd in &self.crowds {
            crowd.grid(self);
        }
    }

    /// How many shapes are printed as code: those of crowds are numbers.
    pub fn shapes_as_code(&self) -> usize {
        let in_bvh = self.roles.iter().filter(|role| **role == Role::InBvh).count();
        self.leaves.len() - in_bvh - self.crowds.iter().map(|crowd| crowd.leaves.len()).sum::<usize>()
    }

    /// What the grids of crowds take that were built so far, bytes.
    pub fn index_bytes(&self) -> usize {
        self.crowds.iter().filter_map(Crowd::built).map(Grid::bytes).sum()
    }
}
