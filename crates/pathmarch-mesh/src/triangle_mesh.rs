//! Triangles with shared vertices and their attributes.
//!
//! **Idea.** One array for each attribute, as on a GPU. An attribute that no vertex has is an empty array. Where only some
//! vertices have one (glTF primitives of one mesh may differ), the others get a neutral value: a zero normal or tangent means
//! *use the triangle's own*, a missing UV is the origin, a missing colour white.
//!
//! **Limits.** Coordinates are finite and at most [`MAX_COORDINATE`]: products of three fit into 32-bit floats, which
//! intersection and distances rely on. [`TriangleMesh::drop_unusable`] leaves out triangles that violate this.

use crate::bounds::Bounds;
use glam::{Affine3A, DVec3, Vec2, Vec3, Vec4};

/// Largest coordinate of a vertex.
pub const MAX_COORDINATE: f32 = 1e12;

/// Triangles with shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Position of each vertex.
    pub positions: Vec<Vec3>,
    /// Unit shading normal of each vertex, zero where the triangle's own is meant; empty if there are none.
    pub normals: Vec<Vec3>,
    /// Unit tangent of each vertex along increasing u, and the sign of the bitangent (glTF 2.0, section 3.7.2.1); zero where
    /// unknown, empty if there are none.
    pub tangents: Vec<Vec4>,
    /// Two sets of texture coordinates of each vertex; (0, 0) is the upper left corner of an image. Empty if there are none.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear RGBA colour of each vertex, which multiplies the base colour; empty if there are none.
    pub colours: Vec<Vec4>,
    /// Vertex indices of each triangle, anticlockwise as seen from its front.
    pub triangles: Vec<[u32; 3]>,
    /// Material index of each triangle; empty if all have the first.
    pub materials: Vec<u32>,
}

/// What [`TriangleMesh::drop_unusable`] left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Triangles with an index beyond the vertices.
    pub out_of_range: usize,
    /// Triangles with a coordinate that is infinite, not a number, or beyond [`MAX_COORDINATE`].
    pub not_finite: usize,
}

impl TriangleMesh {
    /// Positions of a triangle's corners.
    ///
    /// # Panics
    /// If the triangle, or a vertex that it names, does not exist.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Material index of a triangle.
    pub fn material(&self, triangle: usize) -> u32 {
        self.materials.get(triangle).copied().unwrap_or(0)
    }

    /// Bounds of all triangles.
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points((0..self.triangles.len()).flat_map(|triangle| self.corners(triangle)))
    }

    /// Enclosed volume (divergence theorem); meaningful for closed meshes.
    pub fn volume(&self) -> f64 {
        self.sum(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
    }

    /// Surface area.
    pub fn area(&self) -> f64 {
        self.sum(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
    }

    /// Bytes in use by the arrays.
    pub fn size_in_bytes(&self) -> usize {
        12 * (self.positions.len() + self.normals.len() + self.triangles.len())
            + 16 * (self.tangents.len() + self.colours.len())
            + 8 * (self.uvs[0].len() + self.uvs[1].len())
            + 4 * self.materials.len()
    }

    /// Transforms all vertices. A transform that mirrors also swaps two corners of each triangle, so that fronts stay fronts.
    pub fn transform(&mut self, transform: Affine3A) {
        let is_mirror = transform.matrix3.determinant() < 0.0;
        let of_normals = cofactors(transform);
        for position in &mut self.positions {
            *position = transform.transform_point3(*position);
        }
        for normal in &mut self.normals {
            *normal = (of_normals * *normal).normalize_or_zero();
        }
        for tangent in &mut self.tangents {
            let along = transform.transform_vector3(tangent.truncate()).normalize_or_zero();
            *tangent = along.extend(if is_mirror { -tangent.w } else { tangent.w });
        }
        if is_mirror {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
    }

    /// Appends another mesh. Its material indices are kept.
    ///
    /// # Panics
    /// If there would be 2³² vertices or more.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len();
        let total = first + other.positions.len();
        let offset = u32::try_from(total).map(|_| first as u32).expect("fewer than 2^32 vertices");
        append_attribute(&mut self.normals, &other.normals, first, total, Vec3::ZERO);
        append_attribute(&mut self.tangents, &other.tangents, first, total, Vec4::ZERO);
        append_attribute(&mut self.colours, &other.colours, first, total, Vec4::ONE);
        for (uvs, others) in self.uvs.iter_mut().zip(&other.uvs) {
            append_attribute(uvs, others, first, total, Vec2::ZERO);
        }
        let triangles = self.triangles.len() + other.triangles.len();
        append_attribute(&mut self.materials, &other.materials, self.triangles.len(), triangles, 0);
        self.positions.extend_from_slice(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + offset)));
    }

    /// Leaves out triangles that cannot be used, and reports them.
    pub fn drop_unusable(&mut self) -> Dropped {
        let mut dropped = Dropped::default();
        let is_usable = |p: Vec3| p.abs().cmple(Vec3::splat(MAX_COORDINATE)).all();
        let mut kept = Vec::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            let corners = triangle.map(|vertex| self.positions.get(vertex as usize));
            match corners {
                [Some(&a), Some(&b), Some(&c)] if [a, b, c].into_iter().all(is_usable) => kept.push(index),
                [Some(_), Some(_), Some(_)] => dropped.not_finite += 1,
                _ => dropped.out_of_range += 1,
            }
        }
        if kept.len() < self.triangles.len() {
            self.triangles = kept.iter().map(|&index| self.triangles[index]).collect();
            if !self.materials.is_empty() {
                self.materials = kept.iter().map(|&index| self.materials[index]).collect();
            }
        }
        dropped
    }

    fn sum(&self, of: impl Fn([DVec3; 3]) -> f64) -> f64 {
        (0..self.triangles.len()).map(|triangle| of(self.corners(triangle).map(Vec3::as_dvec3))).sum()
    }
}

/// Matrix that transforms normals: the cofactors, which exist for flattening transforms, too, and keep the side of a mirrored
/// surface.
fn cofactors(transform: Affine3A) -> glam::Mat3 {
    let [x, y, z] = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis].map(Vec3::from);
    let sign = if transform.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
    glam::Mat3::from_cols(sign * y.cross(z), sign * z.cross(x), sign * x.cross(y))
}

/// Appends an attribute of which one of the two may have none.
fn append_attribute<T: Copy>(own: &mut Vec<T>, others: &[T], first: usize, total: usize, neutral: T) {
    if own.is_empty() && others.is_empty() {
        return;
    }
    own.resize(first, neutral);
    own.extend_from_slice(others);
    own.resize(total, neutral);
}
