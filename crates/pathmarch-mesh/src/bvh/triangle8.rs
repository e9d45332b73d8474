//! Eight triangles side by side.
//!
//! **Idea.** The ray is sheared so that it runs along an axis; the signs of three edge functions then decide whether it passes a
//! triangle. Both triangles at an edge compute the same products, so that no ray passes between them. Where an edge function
//! is zero, 32 bits may have rounded its sign away, and it is computed again in 64 (Woop et al. 2013). Both sides of
//! a triangle are hit.
//!
//! The distance from a point is the least of four candidates: the nearest points of the three edges, and the foot of the
//! perpendicular if that is inside (Ericson 2005, section 5.1.5). Each is a point of the triangle, so that rounding never makes
//! a distance too short by more than the rounding of coordinates.
//!
//! **Cost.** 320 bytes.

use super::ray::ShearedRay;
use super::watertight::sign_preserving;
use glam::Vec3;
use wide::f32x8;

/// Number of triangles side by side.
pub(super) const LANES: usize = 8;

/// Up to eight triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle8 {
    /// Coordinates by corner and axis. Those of unused lanes are NaN, which fails every comparison.
    corners: [[f32x8; 3]; 3],
    /// Index of each triangle in the mesh.
    pub triangles: [u32; LANES],
}

/// Hit of the nearest triangle of a block.
pub(super) struct BlockHit {
    pub t: f32,
    pub lane: usize,
    /// Weights of the second and third corner.
    pub barycentrics: [f32; 2],
}

impl Triangle8 {
    /// Packs triangles, given as index and corners.
    pub fn new(triangles: impl Iterator<Item = (u32, [Vec3; 3])>) -> Self {
        let mut lanes = [[[f32::NAN; LANES]; 3]; 3];
        let mut indices = [u32::MAX; LANES];
        for (lane, (index, corners)) in triangles.enumerate() {
            indices[lane] = index;
            for (lanes, corner) in lanes.iter_mut().zip(corners) {
                for axis in 0..3 {
                    lanes[axis][lane] = corner[axis];
                }
            }
        }
        Self { corners: lanes.map(|corner| corner.map(f32x8::from)), triangles: indices }
    }

    /// Nearest hit with a parameter in the ray's range, exclusive of both ends, among the triangles of these lanes (a bit
    /// each).
    #[inline(always)]
    pub fn intersect(&self, ray: &ShearedRay, t_min: f32, t_max: f32, lanes: u32) -> Option<BlockHit> {
        let [a, b, c] = &self.corners;
        let [a, b, c] = [ray.shear(a), ray.shear(b), ray.shear(c)];
        let edges = EdgeFunctions::new(&[a, b, c]);
        let determinant = edges.u + edges.v + edges.w;
        let t = (edges.u * a[2] + edges.v * b[2] + edges.w * c[2]) / determinant;
        let is_hit = edges.same_sign() & t.simd_gt(f32x8::splat(t_min)) & t.simd_lt(f32x8::splat(t_max));
        let mut mask = is_hit.to_bitmask() & lanes;
        if mask == 0 {
            return None;
        }
        let t = t.to_array();
        let mut lane = mask.trailing_zeros() as usize;
        mask &= mask - 1;
        while mask != 0 {
            let other = mask.trailing_zeros() as usize;
            lane = if t[other] < t[lane] { other } else { lane };
            mask &= mask - 1;
        }
        let of_lane = |edge: f32x8| (edge / determinant).to_array()[lane];
        Some(BlockHit { t: t[lane], lane, barycentrics: [of_lane(edges.v), of_lane(edges.w)] })
    }

