//! Places of a grid's samples.

use glam::{UVec3, Vec3};

/// Voxels along the edge of a block.
pub(super) const BLOCK: u32 = 8;
/// Voxels between coarse samples.
pub(super) const COARSE: u32 = 4;
/// Samples along the edge of a brick, both ends included.
pub(super) const SIDE: u32 = BLOCK + 1;
/// Samples of a brick.
pub(super) const SAMPLES: usize = (SIDE * SIDE * SIDE) as usize;
/// Voxels between the mesh and the border of the grid, at least.
pub(super) const MARGIN: u32 = 4;

/// A box of blocks of 8³ voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// Least corner.
    pub origin: Vec3,
    /// Edge of a voxel.
    pub voxel: f32,
    /// Number of blocks along each axis.
    pub blocks: UVec3,
}

impl Layout {
    /// Layout with a number of voxels along the longest edge.
    pub fn new(bounds: crate::Bounds, resolution: u32) -> Self {
        let voxel = bounds.size().max_element() / (resolution - 2 * MARGIN) as f32;
        let blocks = ((bounds.size() / voxel + 2.0 * MARGIN as f32) / BLOCK as f32).ceil().as_uvec3().max(UVec3::ONE);
        let origin = bounds.centre() - 0.5 * voxel * (blocks * BLOCK).as_vec3();
        Self { origin, voxel, blocks }
    }

    pub fn block_count(&self) -> usize {
        self.blocks.as_usizevec3().element_product()
    }

    /// Coarse samples along each axis.
    pub fn coarse_size(&self) -> UVec3 {
        self.blocks * (BLOCK / COARSE) + 1
    }

    pub fn coarse_count(&self) -> usize {
        self.coarse_size().as_usizevec3().element_product()
    }

    pub fn block_index(&self, block: UVec3) -> usize {
        index(block, self.blocks)
    }

    pub fn block(&self, index: usize) -> UVec3 {
        from_index(index, self.blocks)
    }

    pub fn coarse_index(&self, sample: UVec3) -> usize {
        index(sample, self.coarse_size())
    }

    pub fn coarse_sample(&self, index: usize) -> UVec3 {
        from_index(index, self.coarse_size())
    }

    /// Position of a voxel's corner.
    pub fn position(&self, voxel: UVec3) -> Vec3 {
        self.origin + self.voxel * voxel.as_vec3()
    }
}

/// Index in an array whose x varies fastest.
pub(super) fn index(at: UVec3, size: UVec3) -> usize {
    let (at, size) = (at.as_usizevec3(), size.as_usizevec3());
    at.x + size.x * (at.y + size.y * at.z)
}

fn from_index(index: usize, size: UVec3) -> UVec3 {
    let size = size.as_usizevec3();
    let at = [index % size.x, index / size.x % size.y, index / size.x / size.y];
    UVec3::from_array(at.map(|v| v as u32))
}

/// Values at the corners of a cell: bit k of the number is set on the greater side of axis k.
pub(super) type Corners = [f32; 8];

/// Trilinear interpolation in a cell, and its derivative by the place in it.
#[inline]
pub(super) fn interpolate(corners: &Corners, place: Vec3) -> (f32, Vec3) {
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let x = [0, 2, 4, 6].map(|k| mix(corners[k], corners[k + 1], place.x));
    let dx = [0, 2, 4, 6].map(|k| corners[k + 1] - corners[k]);
    let y = [mix(x[0], x[1], place.y), mix(x[2], x[3], place.y)];
    let gradient = Vec3::new(
        mix(mix(dx[0], dx[1], place.y), mix(dx[2], dx[3], place.y), place.z),
        mix(x[1] - x[0], x[3] - x[2], place.z),
        y[1] - y[0],
    );
    (mix(y[0], y[1], place.z), gradient)
}

/// Greatest length that the gradient in a cell may have, by its edges.
pub(super) fn slope(corners: &Corners) -> f32 {
    let along = |axis: usize| {
        let edges = (0..8).filter(|k| k >> axis & 1 == 0);
        edges.map(|k| (corners[k | 1 << axis] - corners[k]).abs()).fold(0.0, f32::max)
    };
    Vec3::new(along(0), along(1), along(2)).length()
}
