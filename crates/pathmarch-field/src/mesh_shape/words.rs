//! Encoding of meshes as words of a buffer, which `triangles.wgsl` and `grid.wgsl` decode.
//!
//! Each surface and each grid is encoded once, however many leaves use it. Offsets count words from the start of the buffer.

use super::{AlphaTest, AlphaTexture, MeshGeometry, MeshOpacity, MeshSurface};
use crate::bounds::Aabb;
use crate::graph::Leaf;
use pathmarch_mesh::{DistanceGrid, GridArrays};
use std::fmt::Write;
use std::sync::Arc;

/// Words of the header: first and last top-level node, and the table of leaves.
const HEADER_WORDS: usize = 4;
/// Words of a top-level node: least corner, the node behind its subtree, greatest corner, its instance or zero.
const NODE_WORDS: usize = 8;

/// Words of the opacity of a material: flags, alpha, cutoff, texture or zero.
const OPACITY_WORDS: usize = 4;

/// Constants of the encoding in WGSL.
pub(crate) fn constants_wgsl() -> String {
    let mut text = String::new();
    for (name, value) in [
        ("MESH_STACK", super::surface::MAX_DEPTH as u32),
        ("MESH_NODE_WORDS", pathmarch_mesh::bvh::NODE_WORDS as u32),
        ("TOP_NODE_WORDS", NODE_WORDS as u32),
        ("OPACITY_WORDS", OPACITY_WORDS as u32),
    ] {
        writeln!(text, "const {name} = {value}u;").expect("writing to a string");
    }
    text
}

/// Constants of a grid in WGSL.
pub(crate) fn grid_constants_wgsl() -> String {
    let mut text = String::new();
    for (name, value) in [
        ("GRID_BLOCK", GridArrays::BLOCK),
        ("GRID_COARSE", GridArrays::COARSE),
        ("GRID_SIDE", GridArrays::SIDE),
        ("NO_BRICK", GridArrays::NO_BRICK),
    ] {
        writeln!(text, "const {name} = {value}u;").expect("writing to a string");
    }
    text
}

/// Words of all meshes of a field, and the grid of each leaf.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshWords {
    pub(crate) words: Vec<u32>,
    /// Offset of the grid of each leaf, in groups of four words; zero for other leaves.
    pub(crate) grids: Vec<u32>,
}

/// Node over instances of triangles.
pub(crate) struct TopNode {
    pub(crate) bounds: Aabb,
    /// Index of the node behind its subtree.
    pub(crate) skip: u32,
    /// Leaf of an instance.
    pub(crate) leaf: Option<u32>,
}

impl MeshWords {
    /// Encodes the meshes of a field; no words if there are none. `modifier` is the index of the modifier around a leaf, and `nodes`
    /// the hierarchy over all instances of triangles. Without `has_all_grids`, only fields have a grid.
    pub(crate) fn new(
        leaves: &[Leaf],
        modifier: impl Fn(usize) -> u32,
        nodes: impl Iterator<Item = TopNode>,
        has_all_grids: bool,
    ) -> Self {
        let mut encoder = Encoder::default();
        if leaves.iter().all(|leaf| leaf.shape.mesh().is_none()) {
            return Self::default();
        }
        encoder.words.resize(HEADER_WORDS + leaves.len(), 0);
        encoder.words[2] = HEADER_WORDS as u32;
        let mut grids = vec![0; leaves.len()];
        for (index, leaf) in leaves.iter().enumerate() {
            let Some(mesh) = leaf.shape.mesh() else { continue };
            if has_all_grids || !mesh.is_triangles() {
                grids[index] = encoder.grid(mesh.grid());
            }
            let first = index - leaf.slot as usize;
            let instance = match leaf.slot {
                0 => encoder.instance(mesh, leaf, [index as u32, grids[index], modifier(index)]),
                _ => encoder.words[HEADER_WORDS + first],
            };
            encoder.words[HEADER_WORDS + index] = instance;
        }
        encoder.top_level(nodes);
        Self { words: encoder.words, grids }
    }
}

#[derive(Default)]
struct Encoder {
    words: Vec<u32>,
    surfaces: Vec<(Arc<MeshSurface>, u32)>,
    grids: Vec<(Arc<DistanceGrid>, u32)>,
    opacities: Vec<(Arc<MeshOpacity>, u32)>,
}

impl Encoder {
    fn floats(&mut self, values: impl IntoIterator<Item = f32>) {
        self.words.extend(values.into_iter().map(f32::to_bits));
    }

    /// Writes the nodes over all instances of triangles.
    fn top_level(&mut self, nodes: impl Iterator<Item = TopNode>) {
        let first = self.words.len();
        for node in nodes {
            let instance = node.leaf.map_or(0, |leaf| self.words[HEADER_WORDS + leaf as usize]);
            self.floats(node.bounds.min);
            self.words.push((first + NODE_WORDS * node.skip as usize) as u32);
            self.floats(node.bounds.max);
            self.words.push(instance);
        }
        (self.words[0], self.words[1]) = (first as u32, self.words.len() as u32);
    }

    /// Encodes a placed mesh: its pose, its surface, its first leaf, its number of materials, its grid, the modifier around it, its
    /// opacity and its clearance.
    fn instance(&mut self, mesh: &MeshGeometry, leaf: &Leaf, [index, grid, modifier]: [u32; 3]) -> u32 {
        let surface = self.surface(mesh.surface());
        let offset = self.words.len() as u32;
        self.floats(leaf.pose.at);
        self.floats([leaf.pose.scale]);
        self.floats(leaf.pose.local_from_world().as_flattened().iter().copied());
        self.words.extend([surface, index, mesh.tags().len().max(1) as u32, grid, modifier]);
        let opacity_word = self.words.len();
        self.words.push(0);
        self.floats([leaf.clearance()]);
        self.words[opacity_word] = mesh.opacity().map_or(0, |opacity| self.opacity(opacity));
        offset
    }

