//! Mesh shapes: triangles, or the distance field of a mesh.
//!
//! **Idea.** A mesh has two forms. As *triangles*, rays intersect it exactly, and it is an object of its own. As a *field*, it is a
//! distance grid that every operator and modifier takes like any other shape. Triangles have a coarse grid, too: previews
//! and the checks for what is inside need a distance.
//!
//! The surface of a mesh is shared by all shapes of one file; `words.rs` encodes it for the GPU once.
//!
//! **Limits.** The distance of triangles is that of the coarse grid of [`COARSE_RESOLUTION`] voxels. **Cost.** A field costs one trilinear
//! interpolation.

mod interpolation;
mod surface;
pub(crate) mod words;

pub use interpolation::MeshPoint;
pub use surface::{MeshError, MeshSurface};

use crate::bounds::Aabb;
use crate::graph::Batch;
use crate::info::Info;
use crate::number::{Dual, Real, Vec3};
use crate::parameter::Param;
use crate::shapes::{EvalShape, Shape};
use pathmarch_mesh::DistanceGrid;
use std::sync::Arc;
use wide::f32x8;

/// Voxels along the longest edge of the grid of triangles.
pub const COARSE_RESOLUTION: u32 = 64;

/// WGSL of the distance of a grid.
pub(crate) const GRID_WGSL: &str = include_str!("grid.wgsl");
/// WGSL of vertex attributes, materials and closest triangles.
pub(crate) const ATTRIBUTES_WGSL: &str = include_str!("attributes.wgsl");
/// WGSL of ray intersection and of surfaces.
pub(crate) const TRIANGLES_WGSL: &str = include_str!("triangles.wgsl");

/// Shape of a mesh file.
pub struct MeshShape {
    info: Info,
    surface: Arc<MeshSurface>,
    /// Its distance field; `None` for triangles.
    field: Option<Arc<DistanceGrid>>,
    /// Tag of each material of the mesh; one for all if there is only one.
    tags: Vec<u32>,
}

impl MeshShape {
    /// Shape of triangles.
    pub fn triangles(surface: Arc<MeshSurface>, tags: Vec<u32>) -> Self {
        let info = Info::new("mesh", "Triangles of a mesh file.", "Woop et al. 2013; Ylitie et al. 2017");
        Self { info: info.inexact(), surface, field: None, tags }
    }

    /// Shape of the distance field of a mesh.
    pub fn field(surface: Arc<MeshSurface>, grid: Arc<DistanceGrid>, tags: Vec<u32>) -> Self {
        let info = Info::new("mesh", "Distance field of a mesh file.", "Frisken et al. 2000; Barill et al. 2018");
        Self { info: info.inexact(), surface, field: Some(grid), tags }
    }

    /// Triangles of the mesh.
    pub fn surface(&self) -> &Arc<MeshSurface> {
        &self.surface
    }

    /// Tag of each material.
    pub fn tags(&self) -> &[u32] {
        &self.tags
    }

    /// Reports whether rays intersect the triangles.
    pub fn is_triangles(&self) -> bool {
        self.field.is_none()
    }

    /// The distance grid.
    pub fn grid(&self) -> &Arc<DistanceGrid> {
        self.field.as_ref().unwrap_or_else(|| self.surface.coarse_grid())
    }

    /// Number of a triangle's material among the [tags](Self::tags).
    pub(crate) fn slot(&self, triangle: u32) -> u32 {
        let material = self.surface.mesh().material(triangle as usize);
        material.min(self.tags.len().saturating_sub(1) as u32)
    }
}

/// Vector of another crate.
pub(crate) fn vector(p: Vec3<f32>) -> glam::Vec3 {
    glam::Vec3::new(p.x, p.y, p.z)
}

impl EvalShape<f32> for MeshShape {
    fn distance(&self, p: Vec3<f32>, _params: &[f32]) -> f32 {
        self.grid().distance(vector(p))
    }
    fn gradient(&self, p: Vec3<Dual<f32>>, _params: &[f32]) -> Dual<f32> {
        let (value, gradient) = self.grid().distance_and_gradient(vector(p.values()));
        Dual { value, gradient: p.pulled_back(Vec3::new(gradient.x, gradient.y, gradient.z)) }
    }
}

impl EvalShape<f32x8> for MeshShape {
    fn distance(&self, p: Vec3<f32x8>, _params: &[f32]) -> f32x8 {
        let [x, y, z] = [p.x, p.y, p.z].map(f32x8::to_array);
        let grid = self.grid();
        f32x8::from(std::array::from_fn(|lane| grid.distance(glam::Vec3::new(x[lane], y[lane], z[lane]))))
    }
    fn gradient(&self, p: Vec3<Dual<f32x8>>, _params: &[f32]) -> Dual<f32x8> {
        let point = p.values();
        let [x, y, z] = [point.x, point.y, point.z].map(f32x8::to_array);
        let grid = self.grid();
        let sample = |lane: usize| grid.distance_and_gradient(glam::Vec3::new(x[lane], y[lane], z[lane]));
        let samples: [(f32, glam::Vec3); 8] = std::array::from_fn(sample);
        let component = |axis: usize| f32x8::from_lanes(samples.map(|(_, gradient)| gradient[axis]));
        let gradient = Vec3::new(component(0), component(1), component(2));
        Dual { value: f32x8::from_lanes(samples.map(|(value, _)| value)), gradient: p.pulled_back(gradient) }
    }
}

impl Shape for MeshShape {
    fn info(&self) -> &Info {
        &self.info
    }
    fn params(&self) -> &[Param] {
        &[]
    }
    fn coefficients(&self, _params: &[f32]) -> Vec<f32> {
        // The offset of its grid, which the program sets.
        vec![f32::zero()]
    }
    fn bounds(&self, _params: &[f32]) -> Aabb {
        let bounds = self.surface.mesh_bounds();
        // The field of a coarse grid may reach beyond the mesh by the rounding of creases.
        let margin = self.field.as_ref().map_or(0.0, |grid| grid.voxel());
        Aabb { min: (bounds.min - margin).into(), max: (bounds.max + margin).into() }
    }
    fn lipschitz(&self, _params: &[f32]) -> f32 {
        self.field.as_ref().map_or(1.0, |grid| grid.lipschitz())
    }
    fn is_analytic(&self) -> bool {
        self.is_triangles()
    }
    fn mesh(&self) -> Option<&MeshShape> {
        Some(self)
    }
    fn wgsl_distance(&self) -> String {
        "/// Signed distance of a mesh with this grid.\nfn mesh_distance(p: vec3f, grid: f32) -> f32 {\n    return \
         mesh_gradient(p, grid).w;\n}\n"
            .to_owned()
    }
    fn wgsl_gradient(&self) -> String {
        GRID_WGSL.to_owned()
    }
    fn wgsl_name(&self) -> String {
        "mesh".to_owned()
    }
}
