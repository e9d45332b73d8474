//! A bounding volume hierarchy over objects that rays meet in closed form.
//!
//! Idea: boxes in boxes, of which a ray skips those that it misses or meets only beyond what it has met (Rubin and Whitted 1980;
//! halved at the median along the longest axis). The nodes stand in depth-first order and each says where to go on when it is
//! skipped, so that a traversal needs no stack (Smits 1998, "Efficiency issues for ray tracing"): the same few lines on the
//! CPU, eight rays together, and in WGSL, where the nodes are numbers and any number of objects the same code.
//!
//! It answers a second question: how near is the nearest of them, by the distances to the boxes. Cost: two boxes for each shape in
//! memory, O(n log² n) to build; a traversal visits some tens of nodes for a thousand shapes.

use super::{Batch, Field};
use crate::bounds::Aabb;
use crate::number::Vec3;

/// Objects of closed form from which on they stand in a hierarchy: what is fewer is met sooner one by one.
pub(super) const LEAST: usize = 48;

/// A box, and the leaf in it or the boxes behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) bounds: Aabb,
    /// The node after all that is in this one.
    pub(crate) skip: u32,
    /// The leaf, if it is no box of boxes.
    pub(crate) leaf: Option<u32>,
}

/// Nodes in depth-first order; none where there are few objects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    pub(crate) nodes: Vec<Node>,
}

impl Bvh {
    /// Over leaves and their boxes.
    pub(super) fn new(mut leaves: Vec<(u32, Aabb)>) -> Self {
        let mut bvh = Self { nodes: Vec::with_capacity(2 * leaves.len()) };
        bvh.add(&mut leaves);
        bvh
    }

    pub(crate) fn leaves(&self) -> impl Iterator<Item = u32> {
        self.nodes.iter().filter_map(|node| node.leaf)
    }

    fn add(&mut self, leaves: &mut [(u32, Aabb)]) {
        let Some(&(leaf, _)) = leaves.first() else { return };
        let bounds = leaves.iter().fold(Aabb::NOTHING, |all, (_, bounds)| all.union(*bounds));
        let place = self.nodes.len();
        self.nodes.push(Node { bounds, skip: 0, leaf: (leaves.len() == 1).then_some(leaf) });
        if leaves.len() > 1 {
            let size = |axis: &usize| bounds.max[*axis] - bounds.min[*axis];
            let axis = (0..3).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or_default();
            let middle = |(_, bounds): &(u32, Aabb)| bounds.min[axis] + bounds.max[axis];
            let half = leaves.len() / 2;
            leaves.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
            let (before, after) = leaves.split_at_mut(half);
            self.add(before);
            self.add(after);
        }
        self.nodes[place].skip = self.nodes.len() as u32;
    }

    /// The first hit of each ray: metres and leaf, or what it has met before.
    pub(super) fn hit<N: Batch>(&self, field: &Field, origin: Vec3<N>, direction: Vec3<N>, before: (N, N)) -> (N, N) {
        if self.nodes.is_empty() {
            return before;
        }
        let (mut nearest, mut met) = before;
        let inverse = [direction.x, direction.y, direction.z].map(|d| {
            let tiny = N::constant(1e-12);
            N::one() / N::select(d.abs().lt(tiny), tiny, d)
        });
        let mut place = 0;
        while let Some(node) = self.nodes.get(place) {
            let mut enters = N::zero();
            let mut leaves = nearest;
            for (axis, o) in [origin.x, origin.y, origin.z].into_iter().enumerate() {
                let a = (N::constant(node.bounds.min[axis]) - o) * inverse[axis];
                let b = (N::constant(node.bounds.max[axis]) - o) * inverse[axis];
                enters = enters.max(a.min(b));
                leaves = leaves.min(a.max(b));
            }
            // A box may be flat.
            if !N::any(enters.lt(leaves + leaves.abs() * N::constant(1e-6) + N::constant(1e-30))) {
                place = node.skip as usize;
                continue;
            }
            if let Some(leaf) = node.leaf {
                let t = field.leaves[leaf as usize].ray(origin, direction);
                met = N::select(t.lt(nearest), N::constant(leaf as f32), met);
                nearest = nearest.min(t);
            }
            place += 1;
        }
        (nearest, met)
    }

    /// The distance to the nearest surface of the leaves that count, or what is nearer; the leaf `own` does not count.
    pub(super) fn distance<N: Batch>(
        &self,
        field: &Field,
        p: Vec3<N>,
        before: N,
        counts: impl Fn(u32) -> bool,
        own: N,
    ) -> N {
        let mut nearest = before;
        let mut place = 0;
        while let Some(node) = self.nodes.get(place) {
            let beyond = |axis: usize, p: N| {
                let (a, b) = (N::constant(node.bounds.min[axis]) - p, p - N::constant(node.bounds.max[axis]));
                a.max(b).max(N::zero())
            };
            let away = Vec3::new(beyond(0, p.x), beyond(1, p.y), beyond(2, p.z));
            if !N::any(away.length().lt(nearest)) {
                place = node.skip as usize;
                continue;
            }
            if let Some(leaf) = node.leaf.filter(|&leaf| counts(leaf)) {
                let distance = field.leaves[leaf as usize].distance(p).abs();
                let is_own = (own - N::constant(leaf as f32)).abs().lt(N::constant(0.5));
                nearest = N::select(is_own, nearest, nearest.min(distance));
            }
            place += 1;
        }
        nearest
    }
}
