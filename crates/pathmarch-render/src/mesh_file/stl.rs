//! Binary STL: an 80-byte header without meaning, the number of triangles, and for each triangle its normal, corners and two
//! unused bytes.

use super::write_numbers;
use glam::Vec3;
use pathmarch_field::Mesh;
use std::io::{self, Write};

pub(super) fn write(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let mut header = [b' '; 80];
    let words = b"pathmarch, metres, y up";
    header[..words.len()].copy_from_slice(words);
    writer.write_all(&header)?;
    writer.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for &triangle in &mesh.triangles {
        let [a, b, c] = mesh.corners(triangle).map(Vec3::from);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        write_numbers(writer, [normal, a, b, c].iter().flat_map(Vec3::to_array))?;
        writer.write_all(&[0, 0])?;
    }
    Ok(())
}
