//! Meshes whose vertices have one normal each, as glTF and USD want them.
//!
//! If the triangles around a vertex face different directions, the vertex is duplicated for each side, so that sharp edges are
//! shaded sharp.

use glam::Vec3;
use pathmarch_field::Mesh;

/// Cosine of the largest angle between the normals of triangles on one side of an edge: 30°.
const SMOOTH_COSINE: f32 = 0.866;

/// Mesh whose vertices have one normal each.
pub(super) struct SplitMesh {
    /// Index in the original mesh of each vertex.
    pub(super) vertices: Vec<u32>,
    /// Normal of each vertex.
    pub(super) normals: Vec<Vec3>,
    /// Triangles, as indices of three vertices.
    pub(super) triangles: Vec<[u32; 3]>,
}

impl SplitMesh {
    /// Splits the vertices of a mesh at its sharp edges.
    pub(super) fn new(mesh: &Mesh) -> Self {
        // Triangles around each vertex: those of vertex v are in starts[v]..starts[v + 1].
        let mut starts = vec![0; mesh.positions.len() + 1];
        for vertex in mesh.triangles.as_flattened() {
            starts[*vertex as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        let mut around = vec![(0, 0); starts[mesh.positions.len()]];
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            for (corner, vertex) in triangle.iter().enumerate() {
                around[next[*vertex as usize]] = (number, corner);
                next[*vertex as usize] += 1;
            }
        }
        let area_normal = |number: usize| {
            let [a, b, c] = mesh.corners(mesh.triangles[number]).map(Vec3::from);
            (b - a).cross(c - a)
        };
        let mut split = SplitMesh { vertices: Vec::new(), normals: Vec::new(), triangles: mesh.triangles.clone() };
        // For each side of a vertex, the normal of its first triangle and the sum of area-weighted normals.
        let mut sides: Vec<(Vec3, Vec3)> = Vec::new();
        for vertex in 0..mesh.positions.len() {
            let around = &around[starts[vertex]..starts[vertex + 1]];
            let exact = Vec3::from(mesh.normals[vertex]);
            let first = split.vertices.len();
            sides.clear();
            for &(number, corner) in around {
                let area_normal = area_normal(number);
                let normal = area_normal.normalize_or(exact);
                let known = sides.iter().position(|(side, _)| side.dot(normal) > SMOOTH_COSINE);
                let side = known.unwrap_or_else(|| {
                    sides.push((normal, Vec3::ZERO));
                    sides.len() - 1
                });
                sides[side].1 += area_normal;
                split.triangles[number][corner] = (first + side) as u32;
            }
            if let [(_, sum)] = &mut sides[..] {
                *sum = exact;
            }
            split.vertices.extend(sides.iter().map(|_| vertex as u32));
            split.normals.extend(sides.iter().map(|(side, sum)| sum.try_normalize().unwrap_or(*side)));
        }
        split
    }
}
