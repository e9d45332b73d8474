//! Binary glTF 2.0: a JSON chunk that describes the mesh, then a binary chunk with its data.
//!
//! A vertex of a glTF mesh has one normal. If the triangles around a vertex face different directions, the vertex is duplicated
//! for each side, so that sharp edges are shaded sharp.

use super::write_numbers;
use glam::Vec3;
use pathmarch_field::Mesh;
use serde_json::json;
use std::io::{self, Write};

/// Cosine of the largest angle between the normals of triangles on one side of an edge: 30°.
const SMOOTH_COSINE: f32 = 0.866;

/// Mesh whose vertices have one normal each.
struct SplitMesh {
    /// Index in the original mesh of each vertex.
    vertices: Vec<u32>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

pub(super) fn write(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let split = split_at_edges(mesh);
    let (vertices, corners) = (split.vertices.len(), 3 * split.triangles.len());
    let low = mesh.positions.iter().map(|&p| Vec3::from(p)).fold(Vec3::INFINITY, Vec3::min).to_array();
    let high = mesh.positions.iter().map(|&p| Vec3::from(p)).fold(Vec3::NEG_INFINITY, Vec3::max).to_array();
    const ARRAY: u32 = 34962;
    const INDICES: u32 = 34963;
    let (of_vertices, of_corners) = (12 * vertices, 4 * corners);
    let view = |start: usize, length: usize, target: u32| json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target });
    let accessor = |view: u32| json!({ "bufferView": view, "componentType": 5126, "count": vertices, "type": "VEC3" });
    let mut positions = accessor(0);
    positions["min"] = json!(low);
    positions["max"] = json!(high);
    let length = 3 * of_vertices + of_corners;
    let description = json!({
        "asset": { "version": "2.0", "generator": "pathmarch" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "COLOR_0": 2 },
            "indices": 3,
            "material": 0,
        }] }],
        "materials": [{ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 } }],
        "accessors": [
            positions,
            accessor(1),
            accessor(2),
            { "bufferView": 3, "componentType": 5125, "count": corners, "type": "SCALAR" },
        ],
        "bufferViews": [
            view(0, of_vertices, ARRAY),
            view(of_vertices, of_vertices, ARRAY),
            view(2 * of_vertices, of_vertices, ARRAY),
            view(3 * of_vertices, of_corners, INDICES),
        ],
        "buffers": [{ "byteLength": length }],
    });
    let mut description = description.to_string();
    while !description.len().is_multiple_of(4) {
        description.push(' ');
    }
    let total = 12 + 8 + description.len() + 8 + length;
    let total = u32::try_from(total).map_err(|_| {
        io::Error::other("a .glb file is limited to four gigabytes; use a coarser mesh or another format")
    })?;
    writer.write_all(b"glTF")?;
    for word in [2, total, description.len() as u32] {
        writer.write_all(&word.to_le_bytes())?;
    }
    writer.write_all(b"JSON")?;
    writer.write_all(description.as_bytes())?;
    writer.write_all(&(length as u32).to_le_bytes())?;
    writer.write_all(b"BIN\0")?;
    write_numbers(writer, split.vertices.iter().flat_map(|&vertex| mesh.positions[vertex as usize]))?;
    write_numbers(writer, split.normals.iter().flat_map(|normal| normal.to_array()))?;
    write_numbers(writer, split.vertices.iter().flat_map(|&vertex| mesh.colours[vertex as usize]))?;
    split.triangles.as_flattened().iter().try_for_each(|vertex| writer.write_all(&vertex.to_le_bytes()))
}

fn split_at_edges(mesh: &Mesh) -> SplitMesh {
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