    /// Squared distances from a point given on all lanes; NaN on unused ones.
    #[inline(always)]
    pub fn squared_distances(&self, p: [f32x8; 3]) -> f32x8 {
        let [a, b, c] = &self.corners;
        let (ab, bc, ca) = (sub(b, a), sub(c, b), sub(a, c));
        let (ap, bp, cp) = (sub(&p, a), sub(&p, b), sub(&p, c));
        let edges = to_segment(ap, ab).fast_min(to_segment(bp, bc)).fast_min(to_segment(cp, ca));
        // Barycentric coordinates of the foot of the perpendicular (Ericson 2005, section 3.4).
        let (ab_ab, ac_ac, ab_ac) = (dot(ab, ab), dot(ca, ca), -dot(ab, ca));
        let (ap_ab, ap_ac) = (dot(ap, ab), -dot(ap, ca));
        let scale = f32x8::ONE / (ab_ab * ac_ac - ab_ac * ab_ac);
        let v = (ac_ac * ap_ab - ab_ac * ap_ac) * scale;
        let w = (ab_ab * ap_ac - ab_ac * ap_ab) * scale;
        let offset = [0, 1, 2].map(|k| ap[k] - v * ab[k] + w * ca[k]);
        let zero = f32x8::ZERO;
        let is_inside = v.simd_ge(zero) & w.simd_ge(zero) & (v + w).simd_le(f32x8::ONE);
        is_inside.bitselect(dot(offset, offset).fast_min(edges), edges)
    }
}

/// The edge functions U, V and W.
struct EdgeFunctions {
    u: f32x8,
    v: f32x8,
    w: f32x8,
}

impl EdgeFunctions {
    #[inline(always)]
    fn new([a, b, c]: &[[f32x8; 3]; 3]) -> Self {
        let edge = |p: &[f32x8; 3], q: &[f32x8; 3]| p[0] * q[1] - p[1] * q[0];
        let [mut u, mut v, mut w] = [edge(c, b), edge(a, c), edge(b, a)];
        let zero = f32x8::ZERO;
        if (u.simd_eq(zero) | v.simd_eq(zero) | w.simd_eq(zero)).any() {
            // Others stay as they are, or the triangle at the other side of an edge might get another sign.
            u = u.simd_eq(zero).bitselect(edge_f64(c, b), u);
            v = v.simd_eq(zero).bitselect(edge_f64(a, c), v);
            w = w.simd_eq(zero).bitselect(edge_f64(b, a), w);
        }
        Self { u, v, w }
    }

    /// Mask of lanes on which no two signs differ. If all are zero, the parameter of the hit is NaN.
    #[inline(always)]
    fn same_sign(&self) -> f32x8 {
        let zero = f32x8::ZERO;
        let least = self.u.fast_min(self.v).fast_min(self.w);
        let greatest = self.u.fast_max(self.v).fast_max(self.w);
        least.simd_ge(zero) | greatest.simd_le(zero)
    }
}

/// Edge function in 64 bits, whose sign is exact but for underflow.
#[cold]
fn edge_f64(p: &[f32x8; 3], q: &[f32x8; 3]) -> f32x8 {
    let (p, q) = (p.map(f32x8::to_array), q.map(f32x8::to_array));
    let edge =
        |k: usize| sign_preserving(f64::from(p[0][k]) * f64::from(q[1][k]) - f64::from(p[1][k]) * f64::from(q[0][k]));
    f32x8::from(std::array::from_fn::<f32, LANES, _>(edge))
}

#[inline(always)]
fn sub(p: &[f32x8; 3], q: &[f32x8; 3]) -> [f32x8; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn dot(p: [f32x8; 3], q: [f32x8; 3]) -> f32x8 {
    p[0].mul_add(q[0], p[1].mul_add(q[1], p[2] * q[2]))
}

/// Squared distance to a segment, given the point relative to its start, and its direction.
#[inline(always)]
fn to_segment(p: [f32x8; 3], along: [f32x8; 3]) -> f32x8 {
    // A segment without length is its start.
    let length = dot(along, along).fast_max(f32x8::splat(f32::MIN_POSITIVE));
    let t = (dot(p, along) / length).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
    let offset = [0, 1, 2].map(|k| p[k] - t * along[k]);
    dot(offset, offset)
}
