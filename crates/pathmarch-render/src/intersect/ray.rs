//! Rays, ray segments and hits.

use glam::Vec3;
use pathmarch_field::graph::{RayKind, SPHERE_TRACED};
use pathmarch_field::number::{Mask8, Vec3 as FieldVec3};
use wide::f32x8;

/// Ray in world space.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Unit vector.
    pub(crate) direction: Vec3,
}

/// Ray with a limited length.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct RaySegment {
    pub(crate) ray: Ray,
    /// Length of the path before the ray, metres.
    pub(crate) path_length: f32,
    /// Largest distance along the ray, metres.
    pub(crate) limit: f32,
}

impl RaySegment {
    /// All of its numbers, in their order in memory.
    #[inline(always)]
    fn row(&self) -> f32x8 {
        let &Self { ray: Ray { origin: o, direction: d }, path_length, limit } = self;
        f32x8::from([o.x, o.y, o.z, d.x, d.y, d.z, path_length, limit])
    }

    /// A ray that starts at the camera begins its path.
    pub(crate) fn kind(&self) -> RayKind {
        if self.path_length == 0.0 { RayKind::Camera } else { RayKind::Secondary }
    }
}

/// Vector of the values of eight lanes.
#[inline(always)]
pub(crate) fn lanes(value: impl Fn(usize) -> f32) -> f32x8 {
    f32x8::from(std::array::from_fn(value))
}

/// Numbers of the eight lanes, from those of each lane.
#[inline(always)]
pub(crate) fn transposed(rows: [[f32; 8]; 8]) -> [f32x8; 8] {
    f32x8::transpose(rows.map(f32x8::from))
}

/// Lanes whose bit is set.
#[inline(always)]
pub(crate) fn mask_of(bits: u32) -> Mask8 {
    Mask8(lanes(|lane| (bits >> lane & 1) as f32).simd_gt(f32x8::ZERO))
}

/// Positions of the bits that are set.
#[inline(always)]
pub(crate) fn set_bits(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        lane
    })
}

/// Eight vectors as a structure of arrays.
#[inline(always)]
pub(crate) fn pack(vectors: [Vec3; 8]) -> FieldVec3<f32x8> {
    FieldVec3::new(lanes(|lane| vectors[lane].x), lanes(|lane| vectors[lane].y), lanes(|lane| vectors[lane].z))
}

/// Vectors of the eight lanes.
#[inline(always)]
pub(crate) fn unpack(v: FieldVec3<f32x8>) -> [Vec3; 8] {
    let [x, y, z] = [v.x, v.y, v.z].map(f32x8::to_array);
    std::array::from_fn(|lane| Vec3::new(x[lane], y[lane], z[lane]))
}

/// Vector of a lane.
#[inline(always)]
pub(crate) fn lane_of(v: FieldVec3<f32x8>, lane: usize) -> Vec3 {
    Vec3::new(v.x.as_array()[lane], v.y.as_array()[lane], v.z.as_array()[lane])
}

/// Replaces the vector of a lane.
#[inline(always)]
pub(crate) fn set_lane(v: &mut FieldVec3<f32x8>, lane: usize, value: Vec3) {
    v.x.as_mut_array()[lane] = value.x;
    v.y.as_mut_array()[lane] = value.y;
    v.z.as_mut_array()[lane] = value.z;
}

/// Eight rays as a structure of arrays. Copies of the first ray fill the last lanes.
pub(crate) struct Rays8 {
    pub(crate) origin: FieldVec3<f32x8>,
    pub(crate) direction: FieldVec3<f32x8>,
    pub(crate) limit: f32x8,
}

impl Rays8 {
    /// Packs one to eight rays.
    #[inline]
    pub(crate) fn new<'a>(rays: impl Iterator<Item = &'a RaySegment>) -> Self {
        let mut rows = [f32x8::ZERO; 8];
        let mut count = 0;
        for (row, segment) in rows.iter_mut().zip(rays) {
            *row = segment.row();
            count += 1;
        }
        let first = rows[0];
        rows[count..].fill(first);
        let [ox, oy, oz, dx, dy, dz, _, limit] = f32x8::transpose(rows);
        Self { origin: FieldVec3::new(ox, oy, oz), direction: FieldVec3::new(dx, dy, dz), limit }
    }
}

/// Hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Distance from the origin, metres.
    pub(crate) t: f32,
    /// Leaf of an analytic hit; `None` for a sphere-traced hit.
    pub(crate) analytic: Option<u32>,
    /// Triangle of a hit with a mesh.
    pub(crate) triangle: Option<u32>,
}

impl Hit {
    /// Encodes the analytic leaf for [`Field::surface_at_hit`](pathmarch_field::Field::surface_at_hit).
    #[inline]
    pub(crate) fn encoded(analytic: Option<u32>) -> f32 {
        analytic.map_or(SPHERE_TRACED, |leaf| leaf as f32)
    }
}
