//! Tangents of vertices, for normal maps.
//!
//! **Idea.** MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"), which glTF 2.0 prescribes for files without
//! tangents (section 3.7.2.1), by the crate `bevy_mikktspace`. It gives a tangent to each corner of a triangle; vertices whose
//! corners differ are split. **Cost.** That of MikkTSpace, about a second for a million triangles.

use crate::triangle_mesh::TriangleMesh;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// Corners whose tangents have a smaller cosine between them do not share a vertex.
const SAME_TANGENT: f32 = 0.9999;

impl TriangleMesh {
    /// Computes the tangents of triangles that lack them. `uv_set` returns the texture coordinates along which the tangents of
    /// a material run; `None` for materials that need none.
    pub fn add_tangents(&mut self, uv_set: impl Fn(u32) -> Option<usize>) {
        let lacks_tangents = |triangle: &[u32; 3]| {
            let is_zero = |&vertex: &u32| self.tangents.get(vertex as usize).is_none_or(|t| t.truncate() == Vec3::ZERO);
            triangle.iter().any(is_zero)
        };
        let with_set = |(index, triangle): (usize, &[u32; 3])| {
            let set = uv_set(self.material(index)).filter(|&set| !self.uvs[set].is_empty())?;
            lacks_tangents(triangle).then_some((index, set))
        };
        let triangles: Vec<(usize, usize)> = self.triangles.iter().enumerate().filter_map(with_set).collect();
        if triangles.is_empty() {
            return;
        }
        let mut corners =
            Corners { mesh: self, triangles: &triangles, tangents: vec![[Vec4::ZERO; 3]; triangles.len()] };
        if generate_tangents(&mut corners).is_err() {
            return;
        }
        let tangents = corners.tangents;
        self.tangents.resize(self.positions.len(), Vec4::ZERO);
        let mut copies = HashMap::new();
        for (&(triangle, _), corners) in triangles.iter().zip(&tangents) {
            for (corner, &tangent) in corners.iter().enumerate() {
                let vertex = self.triangles[triangle][corner];
                self.triangles[triangle][corner] = self.with_tangent(vertex, tangent, &mut copies);
            }
        }
    }

    /// The vertex, or a copy of it, with this tangent. `copies` has the next copy of each vertex.
    fn with_tangent(&mut self, vertex: u32, tangent: Vec4, copies: &mut HashMap<u32, u32>) -> u32 {
        let mut at = vertex;
        loop {
            let own = self.tangents[at as usize];
            if own.truncate() == Vec3::ZERO {
                self.tangents[at as usize] = tangent;
                return at;
            }
            if own.w == tangent.w && own.truncate().dot(tangent.truncate()) > SAME_TANGENT {
                return at;
            }
            let Some(&next) = copies.get(&at) else { break };
            at = next;
        }
        let copy = self.positions.len() as u32;
        copies.insert(at, copy);
        self.duplicate_vertex(vertex as usize);
        self.tangents[copy as usize] = tangent;
        copy
    }

    /// Appends a copy of a vertex.
    fn duplicate_vertex(&mut self, vertex: usize) {
        fn duplicate<T: Copy>(attribute: &mut Vec<T>, vertex: usize) {
            if let Some(&value) = attribute.get(vertex) {
                attribute.push(value);
            }
        }
        duplicate(&mut self.positions, vertex);
        duplicate(&mut self.normals, vertex);
        duplicate(&mut self.tangents, vertex);
        duplicate(&mut self.colours, vertex);
        self.uvs.iter_mut().for_each(|uvs| duplicate(uvs, vertex));
    }
}

/// Triangles whose tangents are computed, each with its set of texture coordinates.
struct Corners<'a> {
    mesh: &'a TriangleMesh,
    triangles: &'a [(usize, usize)],
    /// Results for the corners of each triangle.
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[self.triangles[face].0][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }
    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].into()
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let normal = self.mesh.normals.get(self.vertex(face, corner)).copied().unwrap_or_default();
        if normal != Vec3::ZERO {
            return normal.into();
        }
        let [a, b, c] = self.mesh.corners(self.triangles[face].0);
        (b - a).cross(c - a).normalize_or(Vec3::Y).into()
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.mesh.uvs[self.triangles[face].1][self.vertex(face, corner)].into()
    }
    fn set_tangent(&mut self, tangent_space: Option<TangentSpace>, face: usize, corner: usize) {
        // glTF has v downwards, against MikkTSpace's upwards, so that the sign of the bitangent differs.
        let [x, y, z, sign] = tangent_space.unwrap_or_default().tangent_encoded();
        self.tangents[face][corner] = Vec3::new(x, y, z).normalize_or(Vec3::X).extend(-sign);
    }
}
