//! OBJ, with its materials from MTL files (`mtl.rs`).
//!
//! **Idea.** One pass over the lines. A vertex of the mesh is a combination of position, texture coordinate and normal that a face
//! names. Faces are triangulated (`polygon.rs`). All objects and groups become one mesh.
//!
//! **Differences.** Colours after the coordinates are sRGB, as most programs write them. Lines, points and free-form surfaces are
//! left out with a warning.
//!
//! **Source.** Wavefront 1990, appendix B1. **Cost.** Linear in the file.

use super::error::{Mistake, Warnings};
use super::files::{Companions, shortened};
use super::mtl::{self, MaterialLibrary};
use super::polygon::triangulate;
use super::text::{self, srgb_decode};
use crate::import::Imported;
use crate::material::Material;
use crate::triangle_mesh::TriangleMesh;
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::str::SplitWhitespace;

/// Reads an OBJ file.
pub(super) fn read(bytes: &[u8], companions: &Companions, warnings: &mut Warnings) -> Result<Imported, Mistake> {
    let mut reader = Reader::new(companions, warnings);
    let text = text::decode(bytes);
    let mut continued = String::new();
    for (index, line) in text.lines().enumerate() {
        reader.line = index + 1;
        // A backslash at the end continues a line.
        if let Some(start) = line.trim_end().strip_suffix('\\') {
            continued.push_str(start);
            continued.push(' ');
        } else if continued.is_empty() {
            reader.statement(line)?;
        } else {
            reader.statement(&(std::mem::take(&mut continued) + line))?;
        }
    }
    reader.statement(&continued)?;
    reader.finish()
}

/// Indices of a face's corner: position, and texture coordinate and normal if it has them.
type Corner = (u32, Option<u32>, Option<u32>);

struct Reader<'a> {
    companions: &'a Companions<'a>,
    warnings: &'a mut Warnings,
    line: usize,
    positions: Vec<Vec3>,
    /// Linear colour of each position, as far as there are any.
    colours: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Vertex of the mesh for each combination that a face names.
    vertices: HashMap<Corner, u32>,
    mesh: TriangleMesh,
    library: MaterialLibrary,
    materials: Vec<Material>,
    /// Index of each material in use, by name.
    used: HashMap<String, u32>,
    material: Option<u32>,
}

impl<'a> Reader<'a> {
    fn new(companions: &'a Companions<'a>, warnings: &'a mut Warnings) -> Self {
        Self {
            companions,
            warnings,
            line: 0,
            positions: Vec::new(),
            colours: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            vertices: HashMap::new(),
            mesh: TriangleMesh::default(),
            library: MaterialLibrary::default(),
            materials: Vec::new(),
            used: HashMap::new(),
            material: None,
        }
    }

    fn mistake(&self, problem: impl Into<String>) -> Mistake {
        Mistake::new(format!("line {}", self.line), problem)
    }

    fn warn(&mut self, message: impl Into<String>) {
        self.warnings.add(format!("line {}", self.line), message);
    }

    fn statement(&mut self, line: &str) -> Result<(), Mistake> {
        let line = line.split('#').next().unwrap_or("");
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        let rest = line.trim_start()[keyword.len()..].trim();
        match keyword {
            "v" => self.position(words)?,
            "vt" => {
                let [u, v] = self.leading(words, 1)?;
                // From v up to the orientation of images.
                self.uvs.push(Vec2::new(u, 1.0 - v));
            }
            "vn" => {
                let normal = Vec3::from(self.leading(words, 3)?);
                self.normals.push(normal.normalize_or_zero());
            }
            "f" | "fo" => self.face(words)?,
            "usemtl" => self.use_material(rest),
            "mtllib" => self.load_library(rest),
            "l" | "p" => self.warn("lines and points are left out"),
            "curv" | "curv2" | "surf" => self.warn("free-form curves and surfaces are left out"),
            // Names, smoothing groups, display attributes, and the parts of free-form surfaces.
            "o" | "g" | "s" | "mg" | "lod" | "bevel" | "c_interp" | "d_interp" | "shadow_obj" | "trace_obj" | "vp"
            | "cstype" | "deg" | "bmat" | "step" | "parm" | "trim" | "hole" | "scrv" | "sp" | "end" | "con"
            | "ctech" | "stech" | "maplib" | "usemap" => {}
            _ => self.warn(format!("unknown statement \"{}\" is ignored", shortened(keyword))),
        }
        Ok(())
    }

    fn numbers(&self, words: SplitWhitespace, limit: usize) -> Result<Vec<f32>, Mistake> {
        let number =
            |word| text::number(word).ok_or_else(|| self.mistake(format!("\"{}\" is not a number", shortened(word))));
        words.take(limit).map(number).collect()
    }

    /// The first numbers of a statement, of which `required` must be there.
    fn leading<const N: usize>(&self, words: SplitWhitespace, required: usize) -> Result<[f32; N], Mistake> {
        let numbers = self.numbers(words, N)?;
        if numbers.len() < required {
            return Err(self.mistake(format!("{required} numbers are needed, {} are there", numbers.len())));
        }
        Ok(std::array::from_fn(|k| numbers.get(k).copied().unwrap_or(0.0)))
    }

    /// Position, and a weight or a colour, or both.
    fn position(&mut self, words: SplitWhitespace) -> Result<(), Mistake> {
        let numbers = self.numbers(words, 7)?;
        let [x, y, z, after @ ..] = numbers.as_slice() else {
            return Err(self.mistake(format!("a vertex has three coordinates, not {}", numbers.len())));
        };
        if let [.., r, g, b] = *after {
            self.colours.resize(self.positions.len(), Vec3::ONE);
            self.colours.push(Vec3::new(r, g, b).map(srgb_decode));
        }
        self.positions.push(Vec3::new(*x, *y, *z));
        Ok(())
    }

