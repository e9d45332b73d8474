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
//! The lists of the root cells are made at once, a root's descendants when a point in it is first looked up, or all on every
//! core for a kernel. So a picture on the CPU waits only for what its rays pass. A root's descendants are a function of its
//! own list alone, whoever asks first. Each root has a share of the cells and list entries that are allowed; if they do not
//! suffice, it is built again with longer lists.
//!
//! **Motion.** A field in motion is evaluated a few times only. Its cells are [coarse](Field::with_coarse_grids): lists of four
//! times the length, without the last pruning, by the parts of their cells. They are kept beside the fine ones: what is not in
//! motion never evaluates them, so that its values do not depend on what was in motion before.
//!
//! **Edits.** Roots have one of eight sizes for each power of two, and their places are multiples of it, so that a small change of
//! the bounds seldom moves them. After an edit, blocks of roots keep their lists if no shape that has changed is near
//! them or was. They keep their roots' lists if their own lists are the same and no shape in them has changed, and roots keep
//! their descendants likewise.
//!
//! Cost: a few evaluations of the listed shapes for each cell, eight cells at a time.

use super::code_values::CodeValues;
use super::{Member, ShapeGrid};
use crate::blend::{Blend, BlendProfile};
use crate::graph::Field;
use crate::graph::far_field::FarField;
use crate::number::{Mask8, Real, Vec3};
use crate::registry::union;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use wide::f32x8;

/// Root cells along the longest edge, if they begin at its end.
const ROOTS: u32 = 16;
/// Largest number of root cells along an edge.
const MAX_ROOTS: f32 = (ROOTS + 2) as f32;
/// Root cells along each axis whose lists are pruned together, as a power of two.
const BLOCK: u32 = 2;
/// Number of blocks that a task of the pool prunes.
const CHUNK: usize = 8;
/// Splits of the cells of each level along each axis, as powers of two.
pub(crate) const SPLITS: [u32; 4] = [2, 1, 1, 1];
/// Smallest cells of a root along each axis, as a power of two.
pub(crate) const BITS: u32 = 5;
/// Length up to which a list is not pruned further.
const SHORT: usize = 4;
/// Factor on that length in coarse cells.
const COARSE: usize = 4;
/// Distance from a surface, in half diagonals, from which a cell has no list.
const FAR: f32 = 2.0;
/// Largest number of cells, of all roots and that of each that is always allowed.
const MAX_CELLS: [usize; 2] = [1 << 20, 640];
/// Largest number of entries of lists, likewise.
const MAX_ENTRIES: [usize; 2] = [1 << 23, 1 << 13];
/// Margin around the bounds, as a fraction of their size.
const MARGIN: f32 = 1.0 / 64.0;
/// Relative rounding error.
const ROUNDING: f32 = 6e-8;
/// Factor on cell sizes, for the rounding of points and centres.
const SLACK: f32 = 1.001;

/// Cell of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Cell {
    /// Split; the index of its first child.
    Split { first: u32 },
    /// Near a surface; its shapes are this range of the lists.
    Near { start: u32, length: u32 },
    /// Far from every surface: the surface point nearest to the centre, metres; the distance of the centre, metres; and the
    /// leaf whose material shows.
    Far { surface: [f32; 3], distance: f32, leaf: u32 },
}

/// A [`Cell`] in eight bytes, so that more of them are in the caches: its kind and an index (of the first child, of the list's
/// start, or of the far cell), and the length of the list.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PackedCell {
    kind_and_index: u32,
    length: u32,
}

/// [`Cell::Far`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct FarCell {
    surface: [f32; 3],
    distance: f32,
    leaf: u32,
}

impl PackedCell {
    const INDEX_BITS: u32 = 30;
    const NEAR: u32 = 0;
    const SPLIT: u32 = 1;
    const FAR: u32 = 2;

    fn new(kind: u32, index: usize, length: usize) -> Self {
        debug_assert!(index < 1 << Self::INDEX_BITS, "there are fewer cells and entries");
        Self { kind_and_index: kind << Self::INDEX_BITS | index as u32, length: length as u32 }
    }

    fn kind(self) -> u32 {
        self.kind_and_index >> Self::INDEX_BITS
    }

    fn index(self) -> u32 {
        self.kind_and_index & ((1 << Self::INDEX_BITS) - 1)
    }
}

/// Cells of a shape grid and their lists.
#[derive(Debug)]
pub(crate) struct SparseGrid {
    /// Corner of smallest coordinates.
    pub(crate) min: [f32; 3],
    /// Edge of the smallest cells, metres.
    pub(crate) edge: f32,
    /// Number of roots along each axis.
    pub(crate) counts: [u32; 3],
    /// Lipschitz constant of all members.
    pub(crate) lipschitz: f32,
    /// [`ShapeGrid::code_width`], metres.
    pub(crate) code_width: f32,
    /// Distance below rounding, metres.
    negligible: f32,
    /// Distance behind the nearest shape beyond which blends leave nothing of a shape, metres.
    cutoff: f32,
    /// Length up to which fine cells are not split.
    short: usize,
    /// Roots, x fastest.
    roots: Vec<Root>,
    /// Their cells, once they are built.
    cells: Vec<BuiltCells>,
    /// Blocks of roots, x fastest.
    blocks: Vec<Arc<Block>>,
    /// Length of all their lists together.
    entries: usize,
}

