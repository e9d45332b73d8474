//! Primitives: the triangles of a mesh with one material.

use super::super::error::{Mistake, Warnings};
use super::accessor::Accessor;
use super::buffers::Buffers;
use super::json;
use crate::triangle_mesh::TriangleMesh;
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Vertices and indices that a file may still expand to. A file may name the same bytes any number of times; without a
/// limit, a few kilobytes would fill the memory.
pub struct Budget {
    pub left: usize,
    pub total: usize,
}

impl Budget {
    fn take(&mut self, count: usize, place: &str) -> Result<(), Mistake> {
        let left = self.left.checked_sub(count);
        self.left = left.ok_or_else(|| {
            let problem =
                format!("the meshes have more than {} vertices, far more than the file has bytes for", self.total);
            Mistake::with_remedy(place, problem, "store the same mesh once and place it by several nodes")
        })?;
        Ok(())
    }
}

/// Loads the buffers of a primitive's accessors.
pub fn load(primitive: &json::Primitive, root: &json::Root, buffers: &mut Buffers) -> Result<(), Mistake> {
    primitive
        .indices
        .iter()
        .chain(primitive.attributes.values())
        .try_for_each(|&index| Accessor::load(index, root, buffers))
}

/// Appends the triangles of a primitive to a mesh. Only vertices that they name are kept.
pub fn append(
    mesh: &mut TriangleMesh,
    primitive: &json::Primitive,
    material: u32,
    (root, buffers): (&json::Root, &Buffers),
    (place, budget, warnings): (&str, &mut Budget, &mut Warnings),
) -> Result<(), Mistake> {
    let mode = primitive.mode.unwrap_or(4);
    if mode <= 3 {
        warnings.add(place, "points and lines are left out");
        return Ok(());
    }
    let attributes = Attributes::new(primitive, root, buffers, place, warnings)?;
    let count = attributes.position.count;
    let indices = primitive.indices.map(|index| Accessor::new(index, root, buffers)).transpose()?;
    if indices.as_ref().is_some_and(|indices| !indices.is_indices()) {
        return Err(Mistake::new(place, "indices must be unsigned integers"));
    }
    let corners = indices.as_ref().map_or(count, |indices| indices.count);
    let replaced = indices.as_ref().map_or(0, Accessor::replaced_count) + attributes.replaced_count();
    budget.take(corners.saturating_add(replaced), place)?;
    let corner = |k: usize| indices.as_ref().map_or(k as u32, |indices| indices.index(k));
    if let Some(bad) = (0..corners).map(corner).find(|&vertex| vertex as usize >= count) {
        return Err(Mistake::new(place, format!("index {bad} is beyond the {count} vertices")));
    }
    let mut part = Part { attributes, vertices: HashMap::new(), mesh: TriangleMesh::default() };
    for [a, b, c] in triangles(mode, corners).ok_or_else(|| Mistake::new(place, format!("{mode} is not a mode")))? {
        let triangle = [corner(a), corner(b), corner(c)].map(|vertex| part.vertex(vertex));
        part.mesh.triangles.push(triangle);
        part.mesh.materials.push(material);
    }
    mesh.append(&part.mesh);
    Ok(())
}

/// Corners of each triangle of a mode: triangles, strip or fan.
fn triangles(mode: u32, corners: usize) -> Option<Box<dyn Iterator<Item = [usize; 3]>>> {
    let windows = corners.saturating_sub(2);
    Some(match mode {
        4 => Box::new((0..corners / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2])),
        // The order that the specification gives (section 3.7.2.1), which keeps the orientation.
        5 => Box::new((0..windows).map(|k| [k, k + 1 + k % 2, k + 2 - k % 2])),
        6 => Box::new((0..windows).map(|k| [k + 1, k + 2, 0])),
        _ => return None,
    })
}

