//! Distance fields of meshes on a sparse grid.
//!
//! **Idea.** A coarse grid has the exact signed distance every four voxels; blocks of 8³ voxels near the surface have bricks
//! of 9³ samples of 16 bits (Frisken et al. 2000 store detail where the surface is; two levels suffice here). Values in between
//! are trilinear. Bricks go over to the coarse grid where they end, so that the field is continuous; every block has a bound
//! of its slope, which makes steps safe.
//!
//! Holes of the mesh are closed (`solid.rs`), and the side of a point is decided by the generalised winding number (Jacobson et al.
//! 2013; Barill et al. 2018). The gradient is that of the interpolated distance.
//!
//! | File | Contents |
//! |---|---|
//! | `layout.rs` | places of samples, interpolation |
//! | `solid.rs` | closing holes |
//! | `build.rs`, `unsigned.rs`, `signs.rs` | building: distances, and their signs |
//! | `bytes.rs` | bytes for a cache |
//!
//! **Limits.** Creases are rounded within a voxel. Walls thinner than two voxels may vanish; [`crate::report`] finds them. The
//! thickness of a sheet without inside is zero, so that its field has no negative values.
//!
//! **Cost.** A million triangles at a resolution of 512 take 15 CPU seconds, most of them for distances in bricks, and 34 MB.

mod build;
mod bytes;
mod layout;
mod signs;
mod solid;
mod unsigned;

pub use bytes::CacheError;

use crate::bounds::Bounds;
use crate::bvh::BuildError;
use crate::triangle_mesh::TriangleMesh;
use glam::{UVec3, Vec3};
use layout::{BLOCK, COARSE, Corners, Layout, SAMPLES, SIDE, index, interpolate};
use std::ops::ControlFlow;

/// Numbers of voxels along the longest edge of a grid that can be chosen.
pub const RESOLUTIONS: std::ops::RangeInclusive<u32> = 16..=1024;
/// Most bricks of a grid: about 600 megabytes.
pub const MAX_BRICKS: usize = 400_000;
/// Largest distance in a brick, voxels.
const SAMPLE_RANGE: f32 = 24.0;
/// Index of a block without brick.
const NO_BRICK: u32 = u32::MAX;

/// Callback for the progress, 0 to 1, that may stop the work; called from any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) -> ControlFlow<()> + Sync);

/// Failure of building a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] BuildError),
    /// The mesh has no triangles, or all are at one point.
    #[error("the mesh has no size; a field needs a surface")]
    Empty,
    /// The resolution is out of range.
    #[error("a resolution of {0} is not from 16 to 1024")]
    Resolution(u32),
    /// More bricks than [`MAX_BRICKS`] would be needed.
    #[error("the surface fills more than {MAX_BRICKS} blocks of 8\u{b3} voxels; lower the resolution")]
    TooManyBricks,
    /// The progress callback stopped it.
    #[error("stopped")]
    Stopped,
}

/// Signed distance field of a mesh, negative inside.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceGrid {
    layout: Layout,
    /// Distance at each coarse sample.
    coarse: Vec<f32>,
    /// Index of each block's brick, or [`NO_BRICK`].
    bricks_of_blocks: Vec<u32>,
    /// Samples of all bricks, in units of [`SAMPLE_RANGE`] voxels over the largest integer.
    bricks: Vec<i16>,
    /// Slope bound of each block and those around it.
    slopes: Vec<f32>,
    /// Greatest slope, at least one.
    lipschitz: f32,
}

/// Arrays of a [`DistanceGrid`]. In all of them x varies fastest.
#[derive(Clone, Copy, Debug)]
pub struct GridArrays<'g> {
    /// Least corner of the box.
    pub origin: Vec3,
    /// Edge of a voxel.
    pub voxel: f32,
    /// Number of blocks of [`GridArrays::BLOCK`]³ voxels along each axis.
    pub blocks: UVec3,
    /// Distance that a brick's sample of one stands for.
    pub unit: f32,
    /// Distance at each coarse sample, every [`GridArrays::COARSE`] voxels, both borders included.
    pub coarse: &'g [f32],
    /// Index of each block's brick, or [`GridArrays::NO_BRICK`].
    pub bricks_of_blocks: &'g [u32],
    /// Samples of all bricks, [`GridArrays::SIDE`]³ each.
    pub bricks: &'g [i16],
}

impl GridArrays<'_> {
    /// Voxels along the edge of a block.
    pub const BLOCK: u32 = BLOCK;
    /// Voxels between coarse samples.
    pub const COARSE: u32 = COARSE;
    /// Samples along the edge of a brick.
    pub const SIDE: u32 = SIDE;
    /// Index of a block without brick.
    pub const NO_BRICK: u32 = NO_BRICK;
}

impl DistanceGrid {
    /// Builds the field of a mesh, on all cores of the current `rayon` pool. The result does not depend on their number.
    ///
    /// `resolution` is the number of voxels along the longest edge, with a margin around the mesh.
    ///
    /// # Errors
    /// [`GridError`].
    pub fn build(mesh: &TriangleMesh, resolution: u32, progress: Progress) -> Result<Self, GridError> {
        if !RESOLUTIONS.contains(&resolution) {
            return Err(GridError::Resolution(resolution));
        }
        crate::bvh::check(mesh)?;
        let size = mesh.bounds().size().max_element();
        if size / resolution as f32 <= f32::MIN_POSITIVE || mesh.triangles.is_empty() {
            return Err(GridError::Empty);
        }
        build::build(mesh, resolution, progress)
    }