    fn face(&mut self, words: SplitWhitespace) -> Result<(), Mistake> {
        let corners = words.map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            self.warn("faces of fewer than three corners are left out");
            return Ok(());
        }
        let vertices: Vec<u32> = corners.iter().map(|&corner| self.vertex(corner)).collect();
        let material = self.current_material();
        let positions: Vec<Vec3> = corners.iter().map(|corner| self.positions[corner.0 as usize]).collect();
        let Self { mesh, .. } = self;
        triangulate(&positions, |triangle| {
            mesh.triangles.push(triangle.map(|k| vertices[k]));
            mesh.materials.push(material);
        });
        Ok(())
    }

    /// Corner of a face: `position/uv/normal`, counted from one, or from the end if negative.
    fn corner(&self, word: &str) -> Result<Corner, Mistake> {
        let mut parts = word.split('/');
        let mut index = |name: &str, count: usize| match parts.next() {
            None | Some("") => Ok(None),
            Some(text) => self.index(text, name, count).map(Some),
        };
        let position = index("vertex", self.positions.len())?;
        let position = position.ok_or_else(|| self.mistake("a corner of a face has no vertex"))?;
        Ok((position, index("texture coordinate", self.uvs.len())?, index("normal", self.normals.len())?))
    }

    fn index(&self, text: &str, name: &str, count: usize) -> Result<u32, Mistake> {
        let number: Option<i64> = text.parse().ok();
        let index = number.and_then(|number| match number {
            1.. => usize::try_from(number - 1).ok(),
            _ => count.checked_sub(usize::try_from(number.checked_neg()?).ok()?).filter(|_| number < 0),
        });
        let valid = index.filter(|&index| index < count).and_then(|index| u32::try_from(index).ok());
        valid
            .ok_or_else(|| self.mistake(format!("{name} {} does not exist; there are {count} so far", shortened(text))))
    }

    fn vertex(&mut self, corner: Corner) -> u32 {
        if let Some(&vertex) = self.vertices.get(&corner) {
            return vertex;
        }
        let (position, uv, normal) = corner;
        let vertex = self.mesh.positions.len();
        let mesh = &mut self.mesh;
        mesh.positions.push(self.positions[position as usize]);
        if let Some(uv) = uv {
            mesh.uvs[0].resize(vertex, Vec2::ZERO);
            mesh.uvs[0].push(self.uvs[uv as usize]);
        }
        if let Some(normal) = normal {
            mesh.normals.resize(vertex, Vec3::ZERO);
            mesh.normals.push(self.normals[normal as usize]);
        }
        if let Some(colour) = self.colours.get(position as usize) {
            mesh.colours.resize(vertex, Vec4::ONE);
            mesh.colours.push(colour.extend(1.0));
        }
        self.vertices.insert(corner, vertex as u32);
        vertex as u32
    }

    fn current_material(&mut self) -> u32 {
        if let Some(material) = self.material {
            return material;
        }
        let plain = Material::plain();
        let base_colour = if self.colours.is_empty() { plain.base_colour } else { Vec3::ONE };
        self.materials.push(Material { base_colour, ..plain });
        let index = self.materials.len() as u32 - 1;
        self.material = Some(index);
        index
    }

    fn use_material(&mut self, name: &str) {
        if let Some(&index) = self.used.get(name) {
            self.material = Some(index);
            return;
        }
        let material = self.library.materials.get(name).cloned().unwrap_or_else(|| {
            let message = format!("material \"{}\" is in no library; white plastic is shown", shortened(name));
            self.warnings.add(format!("line {}", self.line), message);
            Material { name: name.to_string(), ..Material::plain() }
        });
        self.materials.push(material);
        let index = self.materials.len() as u32 - 1;
        self.used.insert(name.to_string(), index);
        self.material = Some(index);
    }

    /// Loads material libraries. A name with spaces is tried as one file first.
    fn load_library(&mut self, names: &str) {
        let place = format!("line {}", self.line);
        if self.library.is_full() {
            return self.warn("material libraries beyond the first hundred are ignored");
        }
        let whole = self.companions.read(names, &place);
        let libraries = match whole {
            Ok(bytes) => vec![Ok(bytes)],
            Err(_) if names.contains(char::is_whitespace) => {
                names.split_whitespace().take(100).map(|name| self.companions.read(name, &place)).collect()
            }
            Err(mistake) => vec![Err(mistake)],
        };
        for library in libraries {
            match library {
                Ok(bytes) => mtl::read(&bytes, self.companions, &mut self.library, self.warnings),
                Err(mistake) => self.warn(format!("{}; white plastic is shown", mistake.problem)),
            }
        }
    }

    fn finish(mut self) -> Result<Imported, Mistake> {
        let count = self.mesh.positions.len();
        for uvs in self.mesh.uvs.iter_mut().filter(|uvs| !uvs.is_empty()) {
            uvs.resize(count, Vec2::ZERO);
        }
        if !self.mesh.normals.is_empty() {
            self.mesh.normals.resize(count, Vec3::ZERO);
        }
        if !self.mesh.colours.is_empty() {
            self.mesh.colours.resize(count, Vec4::ONE);
        }
        if self.mesh.triangles.is_empty() {
            let problem = format!("there are no faces, but {} points", self.positions.len());
            return Err(Mistake::with_remedy("file", problem, "export a surface of triangles"));
        }
        Ok(Imported { images: self.library.images, ..Imported::of_mesh(self.mesh, self.materials) })
    }
}
