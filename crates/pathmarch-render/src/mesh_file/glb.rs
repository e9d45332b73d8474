//! Binary glTF 2.0: a JSON chunk that describes the mesh and the cameras, then a binary chunk with the mesh's data.

use super::split_mesh::SplitMesh;
use super::write_numbers;
use glam::{Mat3, Quat, Vec3};
use pathmarch_field::Mesh;
use pathmarch_scene::{Camera, Scene};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::iter;

pub(super) fn write(writer: &mut dyn Write, mesh: &Mesh, scene: &Scene) -> io::Result<()> {
    let split = SplitMesh::new(mesh);
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
    let aspect = scene.render.size.0 as f32 / scene.render.size.1 as f32;
    let description = json!({
        "asset": { "version": "2.0", "generator": "pathmarch" },
        "scene": 0,
        "scenes": [{ "nodes": (0..=scene.cameras.len()).collect::<Value>() }],
        "nodes": iter::once(json!({ "mesh": 0 })).chain(scene.cameras.iter().enumerate().map(camera_node)).collect::<Value>(),
        "cameras": scene.cameras.iter().map(|camera| projection(camera, aspect)).collect::<Value>(),
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

/// Projection of a camera.
fn projection(camera: &Camera, aspect: f32) -> Value {
    let yfov = camera.fov.to_radians();
    json!({
        "name": camera.name,
        "type": "perspective",
        "perspective": { "yfov": yfov, "aspectRatio": aspect, "znear": 0.01 },
    })
}

/// Node that places a camera. It looks along -z, with y up in the picture.
fn camera_node((index, camera): (usize, &Camera)) -> Value {
    let back = (Vec3::from(camera.position) - Vec3::from(camera.target)).normalize();
    let right = Vec3::from(camera.up).cross(back).normalize();
    let rotation = Quat::from_mat3(&Mat3::from_cols(right, back.cross(right), back)).normalize();
    json!({
        "name": camera.name,
        "camera": index,
        "translation": camera.position,
        "rotation": rotation.to_array(),
    })
}