/// Root cell.
#[derive(Clone, Debug)]
struct Root {
    /// Positions in the fold of the shapes that affect it.
    list: Arc<[u32]>,
    /// Length of the list of its block.
    block_length: usize,
    /// Distance of the union at its centre, metres.
    distance: f32,
}

/// Block of roots, whose lists are pruned together.
#[derive(Debug, Default)]
struct Block {
    /// Shapes that affect it.
    list: Vec<u32>,
    /// Distance at its centre beyond which a shape affects neither it nor its list, metres.
    reach: f32,
    /// A bit for each shape, set if it is not beyond that distance.
    near: Vec<u64>,
}

impl Block {
    /// True if its list is the same after shapes have changed, whose distances at its centre are given.
    fn keeps_list(&self, changed: impl IntoIterator<Item = (u32, f32)>) -> bool {
        let was_near = |number: u32| self.near[number as usize / 64] >> (number % 64) & 1 == 1;
        changed.into_iter().all(|(number, distance)| is_beyond(distance, self.reach) && !was_near(number))
    }
}

/// True if a distance is beyond a reach; what is not a number is not.
fn is_beyond(distance: f32, reach: f32) -> bool {
    distance > reach
}

/// Cells of a root, once they are built.
#[derive(Debug, Default)]
struct BuiltCells {
    fine: OnceLock<Arc<RootCells>>,
    coarse: OnceLock<Arc<RootCells>>,
}

/// Root cell and its descendants.
#[derive(Debug)]
struct RootCells {
    /// Length up to which cells were not split.
    short: usize,
    /// The root, then its descendants.
    cells: Vec<PackedCell>,
    far: Vec<FarCell>,
    /// Positions of shapes in the fold, ascending within each list.
    lists: Vec<u32>,
}

impl RootCells {
    fn unpacked(&self, cell: PackedCell) -> Cell {
        let index = cell.index();
        match cell.kind() {
            PackedCell::NEAR => Cell::Near { start: index, length: cell.length },
            PackedCell::SPLIT => Cell::Split { first: index },
            _ => {
                let FarCell { surface, distance, leaf } = self.far[index as usize];
                Cell::Far { surface, distance, leaf }
            }
        }
    }
}

/// All cells, the roots first, and all lists.
pub(crate) struct AllCells {
    pub(crate) cells: Vec<Cell>,
    pub(crate) lists: Vec<u32>,
}

/// Cell that contains a point, or the nearest one.
pub(super) struct Found<'a> {
    pub(super) cell: FoundCell<'a>,
    pub(super) centre: [f32; 3],
    /// True if the point is in it.
    pub(super) inside: bool,
}

/// Its content.
pub(super) enum FoundCell<'a> {
    /// Near a surface; its shapes.
    Near(&'a [u32]),
    /// As [`Cell::Far`].
    Far { surface: [f32; 3], distance: f32, leaf: u32 },
}

impl SparseGrid {
    /// Prepares the grid: the lists of its roots.
    pub(super) fn new(field: &Field, shape_grid: &ShapeGrid) -> Self {
        let count = shape_grid.members.len();
        let (min, max) = (shape_grid.bounds.min, shape_grid.bounds.max);
        let size = (0..3).map(|k| max[k] - min[k]).fold(1e-6, f32::max);
        let extent = min.iter().chain(&max).map(|v| v.abs()).fold(size, f32::max);
        let code_width = shape_grid.code_width(shape_grid.smooth.map_or(0.0, |blend| cutoff(blend, ROUNDING * extent)));
        // The bound outside must be large enough.
        let margin = (size * MARGIN).max(1e-5 * extent) + code_width + shape_grid.margin;
        // The next of eight sizes for each power of two.
        let root = (8.0 * ((size + 2.0 * margin) / ROOTS as f32).log2()).ceil();
        let root = (root / 8.0).exp2();
        let first = min.map(|min| ((min - margin) / root).floor());
        let counts =
            std::array::from_fn(|k| (((max[k] + margin) / root).ceil() - first[k]).clamp(1.0, MAX_ROOTS) as u32);
        let end = |k: usize| (first[k] + counts[k] as f32).abs().max(first[k].abs());
        let negligible = ROUNDING * root * end(0).max(end(1)).max(end(2));
        let slopes = shape_grid.leaves().map(|leaf| {
            let leaf = &field.leaves[leaf as usize];
            leaf.shape.lipschitz(&leaf.params)
        });
        let slopes = slopes.chain(shape_grid.code.iter().map(|tree| field.tree_lipschitz(tree)));
        let mut grid = Self {
            min: first.map(|first| first * root),
            edge: root / (1 << BITS) as f32,
            counts,
            lipschitz: slopes.fold(1.0, f32::max),
            code_width,
            negligible,
            cutoff: shape_grid.smooth.map_or(0.0, |blend| cutoff(blend, negligible)),
            short: SHORT * ((count as f32 / 1000.0).powf(0.6).round() as usize).clamp(1, 16),
            roots: Vec::new(),
            cells: Vec::new(),
            blocks: Vec::new(),
            entries: 0,
        };
        let previous =
            shape_grid.previous.as_ref().and_then(|previous| Some((previous.grid.get()?, &*previous.changed)));
        let previous = previous.filter(|(before, _)| grid.key() == before.key());
        grid.make_roots(field, shape_grid, previous);
        grid.cells = grid.roots.iter().map(|_| BuiltCells::default()).collect();
        grid.entries = grid.roots.iter().map(|root| root.list.len()).sum::<usize>().max(1);
        if let Some((before, changed)) = previous {
            grid.take_over(before, changed);
        }
        grid
    }

