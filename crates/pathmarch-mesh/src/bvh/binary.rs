//! Binary bounding volume hierarchy, from which the wide ones are made.
//!
//! **Idea.** From the root down, a node is split where the surface area heuristic is least: its triangles are sorted into bins
//! along each axis by their centroids, and each boundary between bins is a candidate (Wald 2007). Both halves are built in
//! parallel. A subtree of n triangles has at most 2n - 1 nodes, so that each half knows where its nodes go; the result does not
//! depend on the number of cores.
//!
//! **Limits.** Below [`MAX_SAH_DEPTH`] nodes are halved by count, so that no input makes a tree deeper than that plus 32.
//!
//! **Cost.** A million triangles take about one CPU second; about 100 bytes a triangle while it is built.

use crate::bounds::Bounds;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Bins along each axis.
const BINS: usize = 16;
/// Depth from which nodes are halved by count.
const MAX_SAH_DEPTH: u32 = 56;
/// Triangles from which both halves of a node are built in parallel.
const PARALLEL_BUILD: usize = 2048;
/// Triangles from which binning is parallel.
const PARALLEL_BINNING: usize = 1 << 16;

/// Node of the hierarchy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub bounds: Bounds,
    /// First triangle in the order of the leaves.
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
    /// Index of the second child, the first being next to the node; zero for a leaf.
    pub second: u32,
}

impl Node {
    pub fn is_leaf(&self) -> bool {
        self.second == 0
    }

    const UNUSED: Self = Self { bounds: Bounds::EMPTY, first: 0, count: 0, second: 0 };
}

/// Nodes with the root first, and the triangles in the order of the leaves.
pub(crate) struct BinaryBvh {
    pub nodes: Vec<Node>,
    pub order: Vec<u32>,
}

/// Rule for leaves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeafRule {
    /// Largest number of triangles.
    pub max_triangles: usize,
    /// Such a set stays one leaf unless both halves together have less than this fraction of its surface area.
    pub split_below: f32,
}

/// Bounds of a triangle. The fourth lane of the least corner contains the bits of its index.
#[derive(Clone, Copy)]
struct Primitive {
    min: Vec4,
    max: Vec4,
}

impl Primitive {
    fn new(index: usize, corners: [Vec3; 3]) -> Self {
        let bounds = Bounds::of_points(corners);
        Self { min: bounds.min.extend(f32::from_bits(index as u32)), max: bounds.max.extend(0.0) }
    }
    fn index(&self) -> u32 {
        self.min.w.to_bits()
    }
    /// Twice the centroid of the bounds.
    fn centroid(&self) -> Vec4 {
        self.min + self.max
    }
}

/// Bounds with an ignored fourth lane, for SIMD.
#[derive(Clone, Copy)]
struct Box4 {
    min: Vec4,
    max: Vec4,
}

impl Box4 {
    const EMPTY: Self = Self { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    #[inline(always)]
    fn grow(&mut self, min: Vec4, max: Vec4) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }
    fn union(mut self, other: Self) -> Self {
        self.grow(other.min, other.max);
        self
    }
    /// Half the surface area; zero for an empty box.
    fn half_area(&self) -> f32 {
        half_area((self.max - self.min).truncate().max(Vec3::ZERO))
    }
    fn bounds(&self) -> Bounds {
        Bounds { min: self.min.truncate(), max: self.max.truncate() }
    }
}

/// Half the surface area of a box.
pub(crate) fn half_area(size: Vec3) -> f32 {
    size.x * size.y + size.y * size.z + size.z * size.x
}

/// Boundary between two halves of a node: an axis, and the first bin of the second half.
struct Split {
    axis: usize,
    bin: usize,
    /// Sum over both halves of half the surface area.
    area: f32,
}

impl BinaryBvh {
    /// Builds the hierarchy of some triangles, given their corners by index.
    pub fn build(count: usize, corners: impl Fn(usize) -> [Vec3; 3] + Sync, rule: LeafRule) -> Self {
        let primitive = |index: usize| Primitive::new(index, corners(index));
        let mut primitives: Vec<Primitive> = (0..count).into_par_iter().map(primitive).collect();
        let mut nodes = vec![Node::UNUSED; (2 * count).max(2) - 1];
        if count > 0 {
            let work = Subtree { index: 0, first: 0, depth: 0, rule };
            work.build(&mut nodes, &mut primitives);
        }
        Self { nodes, order: primitives.iter().map(Primitive::index).collect() }
    }
}

/// Position of a subtree in the arrays.
#[derive(Clone, Copy)]
struct Subtree {
    /// Index of its root.
    index: usize,
    /// First triangle in the order of the leaves.
    first: usize,
    depth: u32,
    rule: LeafRule,
}