/// Accessors of the attributes that are read.
struct Attributes<'a> {
    position: Accessor<'a>,
    normal: Option<Accessor<'a>>,
    tangent: Option<Accessor<'a>>,
    uvs: [Option<Accessor<'a>>; 2],
    colour: Option<Accessor<'a>>,
}

impl<'a> Attributes<'a> {
    fn new(
        primitive: &json::Primitive,
        root: &json::Root,
        buffers: &'a Buffers,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Self, Mistake> {
        let missing = || Mistake::new(place, "there is no attribute POSITION");
        let position = Accessor::new(*primitive.attributes.get("POSITION").ok_or_else(missing)?, root, buffers)?;
        if position.width != 3 {
            return Err(Mistake::new(place, "POSITION must have three numbers"));
        }
        let count = position.count;
        let optional = |name: &str, widths: &[usize]| {
            let Some(&index) = primitive.attributes.get(name) else { return Ok(None) };
            let accessor = Accessor::new(index, root, buffers)?;
            if !widths.contains(&accessor.width) || accessor.count < count {
                let problem = format!("{name} has {} elements of {} numbers", accessor.count, accessor.width);
                return Err(Mistake::new(place, problem));
            }
            Ok(Some(accessor))
        };
        for name in primitive.attributes.keys() {
            let is_read =
                ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"].contains(&name.as_str());
            // Names of applications begin with an underscore; skins are reported for the file.
            if !is_read && !name.starts_with('_') && !name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_") {
                warnings.add(place, format!("attribute {} is ignored", super::shortened(name)));
            }
        }
        Ok(Self {
            normal: optional("NORMAL", &[3])?,
            tangent: optional("TANGENT", &[4])?,
            uvs: [optional("TEXCOORD_0", &[2])?, optional("TEXCOORD_1", &[2])?],
            colour: optional("COLOR_0", &[3, 4])?.filter(Accessor::is_real),
            position,
        })
    }

    fn replaced_count(&self) -> usize {
        let optional = [&self.normal, &self.tangent, &self.uvs[0], &self.uvs[1], &self.colour];
        let optional = optional.into_iter().flatten().map(Accessor::replaced_count).sum::<usize>();
        self.position.replaced_count() + optional
    }
}

/// Mesh of a primitive under construction.
struct Part<'a> {
    attributes: Attributes<'a>,
    /// Vertex of the mesh for each vertex of the file.
    vertices: HashMap<u32, u32>,
    mesh: TriangleMesh,
}

impl Part<'_> {
    fn vertex(&mut self, index: u32) -> u32 {
        if let Some(&vertex) = self.vertices.get(&index) {
            return vertex;
        }
        let Self { attributes, mesh, .. } = self;
        let at = index as usize;
        let vector = |accessor: &Accessor| Vec4::from(accessor.numbers(at));
        mesh.positions.push(vector(&attributes.position).truncate());
        // What is no direction becomes zero, which means the triangle's own.
        let unit = |v: Vec3| v.try_normalize().unwrap_or(Vec3::ZERO);
        mesh.normals.extend(attributes.normal.as_ref().map(|normal| unit(vector(normal).truncate())));
        mesh.tangents.extend(attributes.tangent.as_ref().map(|tangent| {
            let tangent = vector(tangent);
            unit(tangent.truncate()).extend(if tangent.w < 0.0 { -1.0 } else { 1.0 })
        }));
        for (uvs, accessor) in mesh.uvs.iter_mut().zip(&attributes.uvs) {
            let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
            uvs.extend(accessor.as_ref().map(|accessor| finite(vector(accessor).truncate().truncate())));
        }
        mesh.colours.extend(attributes.colour.as_ref().map(|accessor| {
            let colour = vector(accessor).clamp(Vec4::ZERO, Vec4::ONE);
            if accessor.width == 4 { colour } else { colour.truncate().extend(1.0) }
        }));
        let vertex = self.vertices.len() as u32;
        self.vertices.insert(index, vertex);
        vertex
    }
}
