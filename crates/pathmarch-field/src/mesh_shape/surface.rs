//! Surface of a mesh: its triangles, with a hierarchy for the CPU and one for the GPU.

use pathmarch_mesh::bvh::{BuildError, CompressedBvh};
use pathmarch_mesh::grid::GridError;
use pathmarch_mesh::{Bounds, Bvh, DistanceGrid, TriangleMesh};
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

/// Voxels along the longest edge of the grid of triangles.
pub const COARSE_RESOLUTION: u32 = 64;
/// Most levels of a hierarchy that kernels traverse.
pub(crate) const MAX_DEPTH: usize = 48;

/// Mesh that cannot be a shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No hierarchy can be built of it.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// No distance grid can be built of it.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Its hierarchy is too deep for kernels.
    #[error("the triangles are nested {0} levels deep, more than {MAX_DEPTH}; leave out the smallest of them")]
    TooDeep(usize),
}

/// Triangles of a mesh file, shared by all its uses.
pub struct MeshSurface {
    mesh: TriangleMesh,
    bvh: Bvh,
    bounds: Bounds,
    compressed: CompressedBvh,
    /// Built on first use.
    coarse_grid: OnceLock<Arc<DistanceGrid>>,
}

impl std::fmt::Debug for MeshSurface {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("MeshSurface").field("triangles", &self.mesh.triangles.len()).finish_non_exhaustive()
    }
}

impl MeshSurface {
    /// Builds the hierarchies of a mesh.
    ///
    /// # Errors
    /// [`MeshError`] for a mesh without size, or that is nested too deeply.
    pub fn new(mesh: TriangleMesh) -> Result<Self, MeshError> {
        let bvh = Bvh::build(&mesh)?;
        let size = bvh.bounds().size().max_element();
        if mesh.triangles.is_empty() || size / COARSE_RESOLUTION as f32 <= f32::MIN_POSITIVE {
            return Err(MeshError::Grid(GridError::Empty));
        }
        let compressed = CompressedBvh::build(&mesh)?;
        if compressed.depth() > MAX_DEPTH {
            return Err(MeshError::TooDeep(compressed.depth()));
        }
        let bounds = bvh.bounds();
        Ok(Self { mesh, bvh, bounds, compressed, coarse_grid: OnceLock::new() })
    }

    /// Triangles and attributes.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Hierarchy for the CPU.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Number of each triangle in kernels, which have them in the order of the hierarchy.
    pub fn kernel_triangles(&self) -> Vec<u32> {
        let mut numbers = vec![0; self.mesh.triangles.len()];
        (0..).zip(&self.compressed.triangles).for_each(|(number, &triangle)| numbers[triangle as usize] = number);
        numbers
    }

    /// Hierarchy for the GPU.
    pub(crate) fn compressed(&self) -> &CompressedBvh {
        &self.compressed
    }

    pub(crate) fn coarse_grid(&self) -> &Arc<DistanceGrid> {
        self.coarse_grid.get_or_init(|| {
            let grid = DistanceGrid::build(&self.mesh, COARSE_RESOLUTION, &|_| ControlFlow::Continue(()));
            Arc::new(grid.expect("the mesh has a size, and few bricks at this resolution"))
        })
    }

    pub(crate) fn mesh_bounds(&self) -> Bounds {
        self.bounds
    }

    /// Triangle that is closest to a point in local coordinates.
    pub(crate) fn closest_triangle(&self, p: glam::Vec3) -> u32 {
        self.bvh.closest_point(&self.mesh, p, f32::INFINITY).map_or(0, |closest| closest.triangle)
    }
}