    /// Makes the blocks and the roots: those of an earlier grid of the same key where they are the same. With that grid comes
    /// true for each shape that differs.
    fn make_roots(&mut self, field: &Field, shape_grid: &ShapeGrid, previous: Option<(&Self, &[bool])>) {
        let counts = self.counts;
        let [nx, ny, nz] = counts.map(|count| count.div_ceil(1 << BLOCK));
        let places = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let places: Vec<[u32; 3]> = places.collect();
        let is_stale = match previous {
            Some((before, changed)) => {
                (self.blocks, self.roots) = (before.blocks.clone(), before.roots.clone());
                self.are_stale(field, shape_grid, &places, changed)
            }
            None => {
                let no_root = Root { list: Arc::new([]), block_length: 0, distance: 0.0 };
                self.blocks = vec![Arc::default(); places.len()];
                self.roots = vec![no_root; counts.iter().product::<u32>() as usize];
                vec![true; places.len()]
            }
        };
        let stale: Vec<usize> = (0..places.len()).filter(|&index| is_stale[index]).collect();
        let of_chunk = |indices: &[usize]| {
            let chunk: Vec<[u32; 3]> = indices.iter().map(|&index| places[index]).collect();
            let all = 0..shape_grid.members.len();
            let mut pruner = Pruner::new(field, shape_grid, self, (0..all.len() as u32).collect());
            let lists = pruner.prune_each(&chunk, BITS + BLOCK, all).map(|pruned| pruned.list);
            let reaches = pruner.reach(pruner.size(BITS + BLOCK)).to_array();
            let block = |(lane, (list, reach)): (usize, (&Range<usize>, f32))| {
                let bit = |distances: &f32x8| u64::from(!is_beyond(distances.as_array()[lane], reach));
                let word = |distances: &[f32x8]| distances.iter().rev().fold(0, |word, it| word << 1 | bit(it));
                let near = pruner.distances.chunks(64).map(word).collect();
                Block { list: pruner.stack[list.clone()].to_vec(), reach, near }
            };
            let blocks: Vec<Block> = lists.iter().zip(reaches).take(indices.len()).enumerate().map(block).collect();
            let with_roots = |((&index, block), list): ((&usize, Block), Range<usize>)| {
                let mut roots = Vec::new();
                let is_same = previous.is_some_and(|(before, changed)| {
                    before.blocks[index].list == block.list && is_unchanged(&block.list, changed)
                });
                if !is_same {
                    pruner.prune_roots(places[index], BLOCK, list, block.list.len(), &mut roots);
                }
                (index, block, roots)
            };
            indices.iter().zip(blocks).zip(lists).map(with_roots).collect::<Vec<_>>()
        };
        let made: Vec<_> = stale.par_chunks(CHUNK).flat_map_iter(of_chunk).collect();
        for (index, block, roots) in made {
            self.blocks[index] = Arc::new(block);
            for (index, root) in roots {
                self.roots[index] = root;
            }
        }
    }

    /// True for each block whose list may be another than that of before, after shapes have changed.
    fn are_stale(&self, field: &Field, shape_grid: &ShapeGrid, places: &[[u32; 3]], changed: &[bool]) -> Vec<bool> {
        let numbers: Vec<u32> = (0..changed.len() as u32).filter(|&number| changed[number as usize]).collect();
        // If many have changed, few lists are the same.
        if 4 * numbers.len() > changed.len() {
            return vec![true; places.len()];
        }
        let mut pruner = Pruner::new(field, shape_grid, self, numbers.clone());
        let mut are_stale = Vec::with_capacity(places.len());
        for (blocks, places) in self.blocks.chunks(CHUNK).zip(places.chunks(CHUNK)) {
            let centres = pruner.centres(places, BITS + BLOCK);
            pruner.find_distances(&centres, 0..numbers.len());
            are_stale.extend(blocks.iter().enumerate().map(|(lane, block)| {
                let at_centre = pruner.distances.iter().map(|distances| distances.as_array()[lane]);
                !block.keeps_list(numbers.iter().copied().zip(at_centre))
            }));
        }
        are_stale
    }

