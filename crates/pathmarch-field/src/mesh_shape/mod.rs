//! Mesh shapes: triangles, the distance field of a mesh, or triangles that are lit by it.
//!
//! **Idea.** A mesh has two forms. As *triangles*, rays intersect it exactly, and it is an object of its own. As a *field*, it is a
//! distance grid that every operator and modifier takes like any other shape. Triangles have a coarse grid, too, which is built
//! when a preview or a check for what is inside needs a distance.
//!
//! The surface of a mesh is shared by all shapes of one file; `words.rs` encodes it for the GPU once.
//!
//! **Limits.** The distance of triangles is that of the coarse grid of [`COARSE_RESOLUTION`] voxels. **Cost.** A field costs one trilinear
//! interpolation.

mod geometry;
mod interpolation;
mod opacity;
mod surface;
pub(crate) mod words;

pub use geometry::MeshGeometry;
pub(crate) use geometry::vector;
pub use interpolation::{MeshAttributes, MeshPoint};
pub use opacity::{AlphaTest, AlphaTexture, MaterialOpacity, MeshOpacity};
pub use surface::{COARSE_RESOLUTION, MeshError, MeshSurface};

use crate::bounds::Aabb;
use crate::info::Info;
use crate::number::{Dual, Vec3};
use crate::parameter::Param;
use crate::shapes::{EvalShape, Shape};
use pathmarch_mesh::DistanceGrid;
use std::sync::Arc;
use wide::f32x8;

/// WGSL of the distance of a grid.
pub(crate) const GRID_WGSL: &str = include_str!("grid.wgsl");
/// WGSL of vertex attributes, materials and closest triangles.
pub(crate) const ATTRIBUTES_WGSL: &str = include_str!("attributes.wgsl");
/// WGSL of ray intersection and of surfaces.
pub(crate) const TRIANGLES_WGSL: &str = include_str!("triangles.wgsl");
/// WGSL of opacity.
pub(crate) const OPACITY_WGSL: &str = include_str!("opacity.wgsl");
/// WGSL in place of that of opacity, for opaque meshes.
pub(crate) const OPAQUE_WGSL: &str = include_str!("opaque.wgsl");

/// Shape of a mesh file.
pub struct MeshShape {
    info: Info,
    geometry: MeshGeometry,
}

impl MeshShape {
    /// Shape of triangles.
    pub fn triangles(surface: Arc<MeshSurface>, tags: Vec<u32>) -> Self {
        let info = Info::new("mesh", "Triangles of a mesh file.", "Woop et al. 2013; Ylitie et al. 2017");
        Self { info: info.inexact(), geometry: MeshGeometry::new(surface, None, tags) }
    }

    /// Triangles with this opacity of the mesh's materials; `None` if no ray passes through them.
    pub fn with_opacity(self, opacity: Option<Arc<MeshOpacity>>) -> Self {
        Self { geometry: self.geometry.with_opacity(opacity), ..self }
    }

    /// Shape of triangles for camera rays, and of their distance field for all others; a whole object only.
    pub fn lit_by_field(surface: Arc<MeshSurface>, grid: Arc<DistanceGrid>, tags: Vec<u32>) -> Self {
        let Self { info, geometry } = Self::field(surface, grid, tags);
        Self { info, geometry: geometry.lit_by_field() }
    }

    /// Shape of the distance field of a mesh.
    pub fn field(surface: Arc<MeshSurface>, grid: Arc<DistanceGrid>, tags: Vec<u32>) -> Self {
        let info = Info::new("mesh", "Distance field of a mesh file.", "Frisken et al. 2000; Barill et al. 2018");
        Self { info: info.inexact(), geometry: MeshGeometry::new(surface, Some(grid), tags) }
    }
}

impl EvalShape<f32> for MeshShape {
    fn distance(&self, p: Vec3<f32>, _params: &[f32]) -> f32 {
        self.geometry.grid().distance(vector(p))
    }
    fn gradient(&self, p: Vec3<Dual<f32>>, _params: &[f32]) -> Dual<f32> {
        let (value, gradient) = self.geometry.grid().distance_and_gradient(vector(p.values()));
        Dual { value, gradient: p.pulled_back(Vec3::new(gradient.x, gradient.y, gradient.z)) }
    }
}

impl EvalShape<f32x8> for MeshShape {
    fn distance(&self, p: Vec3<f32x8>, _params: &[f32]) -> f32x8 {
        let [x, y, z] = [p.x, p.y, p.z].map(f32x8::to_array);
        let grid = self.geometry.grid();
        f32x8::from(std::array::from_fn(|lane| grid.distance(glam::Vec3::new(x[lane], y[lane], z[lane]))))
    }
    fn gradient(&self, p: Vec3<Dual<f32x8>>, _params: &[f32]) -> Dual<f32x8> {
        let point = p.values();
        let [x, y, z] = [point.x, point.y, point.z].map(f32x8::to_array);
        let grid = self.geometry.grid();
        let sample = |lane: usize| grid.distance_and_gradient(glam::Vec3::new(x[lane], y[lane], z[lane]));
        let samples: [(f32, glam::Vec3); 8] = std::array::from_fn(sample);
        let component = |axis: usize| f32x8::from(samples.map(|(_, gradient)| gradient[axis]));
        let gradient = Vec3::new(component(0), component(1), component(2));
        Dual { value: f32x8::from(samples.map(|(value, _)| value)), gradient: p.pulled_back(gradient) }
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
        vec![0.0]
    }
    fn bounds(&self, _params: &[f32]) -> Aabb {
        let bounds = self.geometry.surface().mesh_bounds();
        // The field of a coarse grid may reach beyond the mesh by the rounding of creases.
        let margin = self.geometry.field().map_or(0.0, DistanceGrid::voxel);
        Aabb { min: (bounds.min - margin).into(), max: (bounds.max + margin).into() }
    }
    fn lipschitz(&self, _params: &[f32]) -> f32 {
        self.geometry.field().map_or(1.0, DistanceGrid::lipschitz)
    }
    fn is_analytic(&self) -> bool {
        self.geometry.is_triangles()
    }
    fn mesh(&self) -> Option<&MeshGeometry> {
        Some(&self.geometry)
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
