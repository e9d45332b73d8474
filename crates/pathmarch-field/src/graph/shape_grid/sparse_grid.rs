//! Sparse grid of a shape grid: the shapes that affect the distance in each cell.
//!
//! Idea (Barbier et al. 2025): within a ball of radius r around c no distance changes by more than L r. A shape whose distance
//! at c exceeds the running result of the fold by more than the width of the blend and 2 L r never changes it in the ball. If
//! the running result exceeds the next distance by as much, no earlier shape affects it. Each cell is such a ball: it prunes
//! the list of its parent cell, and is split until its list is short.
//!
//! Each shape that is only a bit nearer than the running result keeps a share of it, so that this rule alone drops far shapes
//! late. But while the result falls by a width, a soft blend leaves no more than e^-2 of what was before: its slope in the
//! farther distance is at most half, and less the more the result falls (checked over the profiles: 2 for soft, 1.9 for round,
//! 0.69 for chamfered blends; stairs keep all). So shapes are also dropped that are farther than the nearest one by so many
//! widths that less than rounding is left of them, and all shapes before one whose successors' slopes leave as little.
//!
//! A list has more shapes than any single point of its cell needs, because points on both sides drop different shapes. A cell
//! that is not split has the union of the lists of its octants.
//!
//! Cost: a few evaluations of the listed shapes for each cell, eight cells at a time, on all cores. If there would be too many
//! cells or list entries, the build starts again with longer lists.

use super::ShapeGrid;
use crate::blend::{Blend, BlendProfile};
use crate::graph::{Field, Leaf};
use crate::number::{Mask8, Real, Vec3};
use crate::registry::union;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use wide::f32x8;

/// Root cells along the longest edge.
const ROOTS: u32 = 4;
/// Splits of the cells of each level along each axis, as powers of two.
pub(crate) const SPLITS: [u32; 5] = [2, 2, 1, 1, 1];
/// Smallest cells of a root along each axis, as a power of two.
pub(crate) const BITS: u32 = 7;
/// Length up to which a list is not pruned further.
const SHORT: usize = 4;
/// Distance from a surface, in half diagonals, from which a cell has no list.
const FAR: f32 = 2.0;
/// Largest number of cells.
const MAX_CELLS: usize = 1 << 20;
/// Largest number of entries of all lists together.
const MAX_ENTRIES: usize = 1 << 23;
/// Margin around the bounds, as a fraction of their size.
const MARGIN: f32 = 1.0 / 64.0;
/// Factor on cell sizes, for the rounding of points and centres.
const SLACK: f32 = 1.001;

/// Cell of the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cell {
    /// Split; the index of its first child.
    Split { first: u32 },
    /// Near a surface; its shapes are this range of the lists.
    Near { start: u32, length: u32 },
    /// Far from every surface: the surface point nearest to the centre, metres; the distance of the centre, metres; and the
    /// leaf whose material shows.
    Far { surface: [f32; 3], distance: f32, leaf: u32 },
}

/// Cells of a shape grid and their lists.
#[derive(Clone, Debug)]
pub(crate) struct SparseGrid {
    /// Corner of smallest coordinates.
    pub(crate) min: [f32; 3],
    /// Edge of the smallest cells, metres.
    pub(crate) edge: f32,
    /// Roots along each axis; they are the first cells, x fastest.
    pub(crate) roots: [u32; 3],
    pub(crate) cells: Vec<Cell>,
    /// Positions of shapes in the fold, ascending within each list.
    pub(crate) lists: Vec<u32>,
    /// Lipschitz constant of all shapes.
    pub(crate) lipschitz: f32,
}

/// Cell that contains a point, or the nearest one.
pub(super) struct Found<'a> {
    pub(super) cell: &'a Cell,
    pub(super) centre: [f32; 3],
    /// True if the point is in it.
    pub(super) inside: bool,
}

