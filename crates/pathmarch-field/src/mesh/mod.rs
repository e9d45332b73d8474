//! Triangle meshes of solids.
//!
//! **Idea.** Dual contouring (Ju et al. 2002) on a grid of cells: each cell that the surface passes through gets a vertex, and
//! each grid edge that the surface crosses joins the vertices of the four cells around it. The vertex is where the tangent
//! planes at the cell's crossings meet best, so that edges and corners stay sharp. A cell that the surface passes through in
//! several patches gets a vertex for each (`patches.rs`; Nielson 2004), so that the mesh is closed and manifold for every solid:
//! every edge is in two triangles, every vertex has one fan around it.
//!
//! Cells are found by subdivision: a block contains no surface if the distance at its centre exceeds the Lipschitz constant times
//! half its diagonal. Blocks of 4³ cells (`block.rs`) are then contoured independently, on all cores and eight points at a
//! time. If the surface leaves these blocks because bounds or a constant are wrong, the blocks beyond are added, so that the
//! mesh is closed all the same.
//!
//! **Source.** Ju et al. 2002 for the method, Nielson 2004 and Wenger 2013 for the patches, Garland and Heckbert 1997 and
//! Lindstrom 2000 for the vertex. **Differences.** Crossings are found on the field by false position, and normals are its exact
//! gradients. A vertex stays in its cell unless it is on the surface of the field a little beyond. All cells have one
//! size: larger ones on flat faces would lose the borders of materials there. A quad is split along the diagonal whose middle
//! is nearer to the surface. Triangles may intersect in cells with detail below their size.
//!
//! The mesher of `fidget` 0.5 does not fit: its cell counts are powers of two, it merges flat cells across borders of
//! materials, reports no progress, and evaluates tapes, which our generic functions do not have.
//!
//! **Cost.** Time and memory grow with the area of the surface over that of a cell: about 2 µs and,
//! at the peak, 200 bytes a cell.

mod block;
mod distance_grid;
mod patches;
mod qef;
mod solid;

pub use distance_grid::DistanceGrid;

use crate::bounds::Aabb;
use crate::graph::Field;
use block::{Block, Cell, FARTHEST, SIDE, Vertex, key, unpacked};
use glam::{DVec3, Vec3};
use patches::is_crossed;
use pathmarch_mesh::{PrintReport, TriangleMesh};
use rayon::prelude::*;
use solid::{Solid, in_lanes};
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Largest number of cells that the surface may pass through: about three gigabytes of memory.
pub const MAX_CELLS: usize = 16_000_000;

/// Resolution of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fineness {
    /// Cells along the longest side of the solid's bounds.
    Resolution(u32),
    /// Edge of a cell, metres.
    Cell(f32),
}

/// A closed surface of triangles, anticlockwise as seen from outside.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Position of each vertex, metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of each vertex, away from the solid; at an edge the mean of its sides.
    pub normals: Vec<[f32; 3]>,
    /// Colour of each vertex; a mix where materials blend.
    pub colours: Vec<[f32; 3]>,
    /// Triangles, as indices of three vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// Error that prevents a mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The solid, or the box that clips it, is unbounded.
    #[error("the solid is infinite; clip it with a box")]
    Endless,
    /// The solid is empty at this resolution.
    #[error(
        "there is no inside to make a mesh of at this fineness; sheets such as rect and disc have none, \
         and a thin solid needs smaller cells"
    )]
    Empty,
    /// There would be more than [`MAX_CELLS`] cells.
    #[error("more than {} million cells would be needed; take larger cells, or export objects one by one", MAX_CELLS / 1_000_000)]
    TooManyCells,
    /// There would be more values than a [`DistanceGrid`] may have.
    #[error("more than {} million points would be needed; take larger cells, or a smaller box", distance_grid::MAX_VALUES / 1_000_000)]
    TooManyPoints,
    /// The cell size is too small for the coordinates, or not positive and finite.
    #[error("cells of {0} m are too small for coordinates of 32 bits here, or no length at all; take larger cells")]
    CellSize(f32),
    /// The progress callback stopped it.
    #[error("stopped")]
    Stopped,
}

/// Callback for the progress, 0 to 1, that may stop the work; called from any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) -> ControlFlow<()> + Sync);

/// Callback for a vertex's colour: leaf, position in metres, unit normal.
pub type Paint<'a> = &'a (dyn Fn(usize, [f32; 3], [f32; 3]) -> [f32; 3] + Sync);