    /// Numbers that two grids have in common if what one has built can serve the other.
    fn key(&self) -> impl PartialEq {
        (self.min, self.edge, self.counts, self.lipschitz, self.negligible, self.cutoff, self.short)
    }

    /// Takes the descendants of those roots from an earlier grid of the same key that building them would repeat.
    fn take_over(&self, before: &Self, changed: &[bool]) {
        let is_within = |length: usize, root: &Root, most: [usize; 2]| length <= self.share(root, most);
        for (index, (root, root_before)) in self.roots.iter().zip(&before.roots).enumerate() {
            let is_same = root.list == root_before.list
                && root.block_length == root_before.block_length
                && root.distance == root_before.distance
                && is_unchanged(&root.list, changed);
            if !is_same {
                continue;
            }
            let (cells, cells_before) = (&self.cells[index], &before.cells[index]);
            for (cells, cells_before, is_coarse) in
                [(&cells.fine, &cells_before.fine, false), (&cells.coarse, &cells_before.coarse, true)]
            {
                let serves = |cells: &RootCells| {
                    cells.short == self.short(is_coarse)
                        && is_within(cells.cells.len() - 1, root, MAX_CELLS)
                        && is_within(cells.lists.len(), root, MAX_ENTRIES)
                };
                if let Some(before) = cells_before.get().filter(|before| serves(before)) {
                    cells.get_or_init(|| before.clone());
                }
            }
        }
    }

    /// Length up to which cells are not split, unless there would be too many.
    fn short(&self, is_coarse: bool) -> usize {
        if is_coarse { COARSE * self.short } else { self.short }
    }

    /// Share of a root in a largest number.
    fn share(&self, root: &Root, [of_all, of_each]: [usize; 2]) -> usize {
        ((of_all as f64 * root.list.len() as f64 / self.entries as f64) as usize).max(of_each)
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let of_cells =
            |root: &Arc<RootCells>| size_of_val(&*root.cells) + size_of_val(&*root.far) + size_of_val(&*root.lists);
        let blocks =
            self.blocks.iter().map(|block| size_of_val(&*block.list) + size_of_val(&*block.near)).sum::<usize>();
        let roots: usize = self.roots.iter().map(|root| size_of::<Root>() + size_of_val(&*root.list)).sum();
        let built = self.cells.iter().flat_map(|cells| [&cells.fine, &cells.coarse]).filter_map(OnceLock::get);
        blocks + roots + built.map(of_cells).sum::<usize>()
    }

    /// A root's cells, built on first use.
    fn root_cells(&self, field: &Field, shape_grid: &ShapeGrid, index: usize) -> &RootCells {
        let BuiltCells { fine, coarse } = &self.cells[index];
        let build = |is_coarse| Arc::new(self.build_root(field, shape_grid, index, is_coarse));
        match fine.get() {
            Some(fine) => fine,
            None if field.coarse_grids => coarse.get_or_init(|| build(true)),
            None => fine.get_or_init(|| build(false)),
        }
    }

    /// Builds the cells of a root, with longer lists if there would be more than its share.
    fn build_root(&self, field: &Field, shape_grid: &ShapeGrid, index: usize, is_coarse: bool) -> RootCells {
        let root = &self.roots[index];
        let ([nx, ny, _], number) = (self.counts, index as u32);
        let place = [number % nx, number / nx % ny, number / (nx * ny)];
        let mut short = self.short(is_coarse);
        loop {
            // Lists of all shapes cannot get longer.
            let is_unlimited = short >= root.list.len();
            let mut builder = RootBuilder {
                pruner: Pruner::new(field, shape_grid, self, root.list.to_vec()),
                short,
                is_coarse,
                max_cells: if is_unlimited { usize::MAX } else { self.share(root, MAX_CELLS) },
                max_entries: if is_unlimited { usize::MAX } else { self.share(root, MAX_ENTRIES) },
                cells: vec![PackedCell::new(PackedCell::NEAR, 0, 0)],
                far: Vec::new(),
                lists: Vec::new(),
                last_list: 0..0,
            };
            let pending = Pruned { list: 0..root.list.len(), distance: root.distance };
            if let Some(cell) = builder.build_cell(place, 0, &pending, root.block_length) {
                builder.cells[0] = cell;
                let RootBuilder { cells, far, lists, .. } = builder;
                return RootCells { short, cells, far, lists };
            }
            short *= 2;
        }
    }

    /// Builds all cells on all cores.
    pub(super) fn build(&self, field: &Field, shape_grid: &ShapeGrid) {
        (0..self.roots.len()).into_par_iter().for_each(|index| {
            self.root_cells(field, shape_grid, index);
        });
    }

