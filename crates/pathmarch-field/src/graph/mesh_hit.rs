//! Hits of triangle meshes on the CPU.
//!
//! **Idea.** Two levels: a hierarchy over the placed meshes, and that of each mesh's triangles, in its own coordinates; copies of a
//! mesh share it. Rays are transformed, so that their parameter stays in world metres.
//! **Cost.** That of `pathmarch_mesh::Bvh`, and a box for each mesh.

use super::bvh::Bvh;
use super::{EvalStrategy, Field, RayKind, Tree};
use crate::mesh_shape::words::{MeshWords, TopNode};
use crate::mesh_shape::{MeshAttributes, MeshGeometry, vector};
use crate::number::Vec3;
use pathmarch_mesh::bvh::Ray;
use std::sync::Arc;

/// Hit of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Distance from the origin, metres.
    pub t: f32,
    /// Leaf of the triangle's material.
    pub leaf: u32,
    /// Index of the triangle in the mesh.
    pub triangle: u32,
}

/// Geometry at a point of a mesh, in world space.
#[derive(Clone, Copy, Debug)]
pub struct MeshInteraction {
    /// Signed distance to the plane of the triangle, metres.
    pub distance: f32,
    /// Unit geometric normal on the front of the triangle.
    pub normal: glam::Vec3,
    /// Unit shading normal on the front of the triangle.
    pub shading_normal: glam::Vec3,
    /// Attributes for textures.
    pub attributes: MeshAttributes,
    /// Distance at which other rays start off, metres: above zero on triangles that are lit by their field.
    pub clearance: f32,
}

/// Box test of a ray: the slabs of Kay and Kajiya (1986), with a margin that keeps flat boxes.
fn is_passed(bounds: &crate::Aabb, origin: glam::Vec3, inverse: glam::Vec3, t_max: f32) -> bool {
    let (a, b) = ((glam::Vec3::from(bounds.min) - origin) * inverse, (glam::Vec3::from(bounds.max) - origin) * inverse);
    let enters = a.min(b).max_element().max(0.0);
    let leaves = a.max(b).min_element().min(t_max);
    enters < leaves + leaves.abs() * 1e-6 + 1e-30
}

impl Field {
    /// Reports whether an object is a mesh of triangles.
    pub(super) fn is_triangles(&self, object: &Tree) -> bool {
        matches!(object, Tree::Leaf(leaf) if !self.sphere_traces_all && self.leaves[*leaf as usize].is_triangles())
    }

    /// Reports whether an object is a mesh of triangles that is lit by its field.
    pub(crate) fn is_lit_by_field(&self, object: &Tree) -> bool {
        matches!(object, Tree::Leaf(leaf) if !self.sphere_traces_all && self.leaves[*leaf as usize].is_lit_by_field())
    }

    /// Leaf of an object that is a single analytic shape other than a mesh.
    pub(crate) fn convex_object(&self, object: &Tree) -> Option<u32> {
        self.direct(object).filter(|leaf| !self.leaves[*leaf as usize].is_triangles())
    }

    /// Builds the hierarchy over all meshes of triangles.
    pub(super) fn gather_mesh_instances(&mut self) {
        let objects = self.objects.iter().zip(&self.strategies).zip(&self.object_bounds);
        let instances = objects.filter_map(|((object, strategy), bounds)| match (object, strategy) {
            (Tree::Leaf(leaf), EvalStrategy::Triangles | EvalStrategy::LitByField) => Some((*leaf, *bounds)),
            _ => None,
        });
        self.mesh_instances = Bvh::new(instances.collect());
    }

    /// Encoded meshes, with the grids of all or only of fields.
    pub(crate) fn mesh_words(&self, has_all_grids: bool) -> Arc<MeshWords> {
        let words = &self.mesh_words[usize::from(has_all_grids)];
        let nodes = self.mesh_instances.nodes.iter();
        let nodes = nodes.map(|node| TopNode { bounds: node.bounds, skip: node.skip, leaf: node.leaf });
        let modifier = |leaf| self.enclosing_modifier(leaf);
        let encode = || Arc::new(MeshWords::new(&self.leaves, modifier, nodes, has_all_grids));
        Arc::clone(words.get_or_init(encode))
    }

    /// Reports whether some mesh of triangles is lit by its field.
    pub fn has_meshes_lit_by_field(&self) -> bool {
        self.strategies.contains(&EvalStrategy::LitByField)
    }

    /// Reports whether any object is a mesh of triangles.
    pub fn has_triangles(&self) -> bool {
        !self.mesh_instances.nodes.is_empty()
    }

