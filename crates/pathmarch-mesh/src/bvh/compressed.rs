//! Compressed wide hierarchy for GPUs, as flat arrays.
//!
//! **Idea.** Eight children share an origin and a power of two for each axis; their boxes are 8-bit multiples of it, rounded
//! outwards. Children are placed in the slots of their octants, so that `slot ^ octant of the ray` orders them from near to far
//! without sorting (Ylitie et al. 2017).
//!
//! A node is [`NODE_WORDS`] words:
//!
//! | Word | Contents |
//! |---|---|
//! | 0 to 2 | origin, bits of 32-bit floats |
//! | 3 | biased exponents of x, y and z; mask of slots with inner nodes |
//! | 4, 5 | index of the first inner child; index of the first triangle |
//! | 6, 7 | meta byte of each slot |
//! | 8 to 13 | least x, y and z of each slot |
//! | 14 to 19 | greatest x, y and z of each slot |
//!
//! Bytes are in little-endian order. A meta byte is zero for an empty slot. Of an inner node it is `0x20 + 24 + slot`; its index
//! is the first inner child's plus the number of mask bits below the slot. Of a leaf, the upper three bits count one to three
//! triangles in unary, the lower five are the offset of the first one.
//!
//! **Differences.** Children are assigned to slots greedily. Boxes are decoded as `origin + q * 2^e`, for which they are verified;
//! a kernel that decodes otherwise must widen them. [`CompressedBvh::intersect`] is a plain traversal, the oracle of kernels.
//!
//! **Cost.** 53 bytes a triangle for a million, of which 40 are corners and index.

use super::binary::{BinaryBvh, LeafRule, Node};
use super::collapse::Children;
use super::ray::Ray;
use super::traverse::Hit;
use super::watertight::RayShear;
use super::{BuildError, check};
use crate::bounds::Bounds;
use crate::triangle_mesh::TriangleMesh;
use glam::Vec3;

/// Words of a node.
pub const NODE_WORDS: usize = 20;
/// First word of the boxes.
const BOXES: usize = 8;
/// Word of the meta bytes.
const META: usize = 6;

/// Leaves have at most three triangles, so that 24 offsets fit into five bits.
const LEAVES: LeafRule = LeafRule { max_triangles: 3, split_below: 0.8 };

/// Hierarchy of compressed wide nodes over the triangles of a mesh.
#[derive(Clone, Debug, Default)]
pub struct CompressedBvh {
    /// Nodes of [`NODE_WORDS`] words, the root first; empty if there are no triangles.
    pub nodes: Vec<u32>,
    /// Nine coordinates of each triangle, in the order of the leaves.
    pub corners: Vec<f32>,
    /// Index in the mesh of each triangle, in the order of the leaves.
    pub triangles: Vec<u32>,
}

