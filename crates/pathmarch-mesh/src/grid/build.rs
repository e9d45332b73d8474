//! Building a distance grid.
//!
//! 1. Distances at the coarse samples, from a hierarchy of the closed mesh; their signs (`signs.rs`).
//! 2. A block gets a brick if the surface is within [`BAND`] voxels of it.
//! 3. Distances at the samples of each brick. Where a brick touches a block without one, they go over to the interpolated coarse
//!    samples, so that the field is continuous.
//! 4. Slopes of all blocks.

use super::layout::{BLOCK, COARSE, Corners, Layout, SAMPLES, SIDE, index, slope};
use super::signs::Groups;
use super::unsigned::{self, SampleBox};
use super::{DistanceGrid, GridError, MAX_BRICKS, NO_BRICK, Progress, SAMPLE_RANGE, greatest, solid};
use crate::bvh::binary::BinaryBvh;
use crate::bvh::{Bvh, LEAVES, Neighbourhood};
use crate::triangle_mesh::TriangleMesh;
use crate::winding::WindingTree;
use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Voxels around the surface that have bricks.
const BAND: f32 = 2.0;
/// Voxels around the surface in which distances stay exact, whatever is next to the brick.
const EXACT: f32 = 0.5;
/// Voxels before a block without brick over which its values are approached.
const BLEND: f32 = 2.0;
/// Coarse samples along z that are one piece of work.
const SLICE: u32 = 4;
/// Half edge of the smallest cell that decides about a brick, voxels.
const FINEST: f32 = 0.5;
/// Fractions of the work after the hierarchy and after the coarse samples.
const PROGRESS: [f32; 2] = [0.1, 0.3];

/// What the samples are computed with.
pub(super) struct Surface {
    pub bvh: Bvh,
    pub winding: WindingTree,
}

/// Builds a grid.
pub(super) fn build(mesh: &TriangleMesh, resolution: u32, progress: Progress) -> Result<DistanceGrid, GridError> {
    let layout = Layout::new(mesh.bounds(), resolution);
    let closed = solid::close(mesh);
    let tree = BinaryBvh::build(closed.triangles.len(), |triangle| closed.corners(triangle), LEAVES);
    let bvh = Bvh::of_binary(&tree, &closed);
    let surface = Surface { bvh, winding: WindingTree::of_binary(tree, &closed) };
    let advance = |start: usize, done: &AtomicUsize, all: usize| {
        let share = done.fetch_add(1, Ordering::Relaxed) as f32 / all as f32;
        let ends = [PROGRESS[0], PROGRESS[1], 1.0];
        let total = ends[start] + share * (ends[start + 1] - ends[start]);
        if progress(total).is_break() { Err(GridError::Stopped) } else { Ok(()) }
    };
    let slices = layout.coarse_size().z.div_ceil(SLICE) as usize;
    let done = AtomicUsize::new(0);
    let coarse = signed_coarse(&layout, &surface, &|| advance(0, &done, slices))?;
    let mut grid = DistanceGrid {
        layout,
        coarse,
        bricks_of_blocks: Vec::new(),
        bricks: Vec::new(),
        slopes: Vec::new(),
        lipschitz: 1.0,
    };
    let blocks = choose_bricks(&mut grid, &surface);
    if blocks.len() > MAX_BRICKS {
        return Err(GridError::TooManyBricks);
    }
    let done = AtomicUsize::new(0);
    let samples = |&block: &usize| {
        advance(1, &done, blocks.len())?;
        Ok(brick(&grid, block, &surface))
    };
    let bricks = blocks.par_iter().map(samples).collect::<Result<Vec<_>, GridError>>()?;
    grid.bricks = bricks.into_iter().flat_map(|brick| *brick).collect();
    grid.slopes = slopes(&grid);
    grid.lipschitz = greatest(&grid.slopes);
    let _ = progress(1.0);
    Ok(grid)
}

