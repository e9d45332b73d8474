//! Binary PLY: a header that describes the data, then vertices with colours, then triangles.

use super::write_numbers;
use crate::output::tonemap::srgb_encode;
use pathmarch_field::Mesh;
use std::io::{self, Write};

pub(super) fn write(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    write!(
        writer,
        "ply\nformat binary_little_endian 1.0\ncomment pathmarch, metres, y up\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for (position, colour) in mesh.positions.iter().zip(&mesh.colours) {
        write_numbers(writer, *position)?;
        writer.write_all(&colour.map(|v| (srgb_encode(v) * 255.0).round() as u8))?;
    }
    for triangle in &mesh.triangles {
        writer.write_all(&[3])?;
        triangle.iter().try_for_each(|vertex| writer.write_all(&vertex.to_le_bytes()))?;
    }
    Ok(())
}