impl CompressedBvh {
    /// Builds the hierarchy.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn build(mesh: &TriangleMesh) -> Result<Self, BuildError> {
        check(mesh)?;
        let tree = BinaryBvh::build(mesh.triangles.len(), |triangle| mesh.corners(triangle), LEAVES);
        let mut compressed = Self::default();
        if !tree.order.is_empty() {
            compressed.encode(&tree, mesh);
        }
        Ok(compressed)
    }

    /// Number of levels of nodes; zero without triangles. A traversal that keeps the rest of each node on its stack needs as
    /// many entries.
    pub fn depth(&self) -> usize {
        let mut level = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        let mut depth = 0;
        while !level.is_empty() {
            let children = |index: usize| {
                let node = self.node(index);
                (0..8).filter_map(move |slot| node.inner_child(slot))
            };
            level = level.into_iter().flat_map(children).collect();
            depth += 1;
        }
        depth
    }

    /// Bytes in use.
    pub fn size_in_bytes(&self) -> usize {
        4 * (self.nodes.len() + self.corners.len() + self.triangles.len())
    }

    fn encode(&mut self, tree: &BinaryBvh, mesh: &TriangleMesh) {
        let mut parents = vec![0];
        let mut next = 0;
        while next < parents.len() {
            let parent = &tree.nodes[parents[next] as usize];
            let slots = assign_slots(tree, parent.bounds, Children::of(tree, parents[next]).as_slice());
            let mut words = [0; NODE_WORDS];
            words[4] = parents.len() as u32;
            words[5] = self.triangles.len() as u32;
            let frame = Frame::new(parent.bounds);
            frame.write(&mut words);
            for (slot, child) in slots.into_iter().enumerate().filter_map(|(slot, child)| Some((slot, child?))) {
                let node = &tree.nodes[child as usize];
                frame.write_box(&mut words, slot, node.bounds);
                let meta = if node.is_leaf() {
                    let offset = self.triangles.len() as u32 - words[5];
                    self.push_triangles(tree, mesh, node);
                    ((1 << node.count) - 1) << 5 | offset
                } else {
                    parents.push(child);
                    words[3] |= 1 << (24 + slot);
                    0x20 + 24 + slot as u32
                };
                set_byte(&mut words, META, slot, meta as u8);
            }
            self.nodes.extend(words);
            next += 1;
        }
    }

    fn push_triangles(&mut self, tree: &BinaryBvh, mesh: &TriangleMesh, leaf: &Node) {
        for &triangle in &tree.order[leaf.first as usize..(leaf.first + leaf.count) as usize] {
            self.triangles.push(triangle);
            self.corners.extend(mesh.corners(triangle as usize).iter().flat_map(Vec3::to_array));
        }
    }

    /// Closest hit of a ray with t_min < t < t_max, on either side of a triangle.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let shear = RayShear::new(ray);
        let octant = (0..3).fold(0, |octant, axis| octant | usize::from(ray.direction[axis] < 0.0) << axis);
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = stack.pop() {
            let node = self.node(index);
            // The nearest slot is pushed last.
            for slot in (0..8).rev().map(|order| order ^ octant) {
                let t_max = closest.map_or(ray.t_max, |hit| hit.t);
                if !node.child_bounds(slot).is_some_and(|bounds| is_passed(bounds, ray, t_max)) {
                    continue;
                }
                match node.child(slot) {
                    Child::Inner(child) => stack.push(child),
                    Child::Leaf { first, count } => {
                        for at in first..first + count {
                            let t_max = closest.map_or(ray.t_max, |hit| hit.t);
                            let hit = shear.intersect(self.corners_at(at), ray.t_min, t_max);
                            let hit =
                                hit.map(|(t, barycentrics)| Hit { t, triangle: self.triangles[at], barycentrics });
                            closest = hit.or(closest);
                        }
                    }
                }
            }
        }
        closest
    }

    fn node(&self, index: usize) -> Decoder<'_> {
        Decoder { words: &self.nodes[NODE_WORDS * index..NODE_WORDS * (index + 1)] }
    }

    fn corners_at(&self, triangle: usize) -> [Vec3; 3] {
        let corners = &self.corners[9 * triangle..9 * (triangle + 1)];
        [0, 3, 6].map(|first| Vec3::from_slice(&corners[first..]))
    }
}

/// Slot of each child: that of its octant, as far as it is free.
fn assign_slots(tree: &BinaryBvh, parent: Bounds, children: &[u32]) -> [Option<u32>; 8] {
    let mut slots = [None; 8];
    let mut rest: Vec<(u32, Vec3)> =
        children.iter().map(|&child| (child, tree.nodes[child as usize].bounds.centre() - parent.centre())).collect();
    while !rest.is_empty() {
        let mut best = (f32::NEG_INFINITY, 0, 0);
        for (place, (_, offset)) in rest.iter().enumerate() {
            for (slot, _) in slots.iter().enumerate().filter(|(_, taken)| taken.is_none()) {
                let side = |axis: usize| if slot >> axis & 1 == 1 { 1.0 } else { -1.0 };
                let gain = offset.dot(Vec3::new(side(0), side(1), side(2)));
                if gain > best.0 {
                    best = (gain, place, slot);
                }
            }
        }
        slots[best.2] = Some(rest.swap_remove(best.1).0);
    }
    slots
}

/// Origin and scale of a node's boxes.
struct Frame {
    origin: Vec3,
    exponents: [u32; 3],
}

