//! Volumes of distances: NumPy's `.npy`.
//!
//! **Idea.** An array of three dimensions, `array[x, y, z]`, holds values at the points of a grid, negative inside, whose scale does
//! not matter. Its surface is where linear interpolation between neighbours is zero, as triangles, so that a volume is a mesh like any
//! other: triangles, or exact distances as a field. Every cell is cut into six tetrahedra around its diagonal (Kuhn 1960), which
//! fit those of its neighbours, so that the surface is closed (Doi and Koide 1991). The longest edge of the grid
//! goes from -1 to 1, and its centre is the origin. Normals are those of the gradient.
//!
//! **Source.** NumPy Enhancement Proposal 1, versions 1 to 3 of the format. **Limits.** 32-bit and 64-bit floats. Where values are
//! negative at the border, the surface is closed half a step beyond it. **Cost.** Memory of about thirty bytes for each voxel at the surface.

use super::error::{Mistake, Warnings};
use crate::triangle_mesh::TriangleMesh;
use glam::{UVec3, Vec3};
use std::collections::HashMap;

/// First bytes of a file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// Most triangles of a surface; noise has several in every voxel.
const MAX_TRIANGLES: usize = 20_000_000;
/// Orders of the axes, and whether the order is an even permutation. Corners of a tetrahedron lie on the way from a cell's
/// least corner to its greatest, along the axes in this order.
const TETRAHEDRA: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([1, 0, 2], false),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
];

/// Reads a volume.
pub(super) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<TriangleMesh, Mistake> {
    let volume = Volume::read(bytes, warnings)?;
    let mut surface = Surface { volume: &volume, vertices: HashMap::new(), mesh: TriangleMesh::default() };
    surface.trace()?;
    if surface.mesh.triangles.is_empty() {
        let remedy = "subtract the value of the surface from all values, and make the inside negative";
        return Err(Mistake::with_remedy("data", "all values have the same sign", remedy));
    }
    Ok(surface.mesh)
}

/// Values at the points of a grid, with a border of one point that is outside.
struct Volume {
    size: UVec3,
    /// x varies fastest.
    values: Vec<f32>,
}

impl Volume {
    fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<Self, Mistake> {
        let (header, data) = split(bytes)?;
        let is_big = match entry(header, "descr")? {
            "'<f4'" | "'<f8'" => false,
            "'>f4'" | "'>f8'" => true,
            other => {
                let problem = format!("values of the type {}", super::files::shortened(other));
                return Err(Mistake::with_remedy("header", problem, "convert them: array.astype(\"float32\")"));
            }
        };
        let width = if entry(header, "descr")?.contains('8') { 8 } else { 4 };
        let is_fortran = match entry(header, "fortran_order")? {
            "True" => true,
            "False" => false,
            _ => return Err(Mistake::new("header", "fortran_order is neither True nor False")),
        };
        let size = shape(entry(header, "shape")?)?;
        let count = size.iter().try_fold(1, |count: usize, side| count.checked_mul(*side as usize));
        if count.and_then(|count| count.checked_mul(width)) != Some(data.len()) {
            let [x, y, z] = size;
            return Err(Mistake::new(
                "data",
                format!("{} bytes are not {x} x {y} x {z} values of {width}", data.len()),
            ));
        }
        let value = |index: usize| {
            let bytes = &data[index * width..][..width];
            let mut ordered = [0; 8];
            ordered[..width].copy_from_slice(bytes);
            if is_big {
                ordered[..width].reverse();
            }
            if width == 8 {
                f64::from_le_bytes(ordered) as f32
            } else {
                f32::from_le_bytes([ordered[0], ordered[1], ordered[2], ordered[3]])
            }
        };
        let [width, height, depth] = size.map(|side| side as usize);
        let mut values = Vec::with_capacity(width * height * depth);
        for z in 0..depth {
            for y in 0..height {
                let index =
                    |x: usize| if is_fortran { x + width * (y + height * z) } else { z + depth * (y + height * x) };
                values.extend((0..width).map(|x| value(index(x))));
            }
        }
        let broken = values.iter().filter(|value| !value.is_finite()).count();
        if broken > 0 {
            warnings.add("data", format!("{broken} values that are not finite count as outside"));
        }
        Ok(Self { size: UVec3::from(size), values })
    }

