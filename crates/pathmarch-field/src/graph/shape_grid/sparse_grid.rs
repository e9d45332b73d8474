//! The grid of a shape_grid: which shapes matter where.
//!
//! Idea (Barbier et al. 2025): within a ball of radius r around c no distance changes by more than L r. A shape whose distance
//! at c exceeds the running result of the fold by more than the width of the blend and 2 L r never changes it in the ball; where
//! the running result exceeds the next distance by as much, all before is forgotten. Cells are the balls: each is pruned from the
//! list of the cell around it, and divided until its list is short.
//!
//! A fold forgets late what was far: each shape that is a bit nearer than the result so far keeps a share of it. But while the
//! result falls by a width, a soft blend leaves no more than e^-2 of what was before: its slope in the farther distance is at
//! most half, and less the more the result falls (checked over the profiles: 2 for soft, 1.9 for round, 0.69 for chamfered
//! blends; stairs keep all). So a shape that is farther than the nearest one by so many widths that less than rounding is left
//! of it is dropped, too, and so is all before a shape where the slopes of what follows leave as little.
//!
//! What is kept of a list is more than any single point needs: points on both sides of a cell forget at different shapes. A cell
//! that is not divided has the union of what its eighths need.
//!
//! Cost: a few evaluations of what matters for each cell, eight cells at a time, on all cores. Where the cells or their lists
//! would be too many, lists are allowed to be longer.

use super::ShapeGrid;
use crate::blend::{Blend, BlendProfile};
use crate::graph::{Field, Leaf};
use crate::number::{Mask8, Real, Vec3};
use crate::registry::union;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use wide::f32x8;

/// Cells along the longest edge before anything is divided.
const ROOTS: u32 = 4;
/// Into how many parts along each axis the cells of each level are divided, as powers of two.
pub(crate) const SPLITS: [u32; 5] = [2, 2, 1, 1, 1];
/// The smallest cells that a root has along each axis, as a power of two.
pub(crate) const BITS: u32 = 7;
/// A list that needs no shorter ones.
const SHORT: usize = 4;
/// How many half diagonals from a surface a cell keeps no list.
const FAR: f32 = 2.0;
/// The most cells.
const MOST_CELLS: usize = 1 << 20;
/// The most numbers in all lists together.
const MOST_NUMBERS: usize = 1 << 23;
/// Space around the shape_grid, as a share of its size.
const MARGIN: f32 = 1.0 / 64.0;
/// For the rounding of points and centres.
const SLACK: f32 = 1.001;

/// A part of space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cell {
    /// Divided; the number of its first part.
    Split { first: u32 },
    /// The shapes that matter are these of the lists.
    Near { start: u32, length: u32 },
    /// Far from every surface: the nearest point of the surface to the centre, the distance there, and the leaf whose material
    /// shows.
    Far { surface: [f32; 3], distance: f32, leaf: u32 },
}

/// The cells of a shape_grid.
#[derive(Clone, Debug)]
pub(crate) struct SparseGrid {
    /// Corner of smallest coordinates.
    pub(crate) min: [f32; 3],
    /// Edge of the smallest cells, metres.
    pub(crate) edge: f32,
    /// Roots along each axis; they come first, x fastest.
    pub(crate) roots: [u32; 3],
    pub(crate) cells: Vec<Cell>,
    /// Numbers of shapes in the fold, rising in each list.
    pub(crate) lists: Vec<u32>,
    /// Of all shapes.
    pub(crate) lipschitz: f32,
}

/// The cell around a point, or nearest to it.
pub(super) struct Found<'a> {
    pub(super) cell: &'a Cell,
    pub(super) centre: [f32; 3],
    /// Whether the point is in it.
    pub(super) inside: bool,
}

