//! OBJ: a line for each vertex, with its colour after the coordinates as most programs expect, and a line for each triangle.

use crate::output::tonemap::srgb_encode;
use pathmarch_field::Mesh;
use std::io::{self, Write};

pub(super) fn write(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    writeln!(writer, "# pathmarch, metres, y up\no mesh")?;
    for ([x, y, z], colour) in mesh.positions.iter().zip(&mesh.colours) {
        let [r, g, b] = colour.map(srgb_encode);
        writeln!(writer, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}")?;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        writeln!(writer, "f {a} {b} {c}")?;
    }
    Ok(())
}