/// Signed distances at the coarse samples.
fn signed_coarse(
    layout: &Layout,
    surface: &Surface,
    advance: &(dyn Fn() -> Result<(), GridError> + Sync),
) -> Result<Vec<f32>, GridError> {
    let size = layout.coarse_size();
    let spacing = COARSE as f32 * layout.voxel;
    let mut distances = vec![0.0; layout.coarse_count()];
    let whole = Neighbourhood::new(&surface.bvh);
    let position = |sample: UVec3| layout.position(COARSE * sample);
    // A slice of a thickness is contiguous, and enough work for a core.
    let slice = size.x as usize * size.y as usize * SLICE as usize;
    distances.par_chunks_mut(slice).enumerate().try_for_each(|(slice, distances)| {
        advance()?;
        let first = UVec3::new(0, 0, SLICE * slice as u32);
        let samples = SampleBox { first, size: UVec3::new(size.x, size.y, SLICE.min(size.z - first.z)) };
        unsigned::distances(&whole, samples, &position, &mut None, &mut |sample, distance| {
            distances[index(sample - first, size)] = distance;
        });
        Ok::<_, GridError>(())
    })?;
    let position = |sample: usize| layout.position(COARSE * layout.coarse_sample(sample));
    let mut groups = Groups::new(&distances, size, spacing);
    groups.decide(|sample| surface.winding.encloses(position(sample)));
    groups.apply(&mut distances);
    Ok(distances)
}

/// Numbers the blocks that get bricks, and returns them in that order.
fn choose_bricks(grid: &mut DistanceGrid, surface: &Surface) -> Vec<usize> {
    let layout = grid.layout;
    let half = 0.5 * BLOCK as f32;
    // No point of a block is farther from a coarse sample than half the diagonal of its cell.
    let reach = layout.voxel * (BAND + 0.5 * COARSE as f32 * 3.0_f32.sqrt());
    let is_near = |block: &usize| {
        let first = layout.block(*block) * (BLOCK / COARSE);
        let offsets = (0..27).map(|k| UVec3::new(k % 3, k / 3 % 3, k / 9));
        let mut samples = offsets.map(|offset| grid.coarse[layout.coarse_index(first + offset)].abs());
        let centre = layout.position(layout.block(*block) * BLOCK) + Vec3::splat(half * layout.voxel);
        samples.any(|distance| distance <= reach) && has_surface(surface, centre, half, layout.voxel)
    };
    let blocks: Vec<usize> = (0..layout.block_count()).into_par_iter().filter(is_near).collect();
    grid.bricks_of_blocks = vec![NO_BRICK; layout.block_count()];
    for (brick, &block) in blocks.iter().enumerate() {
        grid.bricks_of_blocks[block] = brick as u32;
    }
    blocks
}

/// Reports surface within the band around a cube, given half its edge in voxels.
fn has_surface(surface: &Surface, centre: Vec3, half: f32, voxel: f32) -> bool {
    let reach = voxel * (BAND + half * 3.0_f32.sqrt());
    let Some(nearest) = surface.bvh.nearest(centre, reach * reach) else { return false };
    // The cube contains a ball.
    if half <= FINEST || nearest.squared_distance.sqrt() <= voxel * (BAND + half) {
        return true;
    }
    let quarter = 0.5 * half * voxel;
    let child = |k: u32| Vec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { quarter } else { -quarter }));
    (0..8).any(|k| has_surface(surface, centre + child(k), 0.5 * half, voxel))
}

/// Samples of the brick of a block.
fn brick(grid: &DistanceGrid, block: usize, surface: &Surface) -> Box<[i16; SAMPLES]> {
    let layout = grid.layout;
    let first = layout.block(block) * BLOCK;
    let size = UVec3::splat(SIDE);
    let mut distances = [0.0; SAMPLES];
    let whole = Neighbourhood::new(&surface.bvh);
    let position = |at: UVec3| layout.position(first + at);
    unsigned::distances(&whole, SampleBox { first: UVec3::ZERO, size }, &position, &mut None, &mut |at, distance| {
        distances[index(at, size)] = distance;
    });
    let mut groups = Groups::new(&distances, size, layout.voxel);
    groups.know(&known_signs(grid, block));
    groups.decide(|sample| surface.winding.encloses(layout.position(first + sample_of(sample))));
    groups.apply(&mut distances);
    let borders = Borders::new(grid, block);
    let mut samples = Box::new([0; SAMPLES]);
    for (sample, quantised) in samples.iter_mut().enumerate() {
        let distance = borders.blended(grid, first, sample_of(sample), distances[sample]);
        *quantised = grid.quantise(distance);
    }
    samples
}

/// Place of a sample in its brick.
fn sample_of(sample: usize) -> UVec3 {
    let sample = sample as u32;
    UVec3::new(sample % SIDE, sample / SIDE % SIDE, sample / (SIDE * SIDE))
}

