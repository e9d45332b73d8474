//! STL, binary and text.
//!
//! **Idea.** A file is binary if its size is that of the number of triangles in it, whatever it begins with. Corners at the same
//! position become one vertex. The solids of a text become one mesh. Facet normals are those of the corners and ignored.
//!
//! **Source.** 3D Systems 1989. **Cost.** Memory of about twice the file.

use super::error::{Mistake, Warnings};
use super::text;
use crate::triangle_mesh::TriangleMesh;
use glam::Vec3;
use std::collections::HashMap;

/// Bytes before the first triangle, and of each.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads an STL file.
pub(super) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<TriangleMesh, Mistake> {
    let declared =
        bytes.get(80..HEADER).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize);
    let expected = declared.map(|count| HEADER.saturating_add(count.saturating_mul(TRIANGLE)));
    let is_text = text::decode(&bytes[..bytes.len().min(512)])
        .trim_start()
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case("solid"));
    match (declared, expected) {
        (Some(_), Some(expected)) if expected == bytes.len() => Ok(read_binary(&bytes[HEADER..])),
        _ if is_text => read_text(&text::decode(bytes)),
        (Some(_), Some(expected)) if expected < bytes.len() => {
            warnings.add(format!("byte {expected}"), "bytes after the last triangle are ignored");
            Ok(read_binary(&bytes[HEADER..expected]))
        }
        (Some(count), _) => {
            let problem =
                format!("{count} triangles are declared, but there is room for {}", (bytes.len() - HEADER) / TRIANGLE);
            Err(Mistake::new("byte 80", problem))
        }
        _ => Err(Mistake::new("byte 0", "neither a text that begins with \"solid\" nor a binary header of 84 bytes")),
    }
}

fn read_binary(bytes: &[u8]) -> TriangleMesh {
    let mut builder = Builder::default();
    for triangle in bytes.chunks_exact(TRIANGLE) {
        let coordinate = |k: usize| {
            let first = 12 + 4 * k;
            f32::from_le_bytes([triangle[first], triangle[first + 1], triangle[first + 2], triangle[first + 3]])
        };
        builder.push([0, 3, 6].map(|k| Vec3::new(coordinate(k), coordinate(k + 1), coordinate(k + 2))));
    }
    builder.mesh
}

fn read_text(text: &str) -> Result<TriangleMesh, Mistake> {
    let mut builder = Builder::default();
    let mut corners = Vec::with_capacity(3);
    for (index, line) in text.lines().enumerate() {
        let mistake = |problem: &str| Mistake::new(format!("line {}", index + 1), problem);
        let mut words = line.split_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => {
                let mut coordinate =
                    || words.next().and_then(text::number).ok_or_else(|| mistake("a vertex has three numbers"));
                corners.push(Vec3::new(coordinate()?, coordinate()?, coordinate()?));
            }
            Some("endloop") => {
                let Ok(triangle) = <[Vec3; 3]>::try_from(std::mem::take(&mut corners)) else {
                    return Err(mistake("a loop has three vertices"));
                };
                builder.push(triangle);
            }
            None | Some("solid" | "facet" | "outer" | "endfacet" | "endsolid" | "end" | "color") => {}
            Some(word) => {
                let problem = format!("\"{}\" is not a word of STL", super::files::shortened(word));
                return Err(mistake(&problem));
            }
        }
    }
    if !corners.is_empty() {
        return Err(Mistake::new("last line", "the file ends within a facet"));
    }
    Ok(builder.mesh)
}

/// Mesh under construction, and the vertex at each position.
#[derive(Default)]
struct Builder {
    mesh: TriangleMesh,
    vertices: HashMap<[u32; 3], u32>,
}

impl Builder {
    fn push(&mut self, corners: [Vec3; 3]) {
        let positions = &mut self.mesh.positions;
        let vertices = &mut self.vertices;
        let triangle = corners.map(|corner| {
            // Adding zero makes -0 equal 0.
            let key = (corner + Vec3::ZERO).to_array().map(f32::to_bits);
            *vertices.entry(key).or_insert_with(|| {
                positions.push(corner);
                positions.len() as u32 - 1
            })
        });
        self.mesh.triangles.push(triangle);
    }
}
