//! Rays, segments of them, and hits.

use glam::Vec3;
use pathmarch_field::graph::SPHERE_TRACED;
use pathmarch_field::number::Vec3 as FieldVec3;
use wide::f32x8;

/// Ray in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Of length one.
    pub(crate) direction: Vec3,
}

/// Part of a ray that is tested for hits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RaySegment {
    pub(crate) ray: Ray,
    /// Length of the path before this ray, metres.
    pub(crate) path_length: f32,
    /// Largest distance along the ray, metres.
    pub(crate) limit: f32,
}

/// Value of each of eight lanes.
#[inline(always)]
pub(crate) fn lanes(value: impl Fn(usize) -> f32) -> f32x8 {
    f32x8::from(std::array::from_fn(value))
}

/// Eight rays; copies of the first fill the last lanes.
pub(crate) struct Rays8 {
    pub(crate) origin: FieldVec3<f32x8>,
    pub(crate) direction: FieldVec3<f32x8>,
    pub(crate) limit: f32x8,
}

impl Rays8 {
    /// One to eight rays.
    pub(crate) fn new<'a>(rays: impl Iterator<Item = &'a RaySegment>) -> Self {
        let mut parts = [[0.0; 8]; 7];
        let mut count = 0;
        for RaySegment { ray: Ray { origin, direction }, limit, .. } in rays {
            let values = [origin.x, origin.y, origin.z, direction.x, direction.y, direction.z, *limit];
            for (part, value) in parts.iter_mut().zip(values) {
                part[count] = value;
            }
            count += 1;
        }
        for part in &mut parts {
            let first = part[0];
            part[count..].fill(first);
        }
        let [ox, oy, oz, dx, dy, dz, limit] = parts.map(f32x8::from);
        Self { origin: FieldVec3::new(ox, oy, oz), direction: FieldVec3::new(dx, dy, dz), limit }
    }
}

/// Hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Distance from the origin, metres.
    pub(crate) t: f32,
    /// Leaf that was hit, if it is analytic.
    pub(crate) analytic: Option<u32>,
}

impl Hit {
    /// The analytic leaf as [`Field::surface_at_hit`](pathmarch_field::Field::surface_at_hit) takes it.
    pub(crate) fn encoded(analytic: Option<u32>) -> f32 {
        analytic.map_or(SPHERE_TRACED, |leaf| leaf as f32)
    }
}