impl Mesh {
    /// Meshes the surface of the union of a field's objects, clipped to the box `cut` if given, with colours from `paint`. The
    /// result does not depend on the number of cores.
    ///
    /// # Errors
    /// [`MeshError`].
    pub fn new(
        field: &Field,
        fineness: Fineness,
        cut: Option<Aabb>,
        paint: Paint,
        progress: Progress,
    ) -> Result<Self, MeshError> {
        let solid = grid(field, fineness, cut)?;
        let (mut cells, vertices) = contour_blocks(&solid, subdivide(&solid)?, paint, progress)?;
        if cells.is_empty() {
            return Err(MeshError::Empty);
        }
        cells.par_sort_unstable_by_key(|cell| cell.key);
        let triangles = triangles(&solid, &cells, &vertices);
        let _ = progress(1.0);
        Ok(Self {
            positions: vertices.iter().map(|vertex| vertex.position).collect(),
            normals: vertices.iter().map(|vertex| vertex.normal).collect(),
            colours: vertices.iter().map(|vertex| vertex.colour).collect(),
            triangles,
        })
    }

    /// Corners of a triangle, metres.
    pub fn corners(&self, triangle: [u32; 3]) -> [[f32; 3]; 3] {
        triangle.map(|vertex| self.positions[vertex as usize])
    }
    /// Volume, m³ (by the divergence theorem).
    pub fn volume(&self) -> f64 {
        self.sum(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
    }
    /// Surface area, m².
    pub fn area(&self) -> f64 {
        self.sum(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
    }

    /// Checks the mesh for printing, with +y up; `None` of an empty one. See [`PrintReport`].
    pub fn print_report(&self) -> Option<PrintReport> {
        let positions = self.positions.iter().copied().map(Vec3::from).collect();
        let mesh = TriangleMesh { positions, triangles: self.triangles.clone(), ..TriangleMesh::default() };
        PrintReport::new(&mesh, Vec3::Y).ok()
    }

    fn sum(&self, of: impl Fn([DVec3; 3]) -> f64) -> f64 {
        let corners = |&triangle| self.corners(triangle).map(|corner| Vec3::from(corner).as_dvec3());
        self.triangles.iter().map(|triangle| of(corners(triangle))).sum()
    }
}

/// Chooses the grid: the cells of the bounds and one more on every side. It is offset from the bounds by fractions of a cell, so
/// that faces do not fall on grid corners.
fn grid<'a>(field: &'a Field, fineness: Fineness, cut: Option<Aabb>) -> Result<Solid<'a>, MeshError> {
    let bounds = cut.map_or(field.bounds(), |cut| field.bounds().intersection(cut));
    let sides: [f64; 3] = std::array::from_fn(|k| f64::from(bounds.max[k]) - f64::from(bounds.min[k]));
    if sides.iter().any(|side| *side <= 0.0) {
        return Err(MeshError::Empty);
    }
    if !bounds.is_finite() || cut.is_some_and(|cut| !cut.is_finite()) {
        return Err(MeshError::Endless);
    }
    let cell = match fineness {
        Fineness::Resolution(cells) => sides.into_iter().fold(0.0, f64::max) / f64::from(cells),
        Fineness::Cell(cell) => f64::from(cell),
    };
    let farthest = bounds.min.iter().chain(&bounds.max).fold(0.0_f32, |far, v| far.max(v.abs()));
    let least = 32.0 * f64::from(f32::EPSILON * farthest);
    let counts = sides.map(|side| side / cell + 3.0);
    let fits = counts.iter().all(|count| *count < f64::from(FARTHEST));
    if !(cell >= least && cell > 0.0 && cell.is_finite() && fits) {
        return Err(MeshError::CellSize(cell as f32));
    }
    let before = [1.382, 1.437, 1.271];
    let origin = std::array::from_fn(|k| f64::from(bounds.min[k]) - cell * before[k]);
    field.build_shape_grids();
    Ok(Solid { field, cut, origin, cell, counts: counts.map(|count| count.ceil() as i32) })
}

/// First cells of all blocks that may contain surface.
fn subdivide(solid: &Solid) -> Result<Vec<[i32; 3]>, MeshError> {
    let longest = solid.counts.into_iter().max().unwrap_or(0);
    let mut side = SIDE;
    while side < longest {
        side *= 2;
    }
    let mut blocks = vec![[0; 3]];
    while side > SIDE {
        side /= 2;
        // A little more than half a diagonal, for rounding.
        let reach = solid.lipschitz() * (0.8661 * f64::from(side) * solid.cell) as f32;
        let halves = |low: &[i32; 3]| {
            let low = *low;
            let children: [_; 8] = std::array::from_fn(|n| [0, 1, 2].map(|k| low[k] + (n as i32 >> k & 1) * side));
            let centres = children.map(|at| solid.place(at.map(|v| f64::from(v) + 0.5 * f64::from(side))));
            let mut distances = [0.0; 8];
            in_lanes(&centres, |_, p| distances = solid.distance(p).to_array());
            let may_have_surface = move |n: &usize| {
                // NaN is kept.
                let is_far = distances[*n].abs() > reach;
                !is_far && (0..3).all(|k| children[*n][k] < solid.counts[k])
            };
            (0..8).filter(may_have_surface).map(move |n| children[n])
        };
        blocks = blocks.par_iter().flat_map_iter(halves).collect();
        // A block that the surface passes through has about sixteen cells with surface in them.
        if blocks.len() > MAX_CELLS / 4 {
            return Err(MeshError::TooManyCells);
        }
    }
    Ok(blocks)
}

