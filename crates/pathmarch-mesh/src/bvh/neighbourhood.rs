//! Nearest triangles of many points in a box.
//!
//! **Idea.** Points that are close together have the same few candidates. The nodes that may have the nearest triangle of any
//! point of a box are found once, and each point tests only those, eight at once, instead of starting at the root.
//! **Cost.** A distance grid takes some 7 % less time than with a search from the root for each sample.

use super::closest::{Nearest, Search};
use super::{Bvh, LEAF, WideNode};
use crate::bounds::Bounds;
use glam::Vec3;
use wide::f32x8;

/// Nodes and leaves beyond which no node is replaced by its children.
const MAX_ENTRIES: usize = 256;
/// Factor of distances that makes up for their rounding.
const ROUNDING: f32 = 1.0001;

/// Part of a hierarchy that may have the nearest triangle of any point of a box.
pub(crate) struct Neighbourhood<'b> {
    bvh: &'b Bvh,
    /// Nodes and leaves, in eights.
    groups: Vec<WideNode>,
}

impl<'b> Neighbourhood<'b> {
    /// The whole hierarchy.
    pub fn new(bvh: &'b Bvh) -> Self {
        Self { bvh, groups: bvh.nodes.first().copied().into_iter().collect() }
    }

    /// Keeps what may have the nearest triangle of a point of a smaller box.
    pub fn narrowed(&self, bounds: Bounds, guess: Option<Nearest>) -> Self {
        let centre = bounds.centre();
        // No point's nearest triangle is farther away than the way over the centre.
        let to_centre = self.nearest(centre, guess).map_or(0.0, |nearest| nearest.squared_distance.sqrt());
        let reach = ROUNDING * (to_centre + centre.distance(bounds.max)) + f32::MIN_POSITIVE;
        let (mut open, mut kept) = (Vec::with_capacity(MAX_ENTRIES), Vec::with_capacity(MAX_ENTRIES));
        for node in &self.groups {
            push_near_children(&mut open, node, bounds, reach);
        }
        while let Some(entry) = open.pop() {
            if entry.link & LEAF == 0 && open.len() + kept.len() < MAX_ENTRIES {
                push_near_children(&mut open, &self.bvh.nodes[entry.link as usize], bounds, reach);
            } else {
                kept.push(entry);
            }
        }
        Self { bvh: self.bvh, groups: kept.chunks(8).map(group).collect() }
    }

    /// Nearest triangle of a point of the box. `guess`, such as the result for a point nearby, makes the search shorter.
    #[inline]
    pub fn nearest(&self, p: Vec3, guess: Option<Nearest>) -> Option<Nearest> {
        let mut search = Search::new(self.bvh, p, f32::INFINITY);
        if let Some(guess) = guess {
            search.start_with(guess);
        }
        for group in &self.groups {
            search.visit_children(group);
        }
        search.nearest
    }
}

/// Node or leaf, with its box.
struct Entry {
    link: u32,
    bounds: Bounds,
}

/// Appends the children of a node that are within a distance of a box.
#[inline(always)]
fn push_near_children(open: &mut Vec<Entry>, node: &WideNode, bounds: Bounds, reach: f32) {
    let gap = |axis: usize| {
        let (low, high) = (f32x8::splat(bounds.min[axis]), f32x8::splat(bounds.max[axis]));
        (node.min[axis] - high).fast_max(low - node.max[axis]).fast_max(f32x8::ZERO)
    };
    let gaps = [gap(0), gap(1), gap(2)];
    let squared = gaps[0].mul_add(gaps[0], gaps[1].mul_add(gaps[1], gaps[2] * gaps[2]));
    let mut mask = squared.simd_le(f32x8::splat(reach * reach)).to_bitmask();
    let corner =
        |planes: &[f32x8; 3], slot: usize| Vec3::from([0, 1, 2].map(|axis: usize| planes[axis].as_array()[slot]));
    while mask != 0 {
        let slot = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        let bounds = Bounds { min: corner(&node.min, slot), max: corner(&node.max, slot) };
        open.push(Entry { link: node.children[slot], bounds });
    }
}

/// Packs up to eight entries. Unused lanes have boxes that are infinitely far away.
fn group(entries: &[Entry]) -> WideNode {
    let mut boxes = [[[f32::INFINITY; 8]; 3], [[f32::NEG_INFINITY; 8]; 3]];
    let mut links = [0; 8];
    for (slot, entry) in entries.iter().enumerate() {
        links[slot] = entry.link;
        for (planes, corner) in boxes.iter_mut().zip([entry.bounds.min, entry.bounds.max]) {
            for (plane, coordinate) in planes.iter_mut().zip(corner.to_array()) {
                plane[slot] = coordinate;
            }
        }
    }
    let [min, max] = boxes.map(|corner| corner.map(f32x8::from));
    WideNode { min, max, children: links }
}
