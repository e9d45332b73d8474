//! A mesh as a shape uses it: its surface, its form and the tags of its materials.

use super::opacity::MeshOpacity;
use super::surface::MeshSurface;
use crate::number::Vec3;
use pathmarch_mesh::DistanceGrid;
use pathmarch_mesh::bvh::{Hit, Ray};
use std::sync::Arc;

/// Surface of a mesh, and its form.
pub struct MeshGeometry {
    surface: Arc<MeshSurface>,
    /// Its distance field; `None` for triangles.
    field: Option<Arc<DistanceGrid>>,
    /// True if camera rays intersect the triangles, and other rays the field.
    is_lit_by_field: bool,
    /// Tag of each material of the mesh; one for all if there is only one.
    tags: Vec<u32>,
    /// Opacity of its materials; `None` if no ray passes through its triangles.
    opacity: Option<Arc<MeshOpacity>>,
}

impl MeshGeometry {
    pub(super) fn new(surface: Arc<MeshSurface>, field: Option<Arc<DistanceGrid>>, tags: Vec<u32>) -> Self {
        Self { surface, field, is_lit_by_field: false, tags, opacity: None }
    }

    pub(super) fn lit_by_field(self) -> Self {
        Self { is_lit_by_field: true, ..self }
    }

    pub(super) fn with_opacity(self, opacity: Option<Arc<MeshOpacity>>) -> Self {
        Self { opacity, ..self }
    }

    /// Opacity of its materials; `None` if no ray passes through its triangles.
    pub fn opacity(&self) -> Option<&Arc<MeshOpacity>> {
        self.opacity.as_ref()
    }

    /// First hit of a ray in local coordinates: its parameter and the triangle.
    pub(crate) fn hit(&self, ray: &Ray) -> Option<(f32, u32)> {
        let bvh = self.surface.bvh();
        let hit = match &self.opacity {
            None => bvh.intersect(ray),
            Some(opacity) => {
                let material = |hit: &Hit| self.surface.mesh().material(hit.triangle as usize) as usize;
                bvh.intersect_where(ray, |hit| opacity.is_present(&self.surface, material(hit), ray, hit))
            }
        };
        hit.map(|hit| (hit.t, hit.triangle))
    }

    /// Triangles of the mesh.
    pub fn surface(&self) -> &Arc<MeshSurface> {
        &self.surface
    }

    /// Tag of each material.
    pub fn tags(&self) -> &[u32] {
        &self.tags
    }

    /// Reports whether all rays intersect the triangles.
    pub fn is_triangles(&self) -> bool {
        self.field.is_none()
    }

    /// Reports whether camera rays intersect the triangles, and other rays the field.
    pub fn is_lit_by_field(&self) -> bool {
        self.is_lit_by_field
    }

    /// The field of the mesh; `None` for triangles.
    pub(super) fn field(&self) -> Option<&DistanceGrid> {
        self.field.as_deref()
    }

    /// Edge of a voxel of the [grid](Self::grid), in the mesh's coordinates.
    pub fn voxel(&self) -> f32 {
        let coarse = || self.surface.mesh_bounds().size().max_element() / super::COARSE_RESOLUTION as f32;
        self.field.as_ref().map_or_else(coarse, |field| field.voxel())
    }

    /// The distance grid: that of the field, or the coarse one of triangles.
    pub fn grid(&self) -> &Arc<DistanceGrid> {
        self.field.as_ref().unwrap_or_else(|| self.surface.coarse_grid())
    }

    /// Number of a triangle's material among the [tags](Self::tags).
    pub fn slot(&self, triangle: u32) -> u32 {
        let material = self.surface.mesh().material(triangle as usize);
        material.min(self.tags.len().saturating_sub(1) as u32)
    }
}

/// Vector of another crate.
pub(crate) fn vector(p: Vec3<f32>) -> glam::Vec3 {
    glam::Vec3::new(p.x, p.y, p.z)
}