    /// Reports whether any shape is a mesh, as triangles or as a field.
    pub fn has_meshes(&self) -> bool {
        self.leaves.iter().any(|leaf| leaf.shape.mesh().is_some())
    }

    /// Reports whether rays pass through some triangles.
    pub(crate) fn has_opacity(&self) -> bool {
        self.leaves.iter().any(|leaf| leaf.shape.mesh().is_some_and(|mesh| mesh.opacity().is_some()))
    }

    /// Reports whether some mesh has shading normals.
    pub fn has_shading_normals(&self) -> bool {
        self.leaves.iter().any(|leaf| (leaf.is_triangles() || leaf.is_lit_by_field()) && leaf.mesh_has_normals())
    }

    /// First hit of a ray with the triangles of all meshes before `t_max` metres; `direction` is a unit vector.
    pub fn mesh_hit(&self, origin: glam::Vec3, direction: glam::Vec3, t_max: f32, kind: RayKind) -> Option<MeshHit> {
        let tiny = direction.abs().cmplt(glam::Vec3::splat(1e-12));
        let inverse = glam::Vec3::ONE / glam::Vec3::select(tiny, glam::Vec3::splat(1e-12), direction);
        let (mut index, mut nearest, mut t_max) = (0, None, t_max);
        while let Some(node) = self.mesh_instances.nodes.get(index) {
            if !is_passed(&node.bounds, origin, inverse, t_max) {
                index = node.skip as usize;
                continue;
            }
            let is_met = |leaf: &u32| kind == RayKind::Camera || !self.leaves[*leaf as usize].is_lit_by_field();
            let leaf = node.leaf.filter(is_met);
            if let Some(hit) = leaf.and_then(|leaf| self.instance_hit(leaf, origin, direction, t_max)) {
                t_max = hit.t;
                nearest = Some(hit);
            }
            index += 1;
        }
        nearest
    }

    fn instance_hit(&self, leaf: u32, origin: glam::Vec3, direction: glam::Vec3, t_max: f32) -> Option<MeshHit> {
        let instance = &self.leaves[leaf as usize];
        let mesh = instance.shape.mesh()?;
        let pose = &instance.pose;
        let local = vector(pose.local(Vec3::new(origin.x, origin.y, origin.z)));
        let turned = vector(pose.turned(Vec3::new(direction.x, direction.y, direction.z)));
        let ray = Ray { t_max, ..Ray::new(local, turned / pose.scale) };
        let (t, triangle) = mesh.hit(&ray)?;
        Some(MeshHit { t, leaf: leaf + mesh.slot(triangle), triangle })
    }

    /// Geometry at the world point `p` of a triangle of the mesh of this leaf.
    pub fn mesh_interaction(&self, leaf: u32, triangle: u32, p: glam::Vec3) -> Option<MeshInteraction> {
        let instance = self.leaves.get(leaf as usize)?;
        let point = instance.shape.mesh()?.surface().point(triangle, instance.local_point(p));
        let [x, y, z] = instance.pose.axes.map(glam::Vec3::from);
        let world = |v: glam::Vec3| x * v.x + y * v.y + z * v.z;
        Some(MeshInteraction {
            distance: point.plane_distance * instance.pose.scale,
            normal: world(point.normal),
            shading_normal: world(point.shading_normal),
            attributes: point.attributes,
            clearance: instance.clearance(),
        })
    }
}

/// Triangle of a mesh that is closest to a point of its field.
#[derive(Clone, Copy, Debug)]
pub struct NearestTriangle {
    /// Leaf of its material.
    pub leaf: u32,
    /// Attributes for textures at the point of the triangle that is closest.
    pub attributes: MeshAttributes,
}

impl Field {
    /// Triangle closest to the world point `p` on the field of a mesh.
    pub fn nearest_triangle(&self, leaf: usize, p: Vec3<f32>) -> Option<NearestTriangle> {
        let mesh = self.leaves.get(leaf)?.shape.mesh()?;
        let local = vector(self.coordinates(leaf, p)?.point);
        let triangle = mesh.surface().closest_triangle(local);
        let point = mesh.surface().point(triangle, local);
        let leaf = leaf as u32 - self.leaves[leaf].slot + mesh.slot(triangle);
        Some(NearestTriangle { leaf, attributes: point.attributes })
    }
}

impl super::Leaf {
    fn mesh_has_normals(&self) -> bool {
        self.shape.mesh().map(MeshGeometry::surface).is_some_and(|surface| !surface.mesh().normals.is_empty())
    }

    /// World point in local coordinates; only for leaves without modifiers around them.
    fn local_point(&self, p: glam::Vec3) -> glam::Vec3 {
        vector(self.pose.local(Vec3::new(p.x, p.y, p.z)))
    }
}