/// Contours the blocks, and those into which the surface continues.
fn contour_blocks(
    solid: &Solid,
    blocks: Vec<[i32; 3]>,
    paint: Paint,
    progress: Progress,
) -> Result<(Vec<Cell>, Vec<Vertex>), MeshError> {
    let (mut cells, mut vertices) = (Vec::new(), Vec::new());
    let mut known: HashSet<u64> = blocks.iter().map(|&low| key(low)).collect();
    let (done, found) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let mut ahead = blocks;
    while !ahead.is_empty() {
        let work = |&low: &[i32; 3]| {
            let block = Block::new(solid, low, paint);
            if found.fetch_add(block.cells.len(), Ordering::Relaxed) + block.cells.len() > MAX_CELLS {
                return Err(MeshError::TooManyCells);
            }
            let number = done.fetch_add(1, Ordering::Relaxed);
            let share = 0.9 * number as f32 / known.len() as f32;
            if number.is_multiple_of(64) && progress(share).is_break() {
                return Err(MeshError::Stopped);
            }
            Ok(block)
        };
        let worked: Vec<Block> = ahead.par_iter().map(work).collect::<Result<_, _>>()?;
        let mut beyond = Vec::new();
        for (low, block) in ahead.iter().zip(worked) {
            let first = vertices.len() as u32;
            cells.extend(block.cells.into_iter().map(|cell| cell.moved(first)));
            vertices.extend(block.vertices);
            for n in (0..27).filter(|n| block.continues >> n & 1 == 1) {
                let next = [n % 3, n / 3 % 3, n / 9];
                let next = [0, 1, 2].map(|k| low[k] + (next[k] - 1) * SIDE);
                if next.iter().any(|v| v.abs() > FARTHEST) {
                    return Err(MeshError::Endless);
                }
                if known.insert(key(next)) {
                    beyond.push(next);
                }
            }
        }
        ahead = beyond;
    }
    Ok((cells, vertices))
}

/// Two triangles for each edge of the grid that the surface crosses.
fn triangles(solid: &Solid, cells: &[Cell], vertices: &[Vertex]) -> Vec<[u32; 3]> {
    let cell_at = |at: [i32; 3]| {
        let key = key(at);
        cells.binary_search_by_key(&key, |cell| cell.key).ok().map(|index| &cells[index])
    };
    let quads_of = |cell: &Cell| {
        let (cell, at) = (*cell, unpacked(cell.key));
        (0..3).filter_map(move |axis| {
            // The edge at the cell's first corner; the other cells around it are before it along the two next axes.
            if !is_crossed(cell.mask(), 4 * axis) {
                return None;
            }
            let mut quad = [0; 4];
            for (slot, (b, c)) in quad.iter_mut().zip([(1, 1), (0, 1), (0, 0), (1, 0)]) {
                let mut other = at;
                other[(axis + 1) % 3] -= b;
                other[(axis + 2) % 3] -= c;
                *slot = cell_at(other)?.vertex(4 * axis + (b + 2 * c) as usize);
            }
            if cell.mask() & 1 == 0 {
                quad.reverse();
            }
            Some(quad)
        })
    };
    let quads: Vec<[u32; 4]> = cells.par_iter().flat_map_iter(quads_of).collect();
    quads.par_chunks(4).flat_map_iter(|quads| split_quads(solid, quads, vertices)).collect()
}

/// Splits up to four quads along the diagonal that is nearer to the surface, unless that flips a triangle.
fn split_quads(solid: &Solid, quads: &[[u32; 4]], vertices: &[Vertex]) -> Vec<[u32; 3]> {
    let at = |vertex: u32| Vec3::from(vertices[vertex as usize].position);
    let mut middles = [[0.0; 3]; 8];
    for (n, &[a, b, c, d]) in quads.iter().enumerate() {
        middles[2 * n] = at(a).midpoint(at(c)).into();
        middles[2 * n + 1] = at(b).midpoint(at(d)).into();
    }
    let mut off = [0.0; 8];
    in_lanes(&middles, |_, p| off = solid.distance(p).abs().to_array());
    let halves = quads.iter().enumerate().flat_map(|(n, &[a, b, c, d])| {
        let along = [[[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]];
        let out: Vec3 = [a, b, c, d].iter().map(|&v| Vec3::from(vertices[v as usize].normal)).sum();
        let turned = along.map(|halves| {
            let is_turned = |[a, b, c]: &[u32; 3]| (at(*b) - at(*a)).cross(at(*c) - at(*a)).dot(out) < 0.0;
            halves.iter().filter(|half| is_turned(half)).count()
        });
        let second = turned[1] < turned[0] || turned[1] == turned[0] && off[2 * n + 1] < off[2 * n];
        along[usize::from(second)]
    });
    halves.collect()
}
