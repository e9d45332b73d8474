//! Interpolation on a triangle: barycentric coordinates, normals and other vertex attributes at a point.

use super::surface::MeshSurface;
use glam::{Vec2, Vec3, Vec4};

/// Point on a triangle, in the mesh's coordinates.
#[derive(Clone, Copy, Debug)]
pub struct MeshPoint {
    /// Unit geometric normal, on the front of the triangle.
    pub normal: Vec3,
    /// Signed distance of the point to the triangle's plane.
    pub plane_distance: f32,
    /// Unit shading normal; the geometric one where the mesh has none.
    pub shading_normal: Vec3,
    /// Attributes for textures.
    pub attributes: MeshAttributes,
}

/// Vertex attributes at a point of a mesh, for textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshAttributes {
    /// Texture coordinates of both sets; (0, 0) is the upper left corner of a picture. Zero where there are none.
    pub uvs: [Vec2; 2],
    /// Length in texture coordinates of a unit of the mesh's coordinates, for both sets.
    pub uv_densities: [f32; 2],
    /// Tangent in the mesh's coordinates, of any length, and the sign of the bitangent; zero where there is none.
    pub tangent: Vec4,
    /// Linear colour and alpha of the vertices; white where there is none.
    pub colour: Vec4,
}

impl Default for MeshAttributes {
    fn default() -> Self {
        Self { uvs: [Vec2::ZERO; 2], uv_densities: [0.0; 2], tangent: Vec4::ZERO, colour: Vec4::ONE }
    }
}

/// Length in texture coordinates of a unit on a triangle with these edges and corners.
fn density(b: Vec3, c: Vec3, [uv_a, uv_b, uv_c]: [Vec2; 3]) -> f32 {
    let area = b.cross(c).length();
    ((uv_b - uv_a).perp_dot(uv_c - uv_a).abs() / area.max(f32::MIN_POSITIVE)).sqrt()
}

/// Unit normal of the triangle with edges `b` and `c` from its first corner. Edges are scaled first, so that the product of tiny
/// ones does not vanish.
fn normal_of(b: Vec3, c: Vec3) -> Vec3 {
    let scale = b.abs().max_element().max(c.abs().max_element()).max(f32::MIN_POSITIVE);
    (b / scale).cross(c / scale).normalize_or(Vec3::Y)
}

/// Weights of a triangle's second and third corner at the foot of a point, from 0 to 1.
fn barycentrics(b: Vec3, c: Vec3, p: Vec3) -> [f32; 2] {
    let scale = b.abs().max_element().max(c.abs().max_element()).max(f32::MIN_POSITIVE);
    let (b, c, p) = (b / scale, c / scale, p / scale);
    let normal = b.cross(c);
    let inverse = 1.0 / normal.length_squared().max(f32::MIN_POSITIVE);
    let v = (p.cross(c).dot(normal) * inverse).clamp(0.0, 1.0);
    let w = (b.cross(p).dot(normal) * inverse).clamp(0.0, 1.0 - v);
    [v, w]
}

impl MeshSurface {
    /// Normals and attributes at a point of a triangle.
    pub fn point(&self, triangle: u32, p: Vec3) -> MeshPoint {
        let mesh = self.mesh();
        let [a, b, c] = mesh.corners(triangle as usize);
        let (b, c, offset) = (b - a, c - a, p - a);
        let normal = normal_of(b, c);
        let [v, w] = barycentrics(b, c, offset);
        let corners = mesh.triangles[triangle as usize].map(|vertex| vertex as usize);
        let shading_normal = match mesh.normals.is_empty() {
            true => normal,
            false => {
                let [a, b, c] = corners.map(|corner| mesh.normals[corner]);
                smooth(a * (1.0 - v - w) + b * v + c * w, normal)
            }
        };
        let attributes = self.attributes(triangle, [v, w]);
        MeshPoint { normal, plane_distance: normal.dot(offset), shading_normal, attributes }
    }

    /// Attributes at a point of a triangle, given by the weights of its second and third corner.
    pub fn attributes(&self, triangle: u32, [v, w]: [f32; 2]) -> MeshAttributes {
        let mesh = self.mesh();
        let corners = mesh.triangles[triangle as usize].map(|vertex| vertex as usize);
        let corner_uvs = [0, 1].map(|set| match mesh.uvs[set].is_empty() {
            true => [Vec2::ZERO; 3],
            false => corners.map(|corner| mesh.uvs[set][corner]),
        });
        let [a, b, c] = mesh.corners(triangle as usize);
        let vector = |values: &[Vec4], otherwise: Vec4| match values.is_empty() {
            true => otherwise,
            false => {
                let [a, b, c] = corners.map(|corner| values[corner]);
                a * (1.0 - v - w) + b * v + c * w
            }
        };
        MeshAttributes {
            uvs: corner_uvs.map(|[a, b, c]| a + (b - a) * v + (c - a) * w),
            uv_densities: corner_uvs.map(|corners| density(b - a, c - a, corners)),
            tangent: vector(&mesh.tangents, Vec4::ZERO),
            colour: vector(&mesh.colours, Vec4::ONE),
        }
    }
}

/// Unit shading normal of an interpolated one, on the front of the triangle.
fn smooth(interpolated: Vec3, normal: Vec3) -> Vec3 {
    if interpolated.dot(normal) <= 1e-3 * interpolated.length() { normal } else { interpolated.normalize_or(normal) }
}