    /// All cells and lists. Builds those that are missing.
    pub(super) fn all_cells(&self, field: &Field, shape_grid: &ShapeGrid) -> AllCells {
        self.build(field, shape_grid);
        let roots: Vec<&RootCells> =
            (0..self.roots.len()).map(|index| self.root_cells(field, shape_grid, index)).collect();
        let moved = |cell: Cell, first_cell: usize, first_entry: usize| match cell {
            // The root itself is not among its descendants.
            Cell::Split { first } => Cell::Split { first: first - 1 + first_cell as u32 },
            Cell::Near { start, length } => Cell::Near { start: start + first_entry as u32, length },
            far => far,
        };
        let (mut first_cell, mut first_entry) = (roots.len(), 0);
        let mut all = AllCells { cells: Vec::new(), lists: Vec::new() };
        for root in &roots {
            all.cells.push(moved(root.unpacked(root.cells[0]), first_cell, first_entry));
            (first_cell, first_entry) = (first_cell + root.cells.len() - 1, first_entry + root.lists.len());
        }
        for root in &roots {
            let (first_cell, first_entry) = (all.cells.len(), all.lists.len());
            all.cells.extend(root.cells[1..].iter().map(|&cell| moved(root.unpacked(cell), first_cell, first_entry)));
            all.lists.extend(&root.lists);
        }
        all
    }

    pub(super) fn find(&self, field: &Field, shape_grid: &ShapeGrid, p: [f32; 3]) -> Found<'_> {
        let mut inside = true;
        let inverse = 1.0 / self.edge;
        let place: [u32; 3] = std::array::from_fn(|k| {
            let (at, count) = ((p[k] - self.min[k]) * inverse, (self.counts[k] << BITS) as f32);
            inside &= at >= 0.0 && at < count;
            at.clamp(0.0, count - 1.0) as u32
        });
        let [x, y, z] = place.map(|v| v >> BITS);
        let index = (z * self.counts[1] + y) * self.counts[0] + x;
        let root = self.root_cells(field, shape_grid, index as usize);
        // Selection instead of branches, which no processor predicts here.
        let (mut cell, mut shift) = (0, BITS);
        for bits in SPLITS {
            let packed = root.cells[cell];
            let is_split = packed.kind() == PackedCell::SPLIT;
            let finer = shift - bits;
            let [x, y, z] = place.map(|v| v >> finer & ((1 << bits) - 1));
            let child = packed.index() + (((z << bits) + y) << bits) + x;
            cell = if is_split { child as usize } else { cell };
            shift = if is_split { finer } else { shift };
        }
        let cell = root.cells[cell];
        let cell = match root.unpacked(cell) {
            Cell::Near { start, length } => FoundCell::Near(&root.lists[start as usize..(start + length) as usize]),
            Cell::Far { surface, distance, leaf } => FoundCell::Far { surface, distance, leaf },
            // The cells of the last level are never split.
            Cell::Split { .. } => FoundCell::Near(&[]),
        };
        let centre = std::array::from_fn(|k| centre(self.min[k], self.edge, place[k] >> shift, shift));
        Found { cell, centre, inside }
    }
}

/// Reports whether no shape of a list has changed.
fn is_unchanged(list: &[u32], changed: &[bool]) -> bool {
    list.iter().all(|&number| !changed[number as usize])
}

/// Centre of a cell along an axis; `place` is its index among the cells of its size.
fn centre(min: f32, edge: f32, place: u32, shift: u32) -> f32 {
    min + (place as f32 + 0.5) * (edge * (1 << shift) as f32)
}

/// Part of a list that matters in a cube.
#[derive(Clone, Default)]
struct Pruned {
    /// Range of [`Pruner::stack`].
    list: Range<usize>,
    /// Distance of the union at the centre of the cube, metres.
    distance: f32,
}

/// Pruning of lists, with the memory that it needs.
struct Pruner<'a> {
    field: &'a Field,
    shape_grid: &'a ShapeGrid,
    min: [f32; 3],
    edge: f32,
    counts: [u32; 3],
    lipschitz: f32,
    negligible: f32,
    cutoff: f32,
    /// Lists, those of children behind those of their parents.
    stack: Vec<u32>,
    /// Distance of each shape of a list at eight points.
    distances: Vec<f32x8>,
    /// Least difference of the result before each shape and its distance.
    behind: Vec<f32x8>,
    /// Bit mask of the cubes in which each shape matters.
    keeps: Vec<u8>,
}

