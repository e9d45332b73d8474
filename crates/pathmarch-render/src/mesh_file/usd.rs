//! USD: text (`.usda`), and an archive of it (`.usdz`).
//!
//! Format: Universal Scene Description, openusd.org; *Usdz File Format Specification* 1.3: a zip archive without compression, whose
//! files start at multiples of 64 bytes.

use super::split_mesh::SplitMesh;
use glam::Vec3;
use pathmarch_field::Mesh;
use std::io::{self, Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Writes the text.
pub(super) fn write_text(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let split = SplitMesh::new(mesh);
    let of_vertices = |values: &[[f32; 3]]| -> Vec<[f32; 3]> {
        split.vertices.iter().map(|&vertex| values[vertex as usize]).collect()
    };
    let positions = of_vertices(&mesh.positions);
    let low = positions.iter().map(|&p| Vec3::from(p)).fold(Vec3::INFINITY, Vec3::min).to_array();
    let high = positions.iter().map(|&p| Vec3::from(p)).fold(Vec3::NEG_INFINITY, Vec3::max).to_array();
    write!(
        writer,
        "#usda 1.0\n(\n    defaultPrim = \"mesh\"\n    doc = \"pathmarch\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n\
         def Mesh \"mesh\"\n{{\n    uniform token subdivisionScheme = \"none\"\n"
    )?;
    array(writer, "float3[] extent", &[low, high], triple)?;
    array(writer, "int[] faceVertexCounts", &vec![3; split.triangles.len()], |writer, n| write!(writer, "{n}"))?;
    array(writer, "int[] faceVertexIndices", split.triangles.as_flattened(), |writer, n| write!(writer, "{n}"))?;
    array(writer, "point3f[] points", &positions, triple)?;
    let normals: Vec<[f32; 3]> = split.normals.iter().map(|normal| normal.to_array()).collect();
    vertex_array(writer, "normal3f[] normals", &normals)?;
    vertex_array(writer, "color3f[] primvars:displayColor", &of_vertices(&mesh.colours))?;
    writeln!(writer, "}}")
}

/// Writes an archive of the text.
pub(super) fn write_archive(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).with_alignment(64);
    archive.start_file("mesh.usda", options)?;
    write_text(&mut archive, mesh)?;
    writer.write_all(&archive.finish()?.into_inner())
}

/// Writes one element.
type WriteElement<T> = fn(&mut dyn Write, &T) -> io::Result<()>;

fn triple(writer: &mut dyn Write, [x, y, z]: &[f32; 3]) -> io::Result<()> {
    write!(writer, "({x}, {y}, {z})")
}

/// Writes an attribute, with elements in a line.
fn array<T>(writer: &mut dyn Write, name: &str, values: &[T], element: WriteElement<T>) -> io::Result<()> {
    write!(writer, "    {name} = [")?;
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            write!(writer, ", ")?;
        }
        element(writer, value)?;
    }
    writeln!(writer, "]")
}

/// Writes an attribute with a value for each vertex.
fn vertex_array(writer: &mut dyn Write, name: &str, values: &[[f32; 3]]) -> io::Result<()> {
    write!(writer, "    {name} = [")?;
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            write!(writer, ", ")?;
        }
        triple(writer, value)?;
    }
    writeln!(writer, "] (\n        interpolation = \"vertex\"\n    )")
}