impl SparseGrid {
    /// Builds the grid.
    pub(super) fn new(field: &Field, shape_grid: &ShapeGrid) -> Self {
        // A failed attempt is repeated with longer lists: start at a length that will likely do.
        let thousands = shape_grid.leaves.len() as f32 / 1000.0;
        let mut short = SHORT * (thousands.powf(0.6).round() as usize).clamp(1, 16);
        loop {
            if let Some(grid) = Builder::new(field, shape_grid, short).build() {
                return grid;
            }
            short *= 2;
        }
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.cells) + size_of_val(&*self.lists)
    }

    pub(super) fn list(&self, start: u32, length: u32) -> &[u32] {
        &self.lists[start as usize..(start + length) as usize]
    }

    pub(super) fn find(&self, p: [f32; 3]) -> Found<'_> {
        let mut inside = true;
        let inverse = 1.0 / self.edge;
        let place: [u32; 3] = std::array::from_fn(|k| {
            let (at, count) = ((p[k] - self.min[k]) * inverse, (self.roots[k] << BITS) as f32);
            inside &= at >= 0.0 && at < count;
            at.clamp(0.0, count - 1.0) as u32
        });
        let [x, y, z] = place.map(|v| v >> BITS);
        let mut cell = &self.cells[((z * self.roots[1] + y) * self.roots[0] + x) as usize];
        let mut shift = BITS;
        for bits in SPLITS {
            let Cell::Split { first } = cell else { break };
            shift -= bits;
            let [x, y, z] = place.map(|v| v >> shift & ((1 << bits) - 1));
            cell = &self.cells[(first + (((z << bits) + y) << bits) + x) as usize];
        }
        let centre = std::array::from_fn(|k| centre(self.min[k], self.edge, place[k] >> shift, shift));
        Found { cell, centre, inside }
    }
}

/// Centre of a cell along an axis; `place` is its index among the cells of its size.
fn centre(min: f32, edge: f32, place: u32, shift: u32) -> f32 {
    min + (place as f32 + 0.5) * (edge * (1 << shift) as f32)
}

/// Cells and lists of one root, with indices relative to its own first ones.
#[derive(Default)]
struct Part {
    cells: Vec<Cell>,
    lists: Vec<u32>,
    /// Start and length of the last list.
    last_list: (u32, u32),
}

struct Builder<'a> {
    field: &'a Field,
    shape_grid: &'a ShapeGrid,
    leaves: Vec<&'a Leaf>,
    min: [f32; 3],
    edge: f32,
    roots: [u32; 3],
    lipschitz: f32,
    /// Length up to which cells are not split.
    short: usize,
    /// Distance below rounding, metres.
    negligible: f32,
    /// Distance behind the nearest shape beyond which blends leave nothing of a shape, metres.
    cutoff: f32,
    cells: AtomicUsize,
    numbers: AtomicUsize,
}

/// Cell to be built.
struct PendingCell {
    /// Index along each axis among the cells of its size.
    place: [u32; 3],
    list: Vec<u32>,
    /// Length of its parent's list.
    parent_length: usize,
    /// Distance of the union at its centre, metres.
    distance: f32,
}

impl<'a> Builder<'a> {
    fn new(field: &'a Field, shape_grid: &'a ShapeGrid, short: usize) -> Self {
        let leaves: Vec<&Leaf> = shape_grid.leaves.iter().map(|&leaf| &field.leaves[leaf as usize]).collect();
        let (min, max) = (shape_grid.bounds.min, shape_grid.bounds.max);
        let size = (0..3).map(|k| max[k] - min[k]).fold(1e-6, f32::max);
        let extent = min.iter().chain(&max).map(|v| v.abs()).fold(size, f32::max);
        let margin = (size * MARGIN).max(1e-5 * extent);
        let edge = (size + 2.0 * margin) / (ROOTS << BITS) as f32;
        let root = edge * (1 << BITS) as f32;
        let roots = std::array::from_fn(|k| (((max[k] - min[k] + 2.0 * margin) / root).ceil() as u32).clamp(1, ROOTS));
        let negligible = 6e-8 * extent;
        // Centred in its cells.
        let min = std::array::from_fn(|k| 0.5 * (min[k] + max[k] - roots[k] as f32 * root));
        Self {
            field,
            shape_grid,
            min,
            edge,
            roots,
            lipschitz: leaves.iter().map(|leaf| leaf.shape.lipschitz(&leaf.params)).fold(1.0, f32::max),
            leaves,
            short,
            negligible,
            cutoff: shape_grid.smooth.map_or(0.0, |blend| cutoff(blend, negligible)),
            cells: AtomicUsize::new(0),
            numbers: AtomicUsize::new(0),
        }
    }