impl SparseGrid {
    /// Builds the grid of a shape_grid.
    pub(super) fn new(field: &Field, shape_grid: &ShapeGrid) -> Self {
        // Where cells are too many the next attempt is with longer lists: begin where the first one may do.
        let thousands = shape_grid.leaves.len() as f32 / 1000.0;
        let mut short = SHORT * (thousands.powf(0.6).round() as usize).clamp(1, 16);
        loop {
            if let Some(grid) = Builder::new(field, shape_grid, short).build() {
                return grid;
            }
            short *= 2;
        }
    }

    /// What it takes, bytes.
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

/// The middle of a cell along an axis: the number `place` among those of its size.
fn centre(min: f32, edge: f32, place: u32, shift: u32) -> f32 {
    min + (place as f32 + 0.5) * (edge * (1 << shift) as f32)
}

/// Cells and lists of one root; numbers count from its own first ones.
#[derive(Default)]
struct Part {
    cells: Vec<Cell>,
    lists: Vec<u32>,
    /// Start and length of the latest list.
    latest: (u32, u32),
}

struct Builder<'a> {
    field: &'a Field,
    shape_grid: &'a ShapeGrid,
    leaves: Vec<&'a Leaf>,
    min: [f32; 3],
    edge: f32,
    roots: [u32; 3],
    lipschitz: f32,
    /// The longest list that is not divided.
    short: usize,
    /// What is less than rounding, metres.
    negligible: f32,
    /// How much farther than the nearest shape one must be to be forgotten by the blends between them, metres.
    forgotten: f32,
    cells: AtomicUsize,
    numbers: AtomicUsize,
}