    /// Encodes the opacity of the materials of a mesh: flags, alpha, cutoff and texture of each.
    fn opacity(&mut self, opacity: &Arc<MeshOpacity>) -> u32 {
        if let Some((_, offset)) = self.opacities.iter().find(|(known, _)| Arc::ptr_eq(known, opacity)) {
            return *offset;
        }
        let offset = self.words.len();
        self.words.resize(offset + OPACITY_WORDS * opacity.materials.len(), 0);
        for (index, material) in opacity.materials.iter().enumerate() {
            let (test, cutoff) = match material.test {
                AlphaTest::Opaque => (0, 0.0),
                AlphaTest::Mask(cutoff) => (1, cutoff),
                AlphaTest::Blend => (2, 0.0),
            };
            let texture = material.texture.as_ref().map_or(0, |texture| self.alpha_texture(texture));
            let record =
                [test | u32::from(material.is_single_sided) << 2, material.alpha.to_bits(), cutoff.to_bits(), texture];
            let at = offset + OPACITY_WORDS * index;
            self.words[at..at + OPACITY_WORDS].copy_from_slice(&record);
        }
        self.opacities.push((Arc::clone(opacity), offset as u32));
        offset as u32
    }

    /// Encodes a texture of alpha: width, height, modes, two rows of its transform, and four texels a word.
    fn alpha_texture(&mut self, texture: &AlphaTexture) -> u32 {
        let offset = self.words.len() as u32;
        let modes = texture.wrap[0].code()
            | texture.wrap[1].code() << 2
            | u32::from(texture.is_nearest) << 4
            | (texture.uv_set as u32) << 5;
        self.words.extend([texture.width, texture.height, modes]);
        self.floats(texture.rows.as_flattened().iter().copied());
        let word = |texels: &[u8]| texels.iter().rev().fold(0, |word, &texel| word << 8 | u32::from(texel));
        self.words.extend(texture.texels.chunks(4).map(word));
        offset
    }

    fn surface(&mut self, surface: &Arc<MeshSurface>) -> u32 {
        if let Some((_, offset)) = self.surfaces.iter().find(|(known, _)| Arc::ptr_eq(known, surface)) {
            return *offset;
        }
        let (mesh, bvh, bounds) = (surface.mesh(), surface.compressed(), surface.mesh_bounds());
        let nodes = self.append(bvh.nodes.iter().copied());
        let corners = self.append(bvh.corners.iter().map(|v| v.to_bits()));
        let in_order = || bvh.triangles.iter().map(|&triangle| triangle as usize);
        let vertices = self.append(in_order().flat_map(|triangle| mesh.triangles[triangle]));
        let normals = self.append(mesh.normals.iter().flat_map(|n| n.to_array()).map(f32::to_bits));
        let uvs = [0, 1].map(|set| self.append(mesh.uvs[set].iter().flat_map(|uv| uv.to_array()).map(f32::to_bits)));
        let materials = match mesh.materials.is_empty() {
            true => 0,
            false => self.append(in_order().map(|triangle| mesh.material(triangle))),
        };
        let snorm = |v: f32| u32::from((v.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
        let unorm = |v: f32| (v.clamp(0.0, 1.0) * 65535.0).round() as u32;
        let pairs = |[x, y, z, w]: [u32; 4]| [x | y << 16, z | w << 16];
        let tangents = self.append(mesh.tangents.iter().flat_map(|t| pairs(t.to_array().map(snorm))));
        let colours = self.append(mesh.colours.iter().flat_map(|c| pairs(c.to_array().map(unorm))));
        let offset = self.words.len() as u32;
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        self.words.extend([nodes, corners, vertices, normals, uvs[0], uvs[1], materials, largest.to_bits()]);
        self.words.extend([tangents, colours]);
        self.surfaces.push((Arc::clone(surface), offset));
        offset
    }

    /// Appends an array; zero if it is empty.
    fn append(&mut self, array: impl IntoIterator<Item = u32>) -> u32 {
        let offset = self.words.len();
        self.words.extend(array);
        if self.words.len() > offset { offset as u32 } else { 0 }
    }

    /// Encodes a grid; returns its offset in groups of four words.
    fn grid(&mut self, grid: &Arc<DistanceGrid>) -> u32 {
        if let Some((_, offset)) = self.grids.iter().find(|(known, _)| Arc::ptr_eq(known, grid)) {
            return *offset;
        }
        let arrays = grid.arrays();
        let coarse = self.append(arrays.coarse.iter().map(|v| v.to_bits()));
        let blocks = self.append(arrays.bricks_of_blocks.iter().copied());
        let half = |v: &i16| u32::from(*v as u16);
        let pair = |pair: &[i16]| half(&pair[0]) | pair.get(1).map_or(0, half) << 16;
        let bricks = self.append(arrays.bricks.chunks(2).map(pair));
        self.words.resize(self.words.len().next_multiple_of(4), 0);
        let offset = (self.words.len() / 4) as u32;
        self.floats(arrays.origin.to_array());
        self.floats([arrays.voxel]);
        self.words.extend(arrays.blocks.to_array());
        self.floats([arrays.unit]);
        self.words.extend([coarse, blocks, bricks]);
        self.grids.push((Arc::clone(grid), offset));
        offset
    }
}