    /// Value at a point; one step beyond the border, and where values are not finite, it is outside.
    fn at(&self, point: [i32; 3]) -> f32 {
        let inside = (0..3).all(|k| (0..self.size[k] as i32).contains(&point[k]));
        let [x, y, z] = std::array::from_fn(|k| point[k].clamp(0, self.size[k] as i32 - 1) as usize);
        let value = self.values[x + self.size.x as usize * (y + self.size.y as usize * z)];
        match (inside, value.is_finite()) {
            // Products and differences of values stay finite.
            (true, true) => value.clamp(-1e30, 1e30),
            (false, true) => value.abs().clamp(1e-30, 1e30),
            (_, false) => 1.0,
        }
    }

    /// Central differences at a point.
    fn gradient(&self, point: [i32; 3]) -> Vec3 {
        let beside = |axis: usize, step: i32| {
            let mut point = point;
            point[axis] += step;
            self.at(point)
        };
        Vec3::from_array(std::array::from_fn(|axis| beside(axis, 1) - beside(axis, -1)))
    }
}

/// Header and data.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), Mistake> {
    let short = || Mistake::new("header", "the file ends within the header");
    if !bytes.starts_with(MAGIC) {
        return Err(Mistake::new("byte 0", "the file does not begin as NumPy's arrays do"));
    }
    let number = |range: std::ops::Range<usize>| {
        let bytes = bytes.get(range).ok_or_else(short)?;
        Ok(bytes.iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte)))
    };
    let (start, length) = match number(6..7)? {
        1 => (10, number(8..10)?),
        2 | 3 => (12, number(8..12)?),
        version => return Err(Mistake::new("byte 6", format!("version {version} of the format is not known"))),
    };
    let end = start + length;
    let header = bytes.get(start..end).ok_or_else(short)?;
    let header = std::str::from_utf8(header).map_err(|_| Mistake::new("header", "the header is no text"))?;
    Ok((header, &bytes[end..]))
}

/// Value of an entry of the header, which is a dictionary as Python writes it.
fn entry<'h>(header: &'h str, name: &str) -> Result<&'h str, Mistake> {
    let find = || {
        let after = header.split_once(&format!("'{name}':"))?.1.trim_start();
        let end = if after.starts_with('(') { after.find(')')? + 1 } else { after.find([',', '}'])? };
        Some(after[..end].trim_end())
    };
    find().ok_or_else(|| Mistake::new("header", format!("there is no {name}")))
}

fn shape(text: &str) -> Result<[u32; 3], Mistake> {
    let sides = text.trim_matches(['(', ')']).split(',').map(str::trim).filter(|side| !side.is_empty());
    let sides: Option<Vec<u32>> = sides.map(|side| side.parse().ok().filter(|side| *side <= 1 << 20)).collect();
    let wrong = |problem: &str| {
        let remedy = "save one array of three dimensions, array[x, y, z], each of at least 2";
        Mistake::with_remedy("header", format!("{problem}: {}", super::files::shortened(text)), remedy)
    };
    let sides = sides.ok_or_else(|| wrong("the shape cannot be read"))?;
    let sides: [u32; 3] = sides.try_into().map_err(|_| wrong("the shape has not three dimensions"))?;
    if sides.iter().any(|side| *side < 2) { Err(wrong("the shape is too small")) } else { Ok(sides) }
}

/// The surface so far.
struct Surface<'v> {
    volume: &'v Volume,
    /// Vertices by the least corner and the direction of their edge.
    vertices: HashMap<([i32; 3], [i32; 3]), u32>,
    mesh: TriangleMesh,
}

