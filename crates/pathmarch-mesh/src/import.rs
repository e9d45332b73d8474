//! Contents of a mesh file.

use crate::material::{Camera, Image, Light, Material};
use crate::triangle_mesh::TriangleMesh;
use glam::Affine3A;
use std::fmt;

/// Contents of a mesh file: meshes, and nodes that place them.
#[derive(Clone, Debug, Default)]
pub struct Imported {
    /// Meshes in their own space. A mesh may be placed by several nodes.
    pub meshes: Vec<TriangleMesh>,
    /// Nodes of the scene that is shown, parents before children.
    pub nodes: Vec<Node>,
    /// Materials; never empty if there are meshes.
    pub materials: Vec<Material>,
    /// Images that textures name by index.
    pub images: Vec<Image>,
    /// Lights that nodes name by index.
    pub lights: Vec<Light>,
    /// Cameras that nodes name by index.
    pub cameras: Vec<Camera>,
    /// What is shown otherwise than the file means.
    pub warnings: Vec<Warning>,
}

/// Node of the hierarchy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// Name in the file; may be empty.
    pub name: String,
    /// Index of the parent in [`Imported::nodes`].
    pub parent: Option<usize>,
    /// Transform from the node's space to the world. It may mirror or flatten.
    pub world_from_node: Affine3A,
    /// Index of its mesh.
    pub mesh: Option<usize>,
    /// Index of its light.
    pub light: Option<usize>,
    /// Index of its camera.
    pub camera: Option<usize>,
}

/// Part of a file that is not shown as it means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Place in the file, such as a line or an accessor: that of the first occurrence.
    pub place: String,
    /// Feature or mistake, and what is shown instead.
    pub message: String,
    /// Number of occurrences.
    pub count: usize,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)?;
        if self.count > 1 { write!(f, " ({} times)", self.count) } else { Ok(()) }
    }
}

/// More triangles than a merged mesh may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the nodes place {triangles} triangles, more than {limit}; keep the meshes apart as instances")]
pub struct TooManyTriangles {
    /// Triangles of all nodes.
    pub triangles: usize,
    /// The limit.
    pub limit: usize,
}

impl Imported {
    /// Imported file of one mesh at the origin.
    pub(crate) fn of_mesh(mesh: TriangleMesh, materials: Vec<Material>) -> Self {
        let node = Node { mesh: Some(0), ..Node::default() };
        Self { meshes: vec![mesh], nodes: vec![node], materials, ..Self::default() }
    }

    /// One mesh in world space of all nodes' meshes. Triangles that a transform made unusable are left out.
    ///
    /// # Errors
    /// [`TooManyTriangles`], or as many vertices, exceed `limit` (at most 2³⁰ is used).
    pub fn merged(&self, limit: usize) -> Result<TriangleMesh, TooManyTriangles> {
        let placed = || self.nodes.iter().filter_map(|node| Some((node, self.meshes.get(node.mesh?)?)));
        let limit = limit.min(crate::bvh::MAX_TRIANGLES);
        let triangles = placed().fold(0_usize, |sum, (_, mesh)| sum.saturating_add(mesh.triangles.len()));
        let vertices = placed().fold(0_usize, |sum, (_, mesh)| sum.saturating_add(mesh.positions.len()));
        if triangles > limit || vertices / 3 > limit {
            return Err(TooManyTriangles { triangles: triangles.max(vertices / 3), limit });
        }
        let mut merged = TriangleMesh::default();
        for (node, mesh) in placed() {
            let mut mesh = mesh.clone();
            mesh.transform(node.world_from_node);
            merged.append(&mesh);
        }
        merged.drop_unusable();
        Ok(merged)
    }
}