impl Frame {
    fn new(bounds: Bounds) -> Self {
        let exponent = |axis: usize| {
            let fits = |exponent: &u32| bounds.min[axis] + 255.0 * scale(*exponent) >= bounds.max[axis];
            // One step below the quotient's own exponent, in case that is enough.
            let quotient = (bounds.max[axis] - bounds.min[axis]) / 255.0;
            let start = (quotient.to_bits() >> 23).max(1);
            (start..255).find(fits).unwrap_or(254)
        };
        Self { origin: bounds.min, exponents: [0, 1, 2].map(exponent) }
    }

    fn write(&self, words: &mut [u32; NODE_WORDS]) {
        for axis in 0..3 {
            words[axis] = self.origin[axis].to_bits();
            words[3] |= self.exponents[axis] << (8 * axis);
        }
    }

    /// Writes a box, rounded outwards as it is decoded.
    fn write_box(&self, words: &mut [u32; NODE_WORDS], slot: usize, bounds: Bounds) {
        for axis in 0..3 {
            let scale = scale(self.exponents[axis]);
            let decoded = |q: u8| self.origin[axis] + f32::from(q) * scale;
            let relative = |v: f32| (v - self.origin[axis]) / scale;
            let mut low = relative(bounds.min[axis]).floor() as u8;
            while low > 0 && decoded(low) > bounds.min[axis] {
                low -= 1;
            }
            let mut high = relative(bounds.max[axis]).ceil() as u8;
            while high < 255 && decoded(high) < bounds.max[axis] {
                high += 1;
            }
            set_byte(words, BOXES + 2 * axis, slot, low);
            set_byte(words, BOXES + 6 + 2 * axis, slot, high);
        }
    }
}

/// Power of two with a biased exponent.
fn scale(exponent: u32) -> f32 {
    f32::from_bits(exponent << 23)
}

fn set_byte(words: &mut [u32; NODE_WORDS], first: usize, slot: usize, byte: u8) {
    words[first + slot / 4] |= u32::from(byte) << (8 * (slot % 4));
}

/// Target of a slot.
enum Child {
    Inner(usize),
    Leaf { first: usize, count: usize },
}

/// View of a node's words.
struct Decoder<'a> {
    words: &'a [u32],
}

impl Decoder<'_> {
    fn byte(&self, first: usize, slot: usize) -> u32 {
        self.words[first + slot / 4] >> (8 * (slot % 4)) & 0xff
    }

    /// Box of a slot that is not empty.
    fn child_bounds(&self, slot: usize) -> Option<Bounds> {
        let corner = |first: usize| {
            Vec3::from_array([0, 1, 2].map(|axis| {
                let scale = scale(self.words[3] >> (8 * axis) & 0xff);
                f32::from_bits(self.words[axis]) + self.byte(first + 2 * axis, slot) as f32 * scale
            }))
        };
        (self.byte(META, slot) != 0).then(|| Bounds { min: corner(BOXES), max: corner(BOXES + 6) })
    }

    /// Index of the inner node of a slot.
    fn inner_child(&self, slot: usize) -> Option<usize> {
        match self.child(slot) {
            Child::Inner(child) if self.byte(META, slot) != 0 => Some(child),
            _ => None,
        }
    }

    fn child(&self, slot: usize) -> Child {
        let (mask, meta) = (self.words[3] >> 24, self.byte(META, slot));
        if mask >> slot & 1 == 1 {
            let before = (mask & ((1 << slot) - 1)).count_ones();
            Child::Inner((self.words[4] + before) as usize)
        } else {
            let first = self.words[5] + (meta & 31);
            Child::Leaf { first: first as usize, count: (meta >> 5).count_ones() as usize }
        }
    }
}

/// Conservative test of a ray against a box (Ize 2013), by one axis after the other.
fn is_passed(bounds: Bounds, ray: &Ray, t_max: f32) -> bool {
    let (mut enter, mut leave) = (ray.t_min, t_max);
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        if direction == 0.0 {
            if origin < bounds.min[axis] || origin > bounds.max[axis] {
                return false;
            }
            continue;
        }
        let planes = [bounds.min[axis], bounds.max[axis]].map(|plane| (plane - origin) / direction);
        enter = enter.max(planes[0].min(planes[1]));
        leave = leave.min(planes[0].max(planes[1]) * (1.0 + 6.0 * f32::EPSILON));
    }
    enter <= leave
}