impl Surface<'_> {
    /// Adds the triangles of all cells, with those of the border.
    fn trace(&mut self) -> Result<(), Mistake> {
        let [width, height, depth] = self.volume.size.to_array().map(|side| side as i32);
        for z in -1..depth {
            for y in -1..height {
                for x in -1..width {
                    self.cell([x, y, z]);
                }
            }
            if self.mesh.triangles.len() > MAX_TRIANGLES {
                let remedy = "smooth the volume, or save fewer values";
                return Err(Mistake::with_remedy("data", "the surface has more than 20 million triangles", remedy));
            }
        }
        Ok(())
    }

    fn cell(&mut self, least: [i32; 3]) {
        let corner = |bits: usize| std::array::from_fn(|axis| least[axis] + (bits >> axis & 1) as i32);
        let inside: [bool; 8] = std::array::from_fn(|bits| self.volume.at(corner(bits)) < 0.0);
        if inside.iter().all(|is_inside| *is_inside == inside[0]) {
            return;
        }
        for (axes, is_even) in TETRAHEDRA {
            let bits = [0, 1 << axes[0], 1 << axes[0] | 1 << axes[1], 7];
            self.tetrahedron(bits.map(corner), bits.map(|bits| inside[bits]), is_even);
        }
    }

    /// Adds what the surface cuts out of a tetrahedron, `is_even` if its last corner is in front of the anticlockwise others as seen
    /// from the first.
    fn tetrahedron(&mut self, corners: [[i32; 3]; 4], inside: [bool; 4], is_even: bool) {
        let count = inside.iter().filter(|is_inside| **is_inside).count();
        // The corners in another order that is an even permutation: the lone one first, or the two inside first.
        let lone = |is_inside: bool| {
            let first = inside.iter().position(|found| *found == is_inside).unwrap_or(0);
            [0, 1, 2, 3].map(|k: usize| corners[first ^ k])
        };
        let (polygon, flip): (Vec<u32>, bool) = match count {
            1 | 3 => {
                let [a, b, c, d] = lone(count == 1);
                (vec![self.vertex(a, b), self.vertex(a, c), self.vertex(a, d)], count == 3)
            }
            2 => {
                let order = match inside {
                    [true, true, _, _] => [0, 1, 2, 3],
                    [true, _, true, _] => [0, 2, 3, 1],
                    [true, _, _, true] => [0, 3, 1, 2],
                    [_, true, true, _] => [1, 2, 0, 3],
                    [_, true, _, true] => [1, 3, 2, 0],
                    _ => [2, 3, 0, 1],
                };
                let [a, b, c, d] = order.map(|k: usize| corners[k]);
                (vec![self.vertex(a, c), self.vertex(a, d), self.vertex(b, d), self.vertex(b, c)], false)
            }
            _ => return,
        };
        for k in 1..polygon.len() - 1 {
            let [b, c] = if flip == is_even { [k + 1, k] } else { [k, k + 1] };
            self.mesh.triangles.push([polygon[0], polygon[b], polygon[c]]);
        }
    }

    /// Vertex on the edge between two points of different signs.
    fn vertex(&mut self, a: [i32; 3], b: [i32; 3]) -> u32 {
        // Corners of a tetrahedron are in the order of all their coordinates.
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        let direction = std::array::from_fn(|axis| b[axis] - a[axis]);
        let (volume, mesh) = (self.volume, &mut self.mesh);
        *self.vertices.entry((a, direction)).or_insert_with(|| {
            let [at_a, at_b] = [volume.at(a), volume.at(b)];
            // Not at the points themselves, where several vertices would coincide.
            let t = (at_a / (at_a - at_b)).clamp(1e-3, 1.0 - 1e-3);
            let [first, last] = [a, b].map(|point| Vec3::from_array(point.map(|k| k as f32)));
            let middle = 0.5 * (volume.size.as_vec3() - 1.0);
            mesh.positions.push((first.lerp(last, t) - middle) / middle.max_element());
            let gradient = volume.gradient(a).lerp(volume.gradient(b), t);
            mesh.normals.push(gradient.normalize_or_zero());
            mesh.positions.len() as u32 - 1
        })
    }
}