impl<'a> Pruner<'a> {
    fn new(field: &'a Field, shape_grid: &'a ShapeGrid, grid: &SparseGrid, list: Vec<u32>) -> Self {
        let &SparseGrid { min, edge, counts, lipschitz, negligible, cutoff, .. } = grid;
        let (distances, behind, keeps) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            field,
            shape_grid,
            min,
            edge,
            counts,
            lipschitz,
            negligible,
            cutoff,
            stack: list,
            distances,
            behind,
            keeps,
        }
    }

    fn centre(&self, place: [u32; 3], shift: u32) -> [f32; 3] {
        std::array::from_fn(|k| centre(self.min[k], self.edge, place[k], shift))
    }

    /// Centres of at most eight cells; the others are those of the first.
    fn centres(&self, places: &[[u32; 3]], shift: u32) -> [[f32; 3]; 8] {
        std::array::from_fn(|lane| self.centre(*places.get(lane).unwrap_or(&places[0]), shift))
    }

    /// Edge of cells of this size, metres.
    fn size(&self, shift: u32) -> f32 {
        self.edge * (1 << shift) as f32
    }

    /// Largest change of a distance from the centre of a cube of this edge to its corners, metres.
    fn change(&self, edge: f32) -> f32 {
        0.5 * 3f32.sqrt() * SLACK * self.lipschitz * edge + self.negligible
    }

    /// Prunes a list for the roots in a cube of them, which are appended to `roots` with their indices.
    fn prune_roots(
        &mut self,
        place: [u32; 3],
        bits: u32,
        list: Range<usize>,
        block_length: usize,
        roots: &mut Vec<(usize, Root)>,
    ) {
        let counts = self.counts;
        let size = 1 << (bits - 1);
        let octants = octants_of(place).map(|place| place.map(|v| v * size));
        let top = self.stack.len();
        let pruned = self.prune_each(&octants_of(place), BITS + bits - 1, list);
        for ((octant, place), Pruned { list, distance }) in octants_of(place).into_iter().zip(octants).zip(pruned) {
            if (0..3).any(|k| place[k] >= counts[k]) {
                continue;
            }
            if bits > 1 {
                self.prune_roots(octant, bits - 1, list, block_length, roots);
                continue;
            }
            let [x, y, z] = place;
            let list = self.stack[list].into();
            let index = ((z * counts[1] + y) * counts[0] + x) as usize;
            roots.push((index, Root { list, block_length, distance }));
        }
        self.stack.truncate(top);
    }

    /// Prunes a list for each of at most eight cells. The lists are appended to the stack.
    fn prune_each(&mut self, places: &[[u32; 3]], shift: u32, list: Range<usize>) -> [Pruned; 8] {
        let distance = self.prune(&self.centres(places, shift), self.size(shift), list.clone()).to_array();
        let mut pruned: [Pruned; 8] = Default::default();
        for (lane, pruned) in pruned.iter_mut().enumerate().take(places.len()) {
            *pruned = Pruned { list: self.push_kept(list.clone(), 1 << lane), distance: distance[lane] };
        }
        pruned
    }

    /// Appends the shapes of a list that matter in any of these cubes to the stack.
    fn push_kept(&mut self, list: Range<usize>, cubes: u8) -> Range<usize> {
        let start = self.stack.len();
        for (place, keeps) in list.zip(&self.keeps) {
            if keeps & cubes != 0 {
                self.stack.push(self.stack[place]);
            }
        }
        start..self.stack.len()
    }

    /// Union of the pruned lists of a cube's parts, for this many levels of octants, at the end of the stack.
    fn prune_by_octants(&mut self, cube: [f32; 3], edge: f32, levels: u32, list: Range<usize>) -> Range<usize> {
        if levels == 0 || list.len() <= SHORT {
            return list;
        }
        let edge = 0.5 * edge;
        let octants = octants_of([0; 3]).map(|half| std::array::from_fn(|k| cube[k] + (half[k] as f32 - 0.5) * edge));
        self.prune(&octants, edge, list.clone());
        if levels == 1 {
            return self.push_kept(list, 0xff);
        }
        let keeps = self.keeps.clone();
        let mut matters = vec![false; list.len()];
        for (lane, &octant) in octants.iter().enumerate() {
            let start = self.stack.len();
            for (place, keeps) in list.clone().zip(&keeps) {
                if keeps >> lane & 1 == 1 {
                    self.stack.push(self.stack[place]);
                }
            }
            let inner = self.prune_by_octants(octant, edge, levels - 1, start..self.stack.len());
            // Both lists ascend.
            let mut place = list.start;
            for &number in &self.stack[inner] {
                while self.stack[place] != number {
                    place += 1;
                }
                matters[place - list.start] = true;
            }
            self.stack.truncate(start);
        }
        let start = self.stack.len();
        for (place, matters) in list.zip(matters) {
            if matters {
                self.stack.push(self.stack[place]);
            }
        }
        start..self.stack.len()
    }

    /// Finds the cubes of this edge in which each shape of a list matters, in `keeps`. Returns the distances of the union at
    /// their centres.
    fn prune(&mut self, centres: &[[f32; 3]; 8], edge: f32, list: Range<usize>) -> f32x8 {
        self.find_distances(centres, list);
        self.keeps.clear();
        match self.shape_grid.smooth {
            None => self.prune_sharp(edge),
            Some(blend) => self.prune_smooth(edge, blend),
        }
    }

    /// Finds the distances of the shapes of a list at eight points.
    fn find_distances(&mut self, points: &[[f32; 3]; 8], list: Range<usize>) {
        let lane = |axis: usize| f32x8::from(std::array::from_fn(|k| points[k][axis]));
        let p = Vec3::new(lane(0), lane(1), lane(2));
        self.distances.clear();
        for &number in &self.stack[list] {
            let distance: f32x8 = match self.shape_grid.members[number as usize] {
                Member::Shape(leaf) => self.field.leaves[leaf as usize].distance(p),
                Member::Code(index) => {
                    self.field.tree_distance(&self.shape_grid.code[index as usize], p, FarField::Exact)
                }
            };
            self.distances.push(if self.shape_grid.separate { distance.abs() } else { distance });
        }
    }

    /// Distances at the last points beyond which a shape matters in no cube of this size around them, metres.
    fn reach(&self, edge: f32) -> f32x8 {
        least_of(&self.distances) + f32x8::splat(self.cutoff) + self.uncertainty(edge)
    }

    /// Uncertainty of the difference of two distances within a cube of this edge, metres.
    fn uncertainty(&self, edge: f32) -> f32x8 {
        f32x8::splat(2.0 * self.change(edge))
    }

    /// Prunes a sharp union in cubes of this edge.
    fn prune_sharp(&mut self, edge: f32) -> f32x8 {
        let reach = self.reach(edge);
        let keeps = |distance: &f32x8| !distance.simd_gt(reach).to_bitmask() as u8;
        self.keeps.extend(self.distances.iter().map(keeps));
        least_of(&self.distances)
    }

    /// Prunes a smooth union in cubes of this edge.
    fn prune_smooth(&mut self, edge: f32, blend: Blend) -> f32x8 {
        let width = f32x8::splat(blend.amount.max(1e-6));
        let (change, farthest) = (self.uncertainty(edge), self.reach(edge));
        let operator = union();
        let mut result = f32x8::splat(f32::INFINITY);
        // First shape of each lane that all earlier ones do not affect.
        let mut first = f32x8::ZERO;
        self.behind.clear();
        for (place, &distance) in self.distances.iter().enumerate() {
            let nothing = distance.simd_ge(result + width + change) | distance.simd_gt(farthest);
            let before = result - distance - change;
            self.behind.push(before);
            let kept = !nothing.to_bitmask() as u8;
            self.keeps.push(kept);
            if kept == 0 {
                continue;
            }
            let all = before.simd_ge(width);
            let blended = operator.distance(result, distance, Some(blend));
            let taken = Real::select(Mask8(all), distance, blended);
            result = Real::select(Mask8(nothing), result, taken);
            first = Real::select(Mask8(all & !nothing), f32x8::splat(place as f32), first);
        }
        // From the last shape on: the slope of the final result in the result before each.
        let mut slope = f32x8::ONE;
        let (reach, negligible) = (f32x8::splat(blend.reach()), f32x8::splat(self.negligible));
        let mut least = first;
        let mut is_open = f32x8::ZERO.simd_le(f32x8::ZERO);
        for (place, &behind) in self.behind.iter().enumerate().rev() {
            let here = f32x8::splat(place as f32);
            is_open &= first.simd_le(here);
            if is_open.to_bitmask() == 0 {
                break;
            }
            let kept = lanes_of(self.keeps[place]) & is_open;
            let ends = kept & behind.simd_ge(f32x8::ZERO) & (reach * slope).simd_le(negligible);
            least = Real::select(Mask8(ends), here, least);
            is_open &= !ends;
            slope = Real::select(Mask8(kept), slope * remaining_slope(blend, behind / width), slope);
        }
        for (place, keeps) in self.keeps.iter_mut().enumerate() {
            let matters = least.simd_le(f32x8::splat(place as f32)).to_bitmask() as u8;
            if matters == 0xff {
                break;
            }
            *keeps &= matters;
        }
        result
    }
}