/// A cell that is to be made.
struct Wanted {
    /// Among the cells of its size.
    place: [u32; 3],
    list: Vec<u32>,
    /// Length of the list around it.
    around: usize,
    /// The shape_grid's at its centre.
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
        // In the middle of its cells.
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
            forgotten: shape_grid.smooth.map_or(0.0, |blend| forgotten(blend, negligible)),
            cells: AtomicUsize::new(0),
            numbers: AtomicUsize::new(0),
        }
    }

    /// The grid; `None` where it would be too large.
    fn build(&self) -> Option<SparseGrid> {
        let [nx, ny, nz] = self.roots;
        let places: Vec<[u32; 3]> =
            (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect();
        let everyone: Vec<u32> = (0..self.leaves.len() as u32).collect();
        let wanted: Vec<Wanted> =
            places.par_chunks(8).flat_map_iter(|places| self.pruned(places, BITS, &everyone)).collect();
        let parts: Option<Vec<(Cell, Part)>> = wanted
            .into_par_iter()
            .map(|wanted| {
                let mut part = Part::default();
                let cell = self.settle(wanted, 0, &mut part)?;
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

    /// Edge of the cells of this size, metres.
    fn size(&self, shift: u32) -> f32 {
        self.edge * (1 << shift) as f32
    }

    /// By how much a distance may change from the centre of a cube of this edge to its corners.
    fn change(&self, edge: f32) -> f32 {
        0.5 * 3f32.sqrt() * SLACK * self.lipschitz * edge + self.negligible
    }

    /// Makes a cell and what is in it; `None` where there is too much of all.
    fn settle(&self, wanted: Wanted, level: usize, part: &mut Part) -> Option<Cell> {
        let Wanted { place, list, around, distance } = wanted;
        let is_divisible = level < SPLITS.len() && (level == 0 || 5 * list.len() < 4 * around);
        // All in one list: there is nothing smaller.
        let is_hopeless = self.short >= self.leaves.len();
        let (centre, edge) = (self.centre(place, Self::shift(level)), self.size(Self::shift(level)));
        let list = if level > 1 { self.needed(centre, edge, 1, list) } else { list };
        if list.len() > self.short && !is_hopeless {
            if distance.abs() >= FAR * self.change(edge)
                && let Some(cell) = self.far(centre, &list, distance)
            {
                return Some(cell);
            }
            if is_divisible {
                return self.divide(place, level, &list, part);
            }
        }
        let list = if is_hopeless { list } else { self.needed(centre, edge, 2, list) };
        let (start, length) = part.latest;
        // Often that of the cell before.
        if part.lists[start as usize..(start + length) as usize] == list {
            return Some(Cell::Near { start, length });
        }
        let (start, length) = (part.lists.len(), list.len());
        let numbers = self.numbers.fetch_add(length, Ordering::Relaxed) + length;
        if numbers > MOST_NUMBERS.max(self.leaves.len()) && !is_hopeless {
            return None;
        }
        part.lists.extend(list);
        part.latest = (start as u32, length as u32);
        Some(Cell::Near { start: start as u32, length: length as u32 })
    }

    /// What the parts of a cube need of its list, which is halved along each axis so often.
    fn needed(&self, centre: [f32; 3], edge: f32, halvings: u32, list: Vec<u32>) -> Vec<u32> {
        if halvings == 0 || list.len() <= SHORT {
            return list;
        }
        let edge = 0.5 * edge;
        let eighths = halves([0; 3]).map(|half| std::array::from_fn(|k| centre[k] + (half[k] as f32 - 0.5) * edge));
        let (matters, _) = self.sieve(&eighths, edge, &list);
        let of = |mask: u32| list.iter().zip(&matters).filter(move |(_, matters)| *matters & mask != 0);
        if halvings == 1 {
            return of(0xff).map(|(&number, _)| number).collect();
        }
        let eighths = eighths.into_iter().enumerate().flat_map(|(lane, centre)| {
            self.needed(centre, edge, halvings - 1, of(1 << lane).map(|(&number, _)| number).collect())
        });
        let mut needed: Vec<u32> = eighths.collect();
        needed.sort_unstable();
        needed.dedup();
        needed
    }

    fn divide(&self, place: [u32; 3], level: usize, list: &[u32], part: &mut Part) -> Option<Cell> {
        let (bits, shift) = (SPLITS[level], Self::shift(level));
        let count = 1 << (3 * bits);
        if self.cells.fetch_add(count, Ordering::Relaxed) + count > MOST_CELLS {
            return None;
        }
        let first = part.cells.len();
        part.cells.resize(first + count, Cell::Near { start: 0, length: 0 });
        // By halves, so that eight neighbours are pruned from what matters around them.
        let mut blocks = vec![(place, list.to_vec())];
        for shift in (shift - bits + 1..shift).rev() {
            let halves = |(place, list): (_, Vec<u32>)| self.pruned(&halves(place), shift, &list);
            blocks = blocks.into_iter().flat_map(halves).map(|wanted| (wanted.place, wanted.list)).collect();
        }
        for (block, inner) in blocks {
            for mut wanted in self.pruned(&halves(block), shift - bits, &inner) {
                wanted.around = list.len();
                let [x, y, z] = wanted.place.map(|v| v & ((1 << bits) - 1));
                let number = (((z << bits) + y) << bits) + x;
                let cell = self.settle(wanted, level + 1, part)?;
                part.cells[first + number as usize] = cell;
            }
        }
        Some(Cell::Split { first: first as u32 })
    }

    /// The cells at these places, at most eight, with what matters in them of a list.
    fn pruned(&self, places: &[[u32; 3]], shift: u32, list: &[u32]) -> Vec<Wanted> {
        let centres: Vec<[f32; 3]> = places.iter().map(|&place| self.centre(place, shift)).collect();
        let (matters, distance) = self.sieve(&centres, self.size(shift), list);
        let distance = distance.to_array();
        let wanted = places.iter().enumerate().map(|(lane, &place)| {
            let kept = list.iter().zip(&matters).filter(|(_, matters)| *matters >> lane & 1 == 1);
            let list = kept.map(|(&number, _)| number).collect();
            Wanted { place, list, around: matters.len(), distance: distance[lane] }
        });
        wanted.collect()
    }

    /// Which shapes of a list matter in which of at most eight cubes of this edge, and the distances at their centres.
    fn sieve(&self, centres: &[[f32; 3]], edge: f32, list: &[u32]) -> (Vec<u32>, f32x8) {
        let lane = |axis: usize| f32x8::from(std::array::from_fn(|k| centres.get(k).unwrap_or(&centres[0])[axis]));
        let p = Vec3::new(lane(0), lane(1), lane(2));
        let distance = |&number: &u32| {
            let distance: f32x8 = self.leaves[number as usize].distance(p);
            if self.shape_grid.separate { distance.abs() } else { distance }
        };
        let distances: Vec<f32x8> = list.iter().map(distance).collect();
        let change = f32x8::splat(2.0 * self.change(edge));
        match self.shape_grid.smooth {
            None => nearest(&distances, change),
            Some(blend) => self.blended(&distances, change, blend),
        }
    }

    /// Which shapes matter of a smooth union at which of eight points, where distances may differ by so much, and its distances.
    fn blended(&self, distances: &[f32x8], change: f32x8, blend: Blend) -> (Vec<u32>, f32x8) {
        let width = f32x8::splat(blend.amount.max(1e-6));
        let operator = union();
        let least = distances.iter().fold(f32x8::splat(f32::INFINITY), |least, &distance| least.fast_min(distance));
        let farthest = least + f32x8::splat(self.forgotten) + change;
        let mut result = f32x8::splat(f32::INFINITY);
        let mut matters = Vec::with_capacity(distances.len());
        // How far the result before each shape is behind it, at least.
        let mut behind = Vec::with_capacity(distances.len());
        // The shapes that all before are forgotten for.
        let mut firsts = [0; 8];
        for (place, &distance) in distances.iter().enumerate() {
            let nothing = distance.simd_ge(result + width + change) | distance.simd_ge(farthest);
            let before = result - distance - change;
            let all = before.simd_ge(width);
            let blended = operator.distance(result, distance, Some(blend));
            let taken = Real::select(Mask8(all), distance, blended);
            result = Real::select(Mask8(nothing), result, taken);
            matters.push(!nothing.to_bitmask());
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
            // A change of the result before a shape is this much of one at the end.
            let mut share = 1.0;
            let mut least = first;
            for place in (first..matters.len()).rev().filter(|&place| matters[place] >> lane & 1 == 1) {
                let behind = behind[place][lane];
                if behind >= 0.0 && blend.reach() * share <= self.negligible {
                    least = place;
                    break;
                }
                share *= left(blend, behind / blend.amount.max(1e-6));
            }
            matters[..least].iter_mut().for_each(|matters| *matters &= !(1 << lane));
        }
        (matters, result)
    }

    /// A cell far from every surface, if the nearest point of it can be told.
    fn far(&self, centre: [f32; 3], list: &[u32], distance: f32) -> Option<Cell> {
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

/// Which shapes matter of a sharp union at which of eight points, where distances may differ by so much, and its distances.
fn nearest(distances: &[f32x8], change: f32x8) -> (Vec<u32>, f32x8) {
    let least = distances.iter().fold(f32x8::splat(f32::INFINITY), |least, &distance| least.fast_min(distance));
    let matters = |distance: &f32x8| !distance.simd_gt(least + change).to_bitmask();
    (distances.iter().map(matters).collect(), least)
}

/// The eight parts of a cell.
fn halves([x, y, z]: [u32; 3]) -> [[u32; 3]; 8] {
    std::array::from_fn(|k| [2 * x + (k as u32 & 1), 2 * y + (k as u32 >> 1 & 1), 2 * z + (k as u32 >> 2)])
}

/// How much farther than another a shape must be so that blends leave less of it than is negligible.
fn forgotten(blend: Blend, negligible: f32) -> f32 {
    let width = blend.amount.max(1e-6);
    let rate = match blend.profile {
        BlendProfile::Soft => 2.0,
        BlendProfile::Round => 1.9,
        BlendProfile::Chamfer => 0.69,
        BlendProfile::Stairs => return f32::INFINITY,
    };
    width * (2.0 + (2.0 * width / negligible).ln().max(0.0) / rate)
}

/// How much of a change of the farther distance a blend leaves, at most, where that is at least so many widths behind.
fn left(blend: Blend, behind: f32) -> f32 {
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
