//! Bounding volume hierarchy over analytic objects.
//!
//! Idea: a ray skips the boxes that it misses or enters only behind its nearest hit (Rubin and Whitted 1980; split at the
//! median along the longest axis). The nodes are in depth-first order, and each has the index of the node after its subtree,
//! so that traversal needs no stack (Smits 1998, "Efficiency issues for ray tracing"). The CPU runs the same few lines for
//! eight rays together; in WGSL the nodes are parameters, and the code is the same for any number of objects.
//!
//! The hierarchy also finds the distance to the nearest object. Cost: two boxes for each shape in memory, O(n log² n) to
//! build; a traversal visits some tens of nodes for a thousand shapes.

use super::{Batch, Field};
use crate::bounds::Aabb;
use crate::number::Vec3;

/// Least number of analytic objects for a hierarchy; fewer are intersected faster one by one.
pub(super) const MIN_OBJECTS: usize = 48;

/// Node: a bounding box with one leaf, or an inner node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) bounds: Aabb,
    /// Index of the node after this subtree.
    pub(crate) skip: u32,
    /// Leaf of the field; absent for an inner node.
    pub(crate) leaf: Option<u32>,
}

/// Nodes in depth-first order; none if there are few objects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    pub(crate) nodes: Vec<Node>,
}

impl Bvh {
    /// Builds the hierarchy over leaves and their bounds.
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
        let index = self.nodes.len();
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
        self.nodes[index].skip = self.nodes.len() as u32;
    }

    /// Nearest hit of each ray, metres and leaf; or the one found before, if that is nearer.
    pub(super) fn hit<N: Batch>(&self, field: &Field, origin: Vec3<N>, direction: Vec3<N>, before: (N, N)) -> (N, N) {
        if self.nodes.is_empty() {
            return before;
        }
        let (mut nearest, mut hit_leaf) = before;
        let inverse = inverse(direction);
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            if !enters(node.bounds, origin, inverse, nearest) {
                index = node.skip as usize;
                continue;
            }
            if let Some(leaf) = node.leaf {
                let t = field.leaves[leaf as usize].ray(origin, direction);
                hit_leaf = N::select(t.lt(nearest), N::constant(leaf as f32), hit_leaf);
                nearest = nearest.min(t);
            }
            index += 1;
        }
        (nearest, hit_leaf)
    }

    /// Distance to the nearest surface of the included leaves except `ignored_leaf`; or the one found before, if that is less.
    pub(super) fn distance<N: Batch>(
        &self,
        field: &Field,
        p: Vec3<N>,
        before: N,
        is_included: impl Fn(u32) -> bool,
        ignored_leaf: N,
    ) -> N {
        let mut nearest = before;
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let beyond = |axis: usize, p: N| {
                let (a, b) = (N::constant(node.bounds.min[axis]) - p, p - N::constant(node.bounds.max[axis]));
                a.max(b).max(N::zero())
            };
            let away = Vec3::new(beyond(0, p.x), beyond(1, p.y), beyond(2, p.z));
            if !N::any(away.length().lt(nearest)) {
                index = node.skip as usize;
                continue;
            }
            if let Some(leaf) = node.leaf.filter(|&leaf| is_included(leaf)) {
                let distance = field.leaves[leaf as usize].distance(p).abs();
                let is_ignored = (ignored_leaf - N::constant(leaf as f32)).abs().lt(N::constant(0.5));
                nearest = N::select(is_ignored, nearest, nearest.min(distance));
            }
            index += 1;
        }
        nearest
    }
}

/// One over each component of a direction; finite.
#[inline(always)]
pub(super) fn inverse<N: Batch>(direction: Vec3<N>) -> [N; 3] {
    [direction.x, direction.y, direction.z].map(|d| {
        let tiny = N::constant(1e-12);
        N::one() / N::select(d.abs().lt(tiny), tiny, d)
    })
}

/// Reports whether any ray enters a box before its nearest hit. `inverse` is that of the direction.
#[inline(always)]
pub(super) fn enters<N: Batch>(bounds: Aabb, origin: Vec3<N>, inverse: [N; 3], nearest: N) -> bool {
    let mut enters = N::zero();
    let mut leaves = nearest;
    for (axis, o) in [origin.x, origin.y, origin.z].into_iter().enumerate() {
        let a = (N::constant(bounds.min[axis]) - o) * inverse[axis];
        let b = (N::constant(bounds.max[axis]) - o) * inverse[axis];
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    // The margin keeps flat boxes.
    N::any(enters.lt(leaves + leaves.abs() * N::constant(1e-6) + N::constant(1e-30)))
}