impl Subtree {
    /// Builds a subtree into its slice of the nodes and sorts its triangles.
    fn build(self, nodes: &mut [Node], primitives: &mut [Primitive]) {
        let (bounds, centroids) = bounds_of(primitives);
        let count = primitives.len();
        let leaf = Node { bounds: bounds.bounds(), first: self.first as u32, count: count as u32, second: 0 };
        nodes[0] = leaf;
        if count == 1 {
            return;
        }
        let split = Binning::new(centroids).and_then(|binning| {
            let split = binning.best_split(primitives).filter(|_| self.depth < MAX_SAH_DEPTH)?;
            Some((binning, split))
        });
        if count <= self.rule.max_triangles {
            let is_worthwhile = |area: f32| area < self.rule.split_below * bounds.half_area();
            if !split.as_ref().is_some_and(|(_, split)| is_worthwhile(split.area)) {
                return;
            }
        }
        let middle = match split {
            Some((binning, split)) => partition(primitives, |p| binning.bin(p.centroid())[split.axis] < split.bin),
            None => count / 2,
        };
        let second = 2 * middle;
        nodes[0].second = (self.index + second) as u32;
        let (low, high) = primitives.split_at_mut(middle);
        let (low_nodes, high_nodes) = nodes[1..].split_at_mut(second - 1);
        let low_tree = Self { index: self.index + 1, depth: self.depth + 1, ..self };
        let high_tree = Self { index: self.index + second, first: self.first + middle, ..low_tree };
        if count > PARALLEL_BUILD {
            rayon::join(|| low_tree.build(low_nodes, low), || high_tree.build(high_nodes, high));
        } else {
            low_tree.build(low_nodes, low);
            high_tree.build(high_nodes, high);
        }
    }
}

/// Bounds of some triangles, and of their centroids.
fn bounds_of(primitives: &[Primitive]) -> (Box4, Box4) {
    let of_slice = |primitives: &[Primitive]| {
        primitives.iter().fold((Box4::EMPTY, Box4::EMPTY), |(mut bounds, mut centroids), primitive| {
            bounds.grow(primitive.min, primitive.max);
            centroids.grow(primitive.centroid(), primitive.centroid());
            (bounds, centroids)
        })
    };
    if primitives.len() < PARALLEL_BINNING {
        return of_slice(primitives);
    }
    let union = |a: (Box4, Box4), b: (Box4, Box4)| (a.0.union(b.0), a.1.union(b.1));
    primitives.par_chunks(PARALLEL_BINNING / 4).map(of_slice).reduce(|| (Box4::EMPTY, Box4::EMPTY), union)
}

/// Contents of a bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Box4,
    count: u32,
}

type Bins = [[Bin; BINS]; 3];
const NO_BINS: Bins = [[Bin { bounds: Box4::EMPTY, count: 0 }; BINS]; 3];

/// Mapping from centroids to bins.
struct Binning {
    low: Vec4,
    scale: Vec4,
}

impl Binning {
    /// Bins over the bounds of centroids; none if these are a point.
    fn new(centroids: Box4) -> Option<Self> {
        let size = (centroids.max - centroids.min).truncate();
        let scale = (0.999 * BINS as f32 / size).map(|scale| if scale.is_finite() { scale } else { 0.0 });
        (scale != Vec3::ZERO).then_some(Self { low: centroids.min, scale: scale.extend(0.0) })
    }

    #[inline(always)]
    fn bin(&self, centroid: Vec4) -> [usize; 3] {
        let bin = (centroid - self.low) * self.scale;
        [bin.x, bin.y, bin.z].map(|bin| (bin as usize).min(BINS - 1))
    }

    fn fill(&self, primitives: &[Primitive]) -> Bins {
        let mut bins = NO_BINS;
        for primitive in primitives {
            let index = self.bin(primitive.centroid());
            for (bins, index) in bins.iter_mut().zip(index) {
                bins[index].bounds.grow(primitive.min, primitive.max);
                bins[index].count += 1;
            }
        }
        bins
    }

    fn fill_parallel(&self, primitives: &[Primitive]) -> Bins {
        let chunks = primitives.par_chunks(PARALLEL_BINNING / 4).map(|primitives| self.fill(primitives));
        chunks.reduce(
            || NO_BINS,
            |mut bins, others| {
                for (bin, other) in bins.iter_mut().flatten().zip(others.iter().flatten()) {
                    *bin = Bin { bounds: bin.bounds.union(other.bounds), count: bin.count + other.count };
                }
                bins
            },
        )
    }

    /// The split with the least expected cost: the surface area of each half times its triangles.
    fn best_split(&self, primitives: &[Primitive]) -> Option<Split> {
        let is_large = primitives.len() >= PARALLEL_BINNING;
        let bins = if is_large { self.fill_parallel(primitives) } else { self.fill(primitives) };
        let mut best = (f32::INFINITY, None);
        for (axis, bins) in bins.iter().enumerate() {
            if self.scale[axis] == 0.0 {
                continue;
            }
            let mut above = [(0.0, 0.0); BINS];
            let (mut bounds, mut count) = (Box4::EMPTY, 0);
            for bin in (1..BINS).rev() {
                bounds = bounds.union(bins[bin].bounds);
                count += bins[bin].count;
                above[bin] = (bounds.half_area(), count as f32);
            }
            (bounds, count) = (Box4::EMPTY, 0);
            for bin in 1..BINS {
                bounds = bounds.union(bins[bin - 1].bounds);
                count += bins[bin - 1].count;
                let (area, area_above) = (bounds.half_area(), above[bin].0);
                let cost = area * count as f32 + area_above * above[bin].1;
                if count > 0 && above[bin].1 > 0.0 && cost < best.0 {
                    best = (cost, Some(Split { axis, bin, area: area + area_above }));
                }
            }
        }
        best.1
    }
}

/// Moves the primitives that belong to the first half to the front, and returns their number.
fn partition(primitives: &mut [Primitive], is_first: impl Fn(&Primitive) -> bool) -> usize {
    let (mut low, mut high) = (0, primitives.len());
    while low < high {
        if is_first(&primitives[low]) {
            low += 1;
        } else {
            high -= 1;
            primitives.swap(low, high);
        }
    }
    low
}
