//! Emitting triangles of a mesh, and their choice.
//!
//! An alias table chooses a triangle in proportion to its area, and two more numbers a point on it (Turk 1990, "Generating Random
//! Points in Triangles"), so that points are distributed uniformly over the surface.

use super::light_tree::NormalCone;
use crate::sampling::alias_table;
use glam::Vec3;
use pathmarch_field::{Field, MeshAttributes, MeshSurface};
use std::sync::Arc;

/// Triangles of one material of a placed mesh.
#[derive(Clone, Debug)]
pub(crate) struct MeshLight {
    surface: Arc<MeshSurface>,
    /// Emitting triangles of the mesh.
    pub(crate) triangles: Vec<u32>,
    /// Alias table over them.
    pub(crate) cells: Vec<alias_table::Cell>,
    /// Rays pass through the backs of the triangles.
    pub(crate) is_single_sided: bool,
    /// Area of all, square metres.
    pub(crate) area: f32,
    /// From the mesh's coordinates to the world.
    at: Vec3,
    axes: [Vec3; 3],
}

/// Point on an emitting triangle.
pub(crate) struct PointOnMesh {
    pub(crate) p: Vec3,
    /// Unit normal on the front of the triangle.
    pub(crate) normal: Vec3,
    pub(crate) attributes: MeshAttributes,
}

impl MeshLight {
    /// Light of a leaf, if it is triangles that no ray passes from their front.
    pub(crate) fn new(field: &Field, leaf: usize) -> Option<Self> {
        use pathmarch_field::mesh_shape::AlphaTest;
        let source = &field.leaves()[leaf];
        let mesh = source.shape.mesh().filter(|_| source.is_triangles())?;
        let opacity = mesh.opacity().and_then(|opacity| opacity.materials.get(source.slot as usize));
        if opacity.is_some_and(|opacity| opacity.test != AlphaTest::Opaque) {
            return None;
        }
        let surface = Arc::clone(mesh.surface());
        let count = surface.mesh().triangles.len() as u32;
        let triangles: Vec<u32> = (0..count).filter(|&triangle| mesh.slot(triangle) == source.slot).collect();
        let scale = source.pose.scale;
        let double_area = |&triangle: &u32| {
            let [a, b, c] = surface.mesh().corners(triangle as usize).map(Vec3::as_dvec3);
            (b - a).cross(c - a).length()
        };
        let areas: Vec<f64> = triangles.iter().map(double_area).collect();
        let area = (0.5 * areas.iter().sum::<f64>()) as f32 * scale * scale;
        (area > 0.0).then(|| Self {
            cells: alias_table::table(&areas),
            surface,
            triangles,
            is_single_sided: opacity.is_some_and(|opacity| opacity.is_single_sided),
            area,
            at: Vec3::from(source.pose.at),
            axes: source.pose.axes.map(|axis| Vec3::from(axis) * scale),
        })
    }

    /// Cone of the normals of all emitting sides, in world space.
    pub(super) fn normals(&self) -> NormalCone {
        if !self.is_single_sided {
            return NormalCone::ALL;
        }
        let [x, y, z] = self.axes;
        let normal = |&triangle: &u32| {
            let [a, b, c] = self.surface.mesh().corners(triangle as usize);
            let (b, c) = (b - a, c - a);
            let scale = b.abs().max(c.abs()).max_element().max(f32::MIN_POSITIVE);
            let v = (b / scale).cross(c / scale);
            (x * v.x + y * v.y + z * v.z).try_normalize()
        };
        let cones = self.triangles.iter().filter_map(normal).map(NormalCone::of);
        cones.reduce(NormalCone::union).unwrap_or(NormalCone::ALL)
    }

    /// Point for two uniform numbers.
    pub(crate) fn point(&self, [u, v]: [f32; 2]) -> PointOnMesh {
        let (index, u) = alias_table::sample(&self.cells, u);
        let triangle = self.triangles[index];
        let root = u.sqrt();
        let weights = [root * (1.0 - v), root * v];
        let [a, b, c] = self.surface.mesh().corners(triangle as usize);
        let (b, c) = (b - a, c - a);
        let [x, y, z] = self.axes;
        let world = |v: Vec3| x * v.x + y * v.y + z * v.z;
        let scale = b.abs().max(c.abs()).max_element().max(f32::MIN_POSITIVE);
        PointOnMesh {
            p: self.at + world(a + b * weights[0] + c * weights[1]),
            normal: world((b / scale).cross(c / scale)).normalize_or(Vec3::Y),
            attributes: self.surface.attributes(triangle, weights),
        }
    }

    /// Number of each emitting triangle in kernels.
    pub(crate) fn kernel_triangles(&self) -> impl Iterator<Item = u32> {
        let numbers = self.surface.kernel_triangles();
        self.triangles.iter().map(move |&triangle| numbers[triangle as usize])
    }
}