/// Construction of a root's cells.
struct RootBuilder<'a> {
    pruner: Pruner<'a>,
    /// Length up to which cells are not split.
    short: usize,
    /// Whether the last pruning of a list, by the parts of its cell, is left out.
    is_coarse: bool,
    max_cells: usize,
    max_entries: usize,
    cells: Vec<PackedCell>,
    far: Vec<FarCell>,
    lists: Vec<u32>,
    /// Range of the last list.
    last_list: Range<usize>,
}

impl RootBuilder<'_> {
    fn shift(level: usize) -> u32 {
        BITS - SPLITS[..level].iter().sum::<u32>()
    }

    /// Builds a cell and its children; `None` if there are too many. `parent_length` is the length of its parent's list.
    fn build_cell(
        &mut self,
        place: [u32; 3],
        level: usize,
        pruned: &Pruned,
        parent_length: usize,
    ) -> Option<PackedCell> {
        let &Pruned { ref list, distance } = pruned;
        let is_divisible = level < SPLITS.len() && 5 * list.len() < 4 * parent_length;
        let (centre, edge) = (self.pruner.centre(place, Self::shift(level)), self.pruner.size(Self::shift(level)));
        let mut list = list.clone();
        if level > 0 {
            list = self.pruner.prune_by_octants(centre, edge, 1, list);
        }
        if list.len() > self.short {
            if distance.abs() >= FAR * self.pruner.change(edge) + self.pruner.shape_grid.margin
                && let Some(cell) = self.far_cell(centre, edge, list.clone(), distance)
            {
                self.far.push(cell);
                return Some(PackedCell::new(PackedCell::FAR, self.far.len() - 1, 0));
            }
            if is_divisible {
                return self.split(place, level, list);
            }
        }
        if !self.is_coarse {
            list = self.pruner.prune_by_octants(centre, edge, 2, list);
        }
        let list = &self.pruner.stack[list];
        // Neighbours often have the same list.
        if self.lists[self.last_list.clone()] != *list {
            if self.lists.len() + list.len() > self.max_entries {
                return None;
            }
            let start = self.lists.len();
            self.lists.extend(list);
            self.last_list = start..self.lists.len();
        }
        Some(PackedCell::new(PackedCell::NEAR, self.last_list.start, self.last_list.len()))
    }

    fn split(&mut self, place: [u32; 3], level: usize, list: Range<usize>) -> Option<PackedCell> {
        let bits = SPLITS[level];
        let (first, count) = (self.cells.len(), 1 << (3 * bits));
        if first + count > self.max_cells.saturating_add(1) {
            return None;
        }
        self.cells.resize(first + count, PackedCell::new(PackedCell::NEAR, 0, 0));
        let parent_length = list.len();
        self.split_octants(place, bits, level, list, parent_length, first)?;
        Some(PackedCell::new(PackedCell::SPLIT, first, 0))
    }

    /// Builds the children in a cube of them, so that eight neighbours are pruned from the list of their octant.
    fn split_octants(
        &mut self,
        place: [u32; 3],
        bits: u32,
        level: usize,
        list: Range<usize>,
        parent_length: usize,
        first: usize,
    ) -> Option<()> {
        let top = self.pruner.stack.len();
        let octants = octants_of(place);
        let pruned = self.pruner.prune_each(&octants, Self::shift(level + 1) + bits - 1, list);
        for (place, pruned) in octants.into_iter().zip(&pruned) {
            if bits > 1 {
                self.split_octants(place, bits - 1, level, pruned.list.clone(), parent_length, first)?;
                continue;
            }
            let inner = self.pruner.stack.len();
            let cell = self.build_cell(place, level + 1, pruned, parent_length)?;
            self.pruner.stack.truncate(inner);
            let bits = SPLITS[level];
            let [x, y, z] = place.map(|v| v & ((1 << bits) - 1));
            self.cells[first + ((((z << bits) + y) << bits) + x) as usize] = cell;
        }
        self.pruner.stack.truncate(top);
        Some(())
    }

    /// Makes a cell far from every surface, if its nearest surface point can be found.
    fn far_cell(&self, centre: [f32; 3], edge: f32, list: Range<usize>, distance: f32) -> Option<FarCell> {
        let Pruner { field, shape_grid, stack, .. } = &self.pruner;
        let [x, y, z] = centre;
        let list = stack[list].iter().copied();
        let p = Vec3::new(x, y, z);
        let code = |index| field.tree_surface(&shape_grid.code[index as usize], p, &|_| 0.5f32, FarField::Exact);
        let found = shape_grid.fold_surface(field, list, p, &|_| 0.5f32, &CodeValues::new(code));
        let gradient = found.field.gradient;
        let steepness = gradient.length();
        if !(steepness > 1e-3 && steepness.is_finite()) {
            return None;
        }
        let along = found.field.value / steepness;
        // Estimates are exact within the margin as well.
        if along.abs() < self.pruner.change(edge) + shape_grid.margin {
            return None;
        }
        let surface = [gradient.x, gradient.y, gradient.z];
        let surface = std::array::from_fn(|k| centre[k] - surface[k] * along / steepness);
        Some(FarCell { surface, distance: distance.copysign(along), leaf: found.leaf as u32 })
    }
}

/// Least of the distances at each point.
fn least_of(distances: &[f32x8]) -> f32x8 {
    distances.iter().fold(f32x8::splat(f32::INFINITY), |least, &distance| least.fast_min(distance))
}

/// Lanes whose bit is set.
fn lanes_of(bits: u8) -> f32x8 {
    const LANE: [f32; 8] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];
    // The bits below each lane's are less than it.
    let low = std::array::from_fn(|k| (u32::from(bits) & (1 << k)) as f32);
    f32x8::from(low).simd_ge(f32x8::from(LANE))
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
fn remaining_slope(blend: Blend, behind: f32x8) -> f32x8 {
    let half = f32x8::splat(0.5);
    let is_ahead = behind.simd_lt(f32x8::ZERO);
    let behind = behind.fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
    let slope = match blend.profile {
        BlendProfile::Soft => half * (f32x8::ONE - behind),
        BlendProfile::Round => half * (f32x8::ONE - behind / (f32x8::splat(2.0) - behind * behind).sqrt()),
        BlendProfile::Chamfer => half,
        BlendProfile::Stairs => f32x8::ONE,
    };
    Real::select(Mask8(is_ahead), f32x8::ONE, slope)
}