    /// Builds the grid; `None` if it would be too large.
    fn build(&self) -> Option<SparseGrid> {
        let [nx, ny, nz] = self.roots;
        let places: Vec<[u32; 3]> =
            (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect();
        let everyone: Vec<u32> = (0..self.leaves.len() as u32).collect();
        let pending: Vec<PendingCell> =
            places.par_chunks(8).flat_map_iter(|places| self.pruned(places, BITS, &everyone)).collect();
        let parts: Option<Vec<(Cell, Part)>> = pending
            .into_par_iter()
            .map(|pending| {
                let mut part = Part::default();
                let cell = self.build_cell(pending, 0, &mut part)?;
                Some((cell, part))
            })
            .collect();
        let parts = parts?;
        let mut cells = Vec::with_capacity(parts.len());
        let (mut first_cell, mut first_number) = (parts.len() as u32, 0);
        let moved = |cell: Cell, first_cell: u32, first_number: u32| match cell {
            Cell::Split { first } => Cell::Split { first: first + first_cell },
            Cell::Near { start, length } => Cell::Near { start: start + first_number, length },
            far => far,
        };
        for (root, part) in &parts {
            cells.push(moved(*root, first_cell, first_number));
            first_cell += part.cells.len() as u32;
            first_number += part.lists.len() as u32;
        }
        let mut lists = Vec::with_capacity(first_number as usize);
        first_cell = parts.len() as u32;
        for (_, part) in &parts {
            let first_number = lists.len() as u32;
            cells.extend(part.cells.iter().map(|&cell| moved(cell, first_cell, first_number)));
            lists.extend(&part.lists);
            first_cell += part.cells.len() as u32;
        }
        let Self { min, edge, roots, lipschitz, .. } = *self;
        Some(SparseGrid { min, edge, roots, cells, lists, lipschitz })
    }

    fn shift(level: usize) -> u32 {
        BITS - SPLITS[..level].iter().sum::<u32>()
    }

    fn centre(&self, place: [u32; 3], shift: u32) -> [f32; 3] {
        std::array::from_fn(|k| centre(self.min[k], self.edge, place[k], shift))
    }

    /// Edge of the cells of this level, metres.
    fn size(&self, shift: u32) -> f32 {
        self.edge * (1 << shift) as f32
    }

    /// Largest change of a distance from the centre of a cube of this edge to its corners, metres.
    fn change(&self, edge: f32) -> f32 {
        0.5 * 3f32.sqrt() * SLACK * self.lipschitz * edge + self.negligible
    }

    /// Builds a cell and its children; `None` if the limits are exceeded.
    fn build_cell(&self, pending: PendingCell, level: usize, part: &mut Part) -> Option<Cell> {
        let PendingCell { place, list, parent_length, distance } = pending;
        let is_divisible = level < SPLITS.len() && (level == 0 || 5 * list.len() < 4 * parent_length);
        // Lists of all shapes cannot get longer.
        let is_unlimited = self.short >= self.leaves.len();
        let (centre, edge) = (self.centre(place, Self::shift(level)), self.size(Self::shift(level)));
        let list = if level > 1 { self.pruned_by_octants(centre, edge, 1, list) } else { list };
        if list.len() > self.short && !is_unlimited {
            if distance.abs() >= FAR * self.change(edge)
                && let Some(cell) = self.far_cell(centre, &list, distance)
            {
                return Some(cell);
            }
            if is_divisible {
                return self.split(place, level, &list, part);
            }
        }
        let list = if is_unlimited { list } else { self.pruned_by_octants(centre, edge, 2, list) };
        let (start, length) = part.last_list;
        // Neighbours often have the same list.
        if part.lists[start as usize..(start + length) as usize] == list {
            return Some(Cell::Near { start, length });
        }
        let (start, length) = (part.lists.len(), list.len());
        let numbers = self.numbers.fetch_add(length, Ordering::Relaxed) + length;
        if numbers > MAX_ENTRIES.max(self.leaves.len()) && !is_unlimited {
            return None;
        }
        part.lists.extend(list);
        part.last_list = (start as u32, length as u32);
        Some(Cell::Near { start: start as u32, length: length as u32 })
    }

    /// Union of the pruned lists of a cube's parts, for this many levels of octants.
    fn pruned_by_octants(&self, centre: [f32; 3], edge: f32, levels: u32, list: Vec<u32>) -> Vec<u32> {
        if levels == 0 || list.len() <= SHORT {
            return list;
        }
        let edge = 0.5 * edge;
        let octants = octants_of([0; 3]).map(|half| std::array::from_fn(|k| centre[k] + (half[k] as f32 - 0.5) * edge));
        let (keeps, _) = self.prune(&octants, edge, &list);
        let of = |mask: u32| list.iter().zip(&keeps).filter(move |(_, keeps)| *keeps & mask != 0);
        if levels == 1 {
            return of(0xff).map(|(&number, _)| number).collect();
        }
        let octants = octants.into_iter().enumerate().flat_map(|(lane, centre)| {
            self.pruned_by_octants(centre, edge, levels - 1, of(1 << lane).map(|(&number, _)| number).collect())
        });
        let mut entries: Vec<u32> = octants.collect();
        entries.sort_unstable();
        entries.dedup();
        entries
    }

    fn split(&self, place: [u32; 3], level: usize, list: &[u32], part: &mut Part) -> Option<Cell> {
        let (bits, shift) = (SPLITS[level], Self::shift(level));
        let count = 1 << (3 * bits);
        if self.cells.fetch_add(count, Ordering::Relaxed) + count > MAX_CELLS {
            return None;
        }
        let first = part.cells.len();
        part.cells.resize(first + count, Cell::Near { start: 0, length: 0 });
        // Level by level, so that eight neighbours are pruned from the list of their parent.
        let mut blocks = vec![(place, list.to_vec())];
        for shift in (shift - bits + 1..shift).rev() {
            let split = |(place, list): (_, Vec<u32>)| self.pruned(&octants_of(place), shift, &list);
            blocks = blocks.into_iter().flat_map(split).map(|pending| (pending.place, pending.list)).collect();
        }
        for (block, inner) in blocks {
            for mut pending in self.pruned(&octants_of(block), shift - bits, &inner) {
                pending.parent_length = list.len();
                let [x, y, z] = pending.place.map(|v| v & ((1 << bits) - 1));
                let number = (((z << bits) + y) << bits) + x;
                let cell = self.build_cell(pending, level + 1, part)?;
                part.cells[first + number as usize] = cell;
            }
        }
        Some(Cell::Split { first: first as u32 })
    }

    /// Cells at these places, at most eight, each with its part of a list.
    fn pruned(&self, places: &[[u32; 3]], shift: u32, list: &[u32]) -> Vec<PendingCell> {
        let centres: Vec<[f32; 3]> = places.iter().map(|&place| self.centre(place, shift)).collect();
        let (keeps, distance) = self.prune(&centres, self.size(shift), list);
        let distance = distance.to_array();
        let pending = places.iter().enumerate().map(|(lane, &place)| {
            let kept = list.iter().zip(&keeps).filter(|(_, keeps)| *keeps >> lane & 1 == 1);
            let list = kept.map(|(&number, _)| number).collect();
            PendingCell { place, list, parent_length: keeps.len(), distance: distance[lane] }
        });
        pending.collect()
    }

    /// Prunes a list for at most eight cubes of this edge: a bit mask of cubes for each shape, and the distances at their centres.
    fn prune(&self, centres: &[[f32; 3]], edge: f32, list: &[u32]) -> (Vec<u32>, f32x8) {
        let lane = |axis: usize| f32x8::from(std::array::from_fn(|k| centres.get(k).unwrap_or(&centres[0])[axis]));
        let p = Vec3::new(lane(0), lane(1), lane(2));
        let distance = |&number: &u32| {
            let distance: f32x8 = self.leaves[number as usize].distance(p);
            if self.shape_grid.separate { distance.abs() } else { distance }
        };
        let distances: Vec<f32x8> = list.iter().map(distance).collect();
        let change = f32x8::splat(2.0 * self.change(edge));
        match self.shape_grid.smooth {
            None => prune_sharp(&distances, change),
            Some(blend) => self.prune_smooth(&distances, change, blend),
        }
    }

    /// Prunes the distances of a smooth union at eight points, each uncertain by `change`: a bit mask of points for each shape, and
    /// the distances of the union.
    fn prune_smooth(&self, distances: &[f32x8], change: f32x8, blend: Blend) -> (Vec<u32>, f32x8) {
        let width = f32x8::splat(blend.amount.max(1e-6));
        let operator = union();
        let least = distances.iter().fold(f32x8::splat(f32::INFINITY), |least, &distance| least.fast_min(distance));
        let farthest = least + f32x8::splat(self.cutoff) + change;
        let mut result = f32x8::splat(f32::INFINITY);
        let mut keeps = Vec::with_capacity(distances.len());
        // Least difference of the result before each shape and its distance.
        let mut behind = Vec::with_capacity(distances.len());
        // First shape of each lane that all earlier ones do not affect.
        let mut firsts = [0; 8];
        for (place, &distance) in distances.iter().enumerate() {
            let nothing = distance.simd_ge(result + width + change) | distance.simd_ge(farthest);
            let before = result - distance - change;
            let all = before.simd_ge(width);
            let blended = operator.distance(result, distance, Some(blend));
            let taken = Real::select(Mask8(all), distance, blended);
            result = Real::select(Mask8(nothing), result, taken);
            keeps.push(!nothing.to_bitmask());
            behind.push(before.to_array());
            let all = all.to_bitmask() & !nothing.to_bitmask();
            if all != 0 {
                firsts
                    .iter_mut()
                    .enumerate()
                    .filter(|(lane, _)| all >> lane & 1 == 1)
                    .for_each(|(_, first)| *first = place);
            }
        }
        for (lane, first) in firsts.into_iter().enumerate() {
            // Slope of the final result in the result before a shape.
            let mut share = 1.0;
            let mut least = first;
            for place in (first..keeps.len()).rev().filter(|&place| keeps[place] >> lane & 1 == 1) {
                let behind = behind[place][lane];
                if behind >= 0.0 && blend.reach() * share <= self.negligible {
                    least = place;
                    break;
                }
                share *= remaining_slope(blend, behind / blend.amount.max(1e-6));
            }
            keeps[..least].iter_mut().for_each(|keeps| *keeps &= !(1 << lane));
        }
        (keeps, result)
    }

    /// Makes a cell far from every surface, if its nearest surface point can be found.
    fn far_cell(&self, centre: [f32; 3], list: &[u32], distance: f32) -> Option<Cell> {
        let found = self.shape_grid.fold_surface(
            self.field,
            list.iter().copied(),
            Vec3::new(centre[0], centre[1], centre[2]),
            &|_| 0.5f32,
        );
        let gradient = found.field.gradient;
        let steepness = gradient.length();
        if !(steepness > 1e-3 && steepness.is_finite()) {
            return None;
        }
        let along = found.field.value / steepness;
        let surface = [gradient.x, gradient.y, gradient.z];
        let surface = std::array::from_fn(|k| centre[k] - surface[k] * along / steepness);
        Some(Cell::Far { surface, distance: distance.copysign(along), leaf: found.leaf as u32 })
    }
}

/// Prunes the distances of a sharp union at eight points, as [`Builder::prune_smooth`].
fn prune_sharp(distances: &[f32x8], change: f32x8) -> (Vec<u32>, f32x8) {
    let least = distances.iter().fold(f32x8::splat(f32::INFINITY), |least, &distance| least.fast_min(distance));
    let keeps = |distance: &f32x8| !distance.simd_gt(least + change).to_bitmask();
    (distances.iter().map(keeps).collect(), least)
}

/// Eight octants of a cell.
fn octants_of([x, y, z]: [u32; 3]) -> [[u32; 3]; 8] {
    std::array::from_fn(|k| [2 * x + (k as u32 & 1), 2 * y + (k as u32 >> 1 & 1), 2 * z + (k as u32 >> 2)])
}

/// Distance behind another shape beyond which blends leave less than `negligible` of a shape, metres.
fn cutoff(blend: Blend, negligible: f32) -> f32 {
    let width = blend.amount.max(1e-6);
    let rate = match blend.profile {
        BlendProfile::Soft => 2.0,
        BlendProfile::Round => 1.9,
        BlendProfile::Chamfer => 0.69,
        BlendProfile::Stairs => return f32::INFINITY,
    };
    width * (2.0 + (2.0 * width / negligible).ln().max(0.0) / rate)
}

/// Largest slope of a blend in its farther distance, which is at least so many widths behind.
fn remaining_slope(blend: Blend, behind: f32) -> f32 {
    if behind < 0.0 {
        return 1.0;
    }
    let behind = behind.min(1.0);
    match blend.profile {
        BlendProfile::Soft => 0.5 * (1.0 - behind),
        BlendProfile::Round => 0.5 * (1.0 - behind / (2.0 - behind * behind).sqrt()),
        BlendProfile::Chamfer => 0.5,
        BlendProfile::Stairs => 1.0,
    }
}