/// Samples of a brick that are coarse samples, too, and whether they are inside.
fn known_signs(grid: &DistanceGrid, block: usize) -> [(usize, bool); 27] {
    let first = grid.layout.block(block) * (BLOCK / COARSE);
    std::array::from_fn(|k| {
        let offset = UVec3::new(k as u32 % 3, k as u32 / 3 % 3, k as u32 / 9);
        let distance = grid.coarse[grid.layout.coarse_index(first + offset)];
        (index(COARSE * offset, UVec3::splat(SIDE)), distance.is_sign_negative())
    })
}

/// Blocks without brick around a brick.
struct Borders {
    offsets: Vec<IVec3>,
}

impl Borders {
    fn new(grid: &DistanceGrid, block: usize) -> Self {
        let here = grid.layout.block(block).as_ivec3();
        let around = (0..27).map(|k| IVec3::new(k % 3, k / 3 % 3, k / 9) - 1);
        let is_coarse = |offset: &IVec3| {
            let other = here + offset;
            let is_there = other.cmpge(IVec3::ZERO).all() && other.cmplt(grid.layout.blocks.as_ivec3()).all();
            is_there && grid.bricks_of_blocks[grid.layout.block_index(other.as_uvec3())] == NO_BRICK
        };
        Self { offsets: around.filter(is_coarse).collect() }
    }

    /// Distance of a sample, blended with the coarse samples if it is close to a block without brick and off the surface.
    fn blended(&self, grid: &DistanceGrid, first: UVec3, at: UVec3, distance: f32) -> f32 {
        let gap = |offset: &IVec3| {
            let low = BLOCK as i32 * offset;
            let beyond = (low - at.as_ivec3()).max(at.as_ivec3() - (low + BLOCK as i32));
            beyond.max(IVec3::ZERO).max_element()
        };
        let Some(gap) = self.offsets.iter().map(gap).min().filter(|gap| (*gap as f32) < BLEND) else { return distance };
        let away = (distance.abs() / grid.layout.voxel - EXACT) / (BAND - EXACT);
        let weight = away.clamp(0.0, 1.0) * (1.0 - gap as f32 / BLEND);
        let coarse = grid.coarse_at_voxel(first + at);
        // The sign is that of the distance.
        let coarse = if distance < 0.0 { coarse.min(0.0) } else { coarse.max(0.0) };
        distance + weight * (coarse - distance)
    }
}

/// Slope bound of each block and those around it.
fn slopes(grid: &DistanceGrid) -> Vec<f32> {
    let layout = grid.layout;
    let own: Vec<f32> = (0..layout.block_count()).into_par_iter().map(|block| own_slope(grid, block)).collect();
    let around = |block: usize| {
        let here = layout.block(block);
        let (low, high) = (here.saturating_sub(UVec3::ONE), (here + 1).min(layout.blocks - 1));
        let mut largest = 0.0_f32;
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    largest = largest.max(own[layout.block_index(UVec3::new(x, y, z))]);
                }
            }
        }
        largest
    };
    (0..layout.block_count()).into_par_iter().map(around).collect()
}

/// Greatest slope in a block.
fn own_slope(grid: &DistanceGrid, block: usize) -> f32 {
    let brick = grid.bricks_of_blocks[block];
    let (cells, spacing) = if brick == NO_BRICK { (BLOCK / COARSE, COARSE) } else { (BLOCK, 1) };
    let first = grid.layout.block(block) * (BLOCK / COARSE);
    let corners = |cell: UVec3| -> Corners {
        if brick == NO_BRICK { grid.coarse_corners(first + cell) } else { grid.brick_corners(brick, cell) }
    };
    let cell = |k: u32| UVec3::new(k % cells, k / cells % cells, k / (cells * cells));
    let steepest = (0..cells.pow(3)).map(|k| slope(&corners(cell(k)))).fold(0.0, f32::max);
    steepest / (spacing as f32 * grid.layout.voxel)
}

impl DistanceGrid {
    /// Nearest representable sample of a brick.
    fn quantise(&self, distance: f32) -> i16 {
        let units = distance / (SAMPLE_RANGE * self.layout.voxel) * f32::from(i16::MAX);
        let rounded = units.round() as i16;
        // Rounding to zero would lose the inside.
        if rounded == 0 && distance < 0.0 { -1 } else { rounded }
    }
}