    /// Signed distance of a point; continuous, with slopes of at most [`DistanceGrid::lipschitz`]. Beyond the bounds it is at most
    /// the distance to the surface.
    pub fn distance(&self, p: Vec3) -> f32 {
        self.sample(p).0
    }

    /// Signed distance of a point, and its gradient.
    pub fn distance_and_gradient(&self, p: Vec3) -> (f32, Vec3) {
        self.sample(p)
    }

    /// Radius of a ball around a point that contains no point where [`DistanceGrid::distance`] is zero.
    pub fn safe_radius(&self, p: Vec3) -> f32 {
        let nearest = self.bounds().clamped(p);
        let outside = p.distance(nearest);
        let distance = self.distance(p).abs();
        if outside > 0.0 {
            return outside.max(distance / self.lipschitz());
        }
        // Within a block's edge of here, slopes are at most those of the block and its neighbours.
        let block = self.place(nearest).0;
        let near = (distance / self.slopes[self.layout.block_index(block)]).min(BLOCK as f32 * self.layout.voxel);
        near.max(distance / self.lipschitz())
    }

    /// Lipschitz constant of the field.
    pub fn lipschitz(&self) -> f32 {
        self.lipschitz
    }

    /// Box of the grid, which contains the mesh.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.layout.origin, max: self.layout.position(self.layout.blocks * BLOCK) }
    }

    /// Edge of a voxel.
    pub fn voxel(&self) -> f32 {
        self.layout.voxel
    }

    /// Bytes in use.
    pub fn size_in_bytes(&self) -> usize {
        4 * (self.coarse.len() + self.bricks_of_blocks.len() + self.slopes.len()) + 2 * self.bricks.len()
    }

    /// The arrays of the grid, for evaluation elsewhere.
    pub fn arrays(&self) -> GridArrays<'_> {
        let Layout { origin, voxel, blocks } = self.layout;
        let unit = SAMPLE_RANGE * voxel / f32::from(i16::MAX);
        GridArrays {
            origin,
            voxel,
            blocks,
            unit,
            coarse: &self.coarse,
            bricks_of_blocks: &self.bricks_of_blocks,
            bricks: &self.bricks,
        }
    }

    /// Distance and gradient of a point.
    fn sample(&self, p: Vec3) -> (f32, Vec3) {
        let nearest = self.bounds().clamped(p);
        let (distance, gradient) = self.sample_within(nearest);
        let beyond = p - nearest;
        if beyond == Vec3::ZERO {
            return (distance, gradient);
        }
        // The surface is on the other side of the plane through the nearest point, at a right angle to the way there.
        let inner = distance.max(0.0);
        let outer = beyond.length().hypot(inner);
        // Along axes on which the point is beyond the border, the nearest point does not move.
        let along = Vec3::select(beyond.cmpeq(Vec3::ZERO), gradient, Vec3::ZERO);
        (outer, (beyond + inner * along) / outer)
    }

    /// Block of a point within the bounds, and its place in it in voxels.
    fn place(&self, p: Vec3) -> (UVec3, Vec3) {
        let voxels = ((p - self.layout.origin) / self.layout.voxel).max(Vec3::ZERO);
        let block = (voxels / BLOCK as f32).as_uvec3().min(self.layout.blocks - 1);
        (block, (voxels - (block * BLOCK).as_vec3()).min(Vec3::splat(BLOCK as f32)))
    }

    fn sample_within(&self, p: Vec3) -> (f32, Vec3) {
        let (block, place) = self.place(p);
        let brick = self.bricks_of_blocks[self.layout.block_index(block)];
        let spacing = if brick == NO_BRICK { COARSE } else { 1 };
        let scaled = place / spacing as f32;
        let cell = scaled.as_uvec3().min(UVec3::splat(BLOCK / spacing - 1));
        let corners = if brick == NO_BRICK {
            self.coarse_corners(block * (BLOCK / COARSE) + cell)
        } else {
            self.brick_corners(brick, cell)
        };
        let (distance, gradient) = interpolate(&corners, scaled - cell.as_vec3());
        (distance, gradient / (spacing as f32 * self.layout.voxel))
    }

    /// Corners of a cell of the coarse grid.
    fn coarse_corners(&self, cell: UVec3) -> Corners {
        std::array::from_fn(|k| self.coarse[self.layout.coarse_index(cell + corner(k))])
    }

    /// Corners of a cell of a brick.
    fn brick_corners(&self, brick: u32, cell: UVec3) -> Corners {
        let samples = &self.bricks[SAMPLES * brick as usize..SAMPLES * (brick as usize + 1)];
        let unit = SAMPLE_RANGE * self.layout.voxel / f32::from(i16::MAX);
        let first = index(cell, UVec3::splat(SIDE));
        std::array::from_fn(|k| unit * f32::from(samples[first + index(corner(k), UVec3::splat(SIDE))]))
    }

    /// Interpolated coarse samples at a voxel's corner.
    fn coarse_at_voxel(&self, voxel: UVec3) -> f32 {
        let cell = (voxel / COARSE).min(self.layout.coarse_size() - 2);
        let place = (voxel - cell * COARSE).as_vec3() / COARSE as f32;
        interpolate(&self.coarse_corners(cell), place).0
    }
}

/// Greatest of the slopes of blocks, and one.
fn greatest(slopes: &[f32]) -> f32 {
    slopes.iter().copied().fold(1.0, f32::max)
}

/// Offset of a cell's corner.
fn corner(k: usize) -> UVec3 {
    UVec3::from_array([0, 1, 2].map(|axis| (k >> axis & 1) as u32))
}
