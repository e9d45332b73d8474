//! Closest point of a surface.
//!
//! **Idea.** The same traversal as for rays, by the distance to boxes. **Cost.** About 1 µs near the surface of a million
//! triangles; many times that where most of the surface is equally far, as in the centre of a sphere.

use super::stack::Stack;
use super::{Bvh, LEAF, WideNode, triangle8};
use crate::triangle_mesh::TriangleMesh;
use glam::{DVec3, Vec3};
use wide::f32x8;

/// Point of a mesh that is closest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Distance, not negative.
    pub distance: f32,
    /// The point.
    pub point: Vec3,
    /// Index of the triangle that it is on.
    pub triangle: u32,
    /// Weights of the second and third corner; the first has what they leave of one.
    pub barycentrics: [f32; 2],
}

/// Triangle in a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    pub squared_distance: f32,
    /// Index of its block of eight, and its place there.
    block: u32,
    lane: u32,
}

/// Index of no block.
const NONE: u32 = u32::MAX;

impl Bvh {
    /// Closest point of a mesh that is at most `max_distance` away; `mesh` is that of [`Bvh::build`].
    ///
    /// # Panics
    /// If `mesh` has fewer triangles than that of the hierarchy.
    pub fn closest_point(&self, mesh: &TriangleMesh, p: Vec3, max_distance: f32) -> Option<ClosestPoint> {
        let nearest = self.nearest(p, max_distance * max_distance)?;
        let triangle = self.blocks[nearest.block as usize].triangles[nearest.lane as usize];
        let (point, barycentrics) = closest_on_triangle(p, mesh.corners(triangle as usize));
        Some(ClosestPoint { distance: p.distance(point), point, triangle, barycentrics })
    }

    /// Nearest triangle within a distance.
    #[inline]
    pub(crate) fn nearest(&self, p: Vec3, max_squared: f32) -> Option<Nearest> {
        let mut search = Search::new(self, p, max_squared);
        if !self.nodes.is_empty() {
            search.descend(0);
        }
        search.nearest
    }
}

/// Search for the triangle nearest to a point.
pub(super) struct Search<'b> {
    bvh: &'b Bvh,
    /// The point, on all lanes.
    p: [f32x8; 3],
    /// Squared distance below which a triangle is of interest.
    limit: f32,
    /// Block that was tested first, or [`NONE`].
    tested: u32,
    pub nearest: Option<Nearest>,
}

impl<'b> Search<'b> {
    #[inline(always)]
    pub fn new(bvh: &'b Bvh, p: Vec3, max_squared: f32) -> Self {
        Self { bvh, p: p.to_array().map(f32x8::splat), limit: max_squared, tested: NONE, nearest: None }
    }

    /// Tests the block of another search's result first.
    #[inline(always)]
    pub fn start_with(&mut self, guess: Nearest) {
        self.visit(guess.block);
        self.tested = guess.block;
    }

    /// Tests a block of triangles.
    #[inline(always)]
    fn visit(&mut self, block: u32) {
        let squared = self.bvh.blocks[block as usize].squared_distances(self.p);
        let mask = squared.simd_lt(f32x8::splat(self.limit)).to_bitmask();
        if mask != 0 {
            let (lane, least) = least_lane(squared.as_array(), mask);
            self.limit = least;
            self.nearest = Some(Nearest { squared_distance: least, block, lane });
        }
    }

    /// Tests eight boxes, and what is in those that are near enough.
    #[inline(always)]
    pub fn visit_children(&mut self, node: &WideNode) {
        let squared = box_squared_distances(self.p, &node.min, &node.max);
        let mut mask = squared.simd_lt(f32x8::splat(self.limit)).to_bitmask();
        while mask != 0 {
            let slot = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            if squared.as_array()[slot] < self.limit {
                self.follow(node.children[slot]);
            }
        }
    }

    /// Tests a child of a node.
    #[inline(always)]
    fn follow(&mut self, child: u32) {
        if child & LEAF == 0 {
            self.descend(child);
        } else if child & !LEAF != self.tested {
            self.visit(child & !LEAF);
        }
    }

    /// Tests the triangles below a node.
    #[inline]
    fn descend(&mut self, node: u32) {
        let mut stack = Stack::at(node);
        while let Some(entry) = stack.pop() {
            if entry.distance >= self.limit {
                continue;
            }
            if entry.node & LEAF != 0 {
                self.visit(entry.node & !LEAF);
                continue;
            }
            let node = &self.bvh.nodes[entry.node as usize];
            let squared = box_squared_distances(self.p, &node.min, &node.max);
            let mask = squared.simd_lt(f32x8::splat(self.limit)).to_bitmask();
            stack.push_sorted(mask, squared.as_array(), &node.children);
        }
    }
}

/// Squared distances of a point to eight boxes.
#[inline(always)]
fn box_squared_distances(p: [f32x8; 3], min: &[f32x8; 3], max: &[f32x8; 3]) -> f32x8 {
    let beyond = [0, 1, 2].map(|k| (min[k] - p[k]).fast_max(p[k] - max[k]).fast_max(f32x8::ZERO));
    beyond[0].mul_add(beyond[0], beyond[1].mul_add(beyond[1], beyond[2] * beyond[2]))
}

/// The lane of a mask with the least value.
#[inline(always)]
fn least_lane(values: &[f32; triangle8::LANES], mask: u32) -> (u32, f32) {
    let mut best = (0, f32::INFINITY);
    let mut mask = mask;
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        if values[lane as usize] < best.1 {
            best = (lane, values[lane as usize]);
        }
    }
    best
}

/// Closest point of a triangle, and the weights of its second and third corner (Ericson 2005, section 5.1.5), in 64 bits.
pub(crate) fn closest_on_triangle(p: Vec3, corners: [Vec3; 3]) -> (Vec3, [f32; 2]) {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let p = p.as_dvec3();
    let (v, w) = foot_inside([a, b, c], p).unwrap_or_else(|| {
        let candidates = [(a, b), (b, c), (c, a)].map(|(from, to)| along_segment(p, from, to));
        let weights = [(candidates[0], 0.0), (1.0 - candidates[1], candidates[1]), (0.0, 1.0 - candidates[2])];
        let squared = |&(v, w): &(f64, f64)| (a + v * (b - a) + w * (c - a)).distance_squared(p);
        weights.into_iter().min_by(|x, y| squared(x).total_cmp(&squared(y))).unwrap_or_default()
    });
    ((a + v * (b - a) + w * (c - a)).as_vec3(), [v as f32, w as f32])
}

/// Weights of the foot of the perpendicular, if that is inside the triangle.
fn foot_inside([a, b, c]: [DVec3; 3], p: DVec3) -> Option<(f64, f64)> {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let v = ap.cross(ac).dot(normal) / normal.length_squared();
    let w = ab.cross(ap).dot(normal) / normal.length_squared();
    (v >= 0.0 && w >= 0.0 && v + w <= 1.0).then_some((v, w))
}

/// Fraction of a segment at which it is closest to a point.
fn along_segment(p: DVec3, from: DVec3, to: DVec3) -> f64 {
    let along = to - from;
    let length = along.length_squared();
    if length > 0.0 { ((p - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 }
}
