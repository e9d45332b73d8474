//! Watertight intersection of one ray with one triangle (Woop et al. 2013): the plain form of `triangle8.rs`.
//!
//! **Difference.** Only the edge functions that are zero are computed again in 64 bits, not all three: the triangle at the other
//! side of an edge must get the same sign.

use super::ray::Ray;
use glam::{DVec2, Vec3};

/// Shear that turns a ray's direction to its longest axis.
pub(super) struct RayShear {
    origin: Vec3,
    axes: [usize; 3],
    shear: Vec3,
}

impl RayShear {
    pub fn new(ray: &Ray) -> Self {
        let long = ray.direction.abs().max_position();
        let axes = [(long + 1) % 3, (long + 2) % 3, long];
        let [x, y, z] = axes.map(|axis| ray.direction[axis]);
        Self { origin: ray.origin, axes, shear: Vec3::new(x / z, y / z, 1.0 / z) }
    }

    fn sheared(&self, corner: Vec3) -> Vec3 {
        let relative = corner - self.origin;
        let [x, y, z] = self.axes.map(|axis| relative[axis]);
        Vec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
    }

    /// Parameter of the hit, and the weights of the second and third corner.
    pub fn intersect(&self, corners: [Vec3; 3], t_min: f32, t_max: f32) -> Option<(f32, [f32; 2])> {
        let [a, b, c] = corners.map(|corner| self.sheared(corner));
        let wide = |p: Vec3| DVec2::new(p.x.into(), p.y.into());
        let edges = [(c, b), (a, c), (b, a)].map(|(p, q)| match p.x * q.y - p.y * q.x {
            0.0 => sign_preserving(wide(p).perp_dot(wide(q))),
            edge => edge,
        });
        let has_negative = edges.iter().any(|edge| *edge < 0.0);
        if has_negative && edges.iter().any(|edge| *edge > 0.0) {
            return None;
        }
        let determinant: f32 = edges.iter().sum();
        let t = (edges[0] * a.z + edges[1] * b.z + edges[2] * c.z) / determinant;
        (t > t_min && t < t_max).then_some((t, [edges[1] / determinant, edges[2] / determinant]))
    }
}

/// Rounds to 32 bits, but not to zero.
pub(super) fn sign_preserving(v: f64) -> f32 {
    let rounded = v as f32;
    if rounded == 0.0 && v != 0.0 { f32::MIN_POSITIVE.copysign(rounded) } else { rounded }
}
