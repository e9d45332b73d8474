//! Bounding volume hierarchies of triangles.
//!
//! **Idea.** [`Bvh`] has nodes of eight boxes, tested side by side (Wald et al. 2008), and leaves of up to eight triangles, tested
//! side by side, too. It finds the closest and any hit of a ray, and the closest point of the surface. [`CompressedBvh`] has the
//! same structure in the compact form that suits GPUs.
//!
//! | File | Contents |
//! |---|---|
//! | `binary.rs` | binned builder by the surface area heuristic |
//! | `collapse.rs` | collapse to eight children |
//! | `ray.rs`, `triangle8.rs` | watertight intersection of boxes and triangles |
//! | `traverse.rs`, `closest.rs` | rays; closest points |
//! | `neighbourhood.rs` | closest points of many points in a box |
//! | `compressed.rs` | compressed wide nodes |
//!
//! **Cost.** A million triangles are built in 1.2 CPU seconds and take 77 bytes each.

pub(crate) mod binary;
mod closest;
mod collapse;
mod compressed;
mod neighbourhood;
mod ray;
mod stack;
mod traverse;
mod triangle8;
mod watertight;

pub use closest::ClosestPoint;
pub(crate) use closest::Nearest;
pub use compressed::{CompressedBvh, NODE_WORDS};
pub(crate) use neighbourhood::Neighbourhood;
pub use ray::Ray;
pub use traverse::Hit;

use crate::bounds::Bounds;
use crate::triangle_mesh::{MAX_COORDINATE, TriangleMesh};
use binary::{BinaryBvh, LeafRule};
use collapse::Children;
use glam::Vec3;
use rayon::prelude::*;
use triangle8::{LANES, Triangle8};
use wide::f32x8;

/// Most triangles of a hierarchy.
pub const MAX_TRIANGLES: usize = 1 << 30;

/// Triangles that no hierarchy can be built of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// A triangle names a vertex that does not exist.
    #[error("triangle {0} names a vertex beyond the last; TriangleMesh::drop_unusable leaves such triangles out")]
    OutOfRange(usize),
    /// A coordinate is infinite, not a number, or beyond [`MAX_COORDINATE`].
    #[error(
        "triangle {0} has a coordinate that is not finite or beyond {MAX_COORDINATE:e}; \
         TriangleMesh::drop_unusable leaves such triangles out"
    )]
    NotFinite(usize),
    /// There are more than [`MAX_TRIANGLES`].
    #[error("{0} triangles are more than {MAX_TRIANGLES}; split the mesh")]
    TooMany(usize),
}

/// Checks that a hierarchy can be built of a mesh.
pub(crate) fn check(mesh: &TriangleMesh) -> Result<(), BuildError> {
    if mesh.triangles.len() > MAX_TRIANGLES {
        return Err(BuildError::TooMany(mesh.triangles.len()));
    }
    let is_usable = |p: &Vec3| p.abs().cmple(Vec3::splat(MAX_COORDINATE)).all();
    let mistake = |(index, triangle): (usize, &[u32; 3])| {
        let corners = triangle.map(|vertex| mesh.positions.get(vertex as usize));
        match corners {
            [Some(a), Some(b), Some(c)] if [a, b, c].into_iter().all(is_usable) => None,
            [Some(_), Some(_), Some(_)] => Some(BuildError::NotFinite(index)),
            _ => Some(BuildError::OutOfRange(index)),
        }
    };
    mesh.triangles.par_iter().enumerate().find_map_first(mistake).map_or(Ok(()), Err)
}

/// Bit of a child that marks a leaf; the others are the index of its block.
const LEAF: u32 = 1 << 31;

/// Eight boxes, and where they lead.
#[derive(Clone, Copy, Debug)]
struct WideNode {
    min: [f32x8; 3],
    max: [f32x8; 3],
    /// Index of a node, or [`LEAF`] and the index of a block. Unused children have boxes that no ray passes.
    children: [u32; 8],
}

/// Hierarchy over the triangles of a mesh. It has its own copy of their corners.
#[derive(Clone, Debug)]
pub struct Bvh {
    bounds: Bounds,
    nodes: Vec<WideNode>,
    blocks: Vec<Triangle8>,
}

/// Leaves fill a block of eight triangles unless halves have far less surface.
pub(crate) const LEAVES: LeafRule = LeafRule { max_triangles: LANES, split_below: 0.95 };

impl Bvh {
    /// Builds the hierarchy, on all cores of the current `rayon` pool. The result does not depend on their number.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build(mesh: &TriangleMesh) -> Result<Self, BuildError> {
        check(mesh)?;
        let tree = BinaryBvh::build(mesh.triangles.len(), |triangle| mesh.corners(triangle), LEAVES);
        Ok(Self::of_binary(&tree, mesh))
    }

    /// Collapses a binary hierarchy with leaves of up to eight triangles.
    pub(crate) fn of_binary(tree: &BinaryBvh, mesh: &TriangleMesh) -> Self {
        let mut bvh = Self { bounds: tree.nodes[0].bounds, nodes: Vec::new(), blocks: Vec::new() };
        if !tree.order.is_empty() {
            bvh.collapse(tree, mesh);
        }
        bvh
    }

    /// Bounds of all triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Bytes in use.
    pub fn size_in_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())
    }

    /// Makes the wide nodes, breadth first, so that the upper ones share cache lines.
    fn collapse(&mut self, tree: &BinaryBvh, mesh: &TriangleMesh) {
        let mut parents = vec![0];
        let mut next = 0;
        while next < parents.len() {
            let children = Children::of(tree, parents[next]);
            next += 1;
            let mut boxes = [[[f32::INFINITY; 8]; 3], [[f32::NEG_INFINITY; 8]; 3]];
            let mut links = [0; 8];
            for (slot, &child) in children.as_slice().iter().enumerate() {
                let node = &tree.nodes[child as usize];
                for (planes, corner) in boxes.iter_mut().zip([node.bounds.min, node.bounds.max]) {
                    for (plane, coordinate) in planes.iter_mut().zip(corner.to_array()) {
                        plane[slot] = coordinate;
                    }
                }
                links[slot] = if node.is_leaf() {
                    let triangles = &tree.order[node.first as usize..(node.first + node.count) as usize];
                    let with_corners = |&triangle: &u32| (triangle, mesh.corners(triangle as usize));
                    self.blocks.push(Triangle8::new(triangles.iter().map(with_corners)));
                    LEAF | (self.blocks.len() - 1) as u32
                } else {
                    parents.push(child);
                    (parents.len() - 1) as u32
                };
            }
            let [min, max] = boxes.map(|corner| corner.map(f32x8::from));
            self.nodes.push(WideNode { min, max, children: links });
        }
    }
}
