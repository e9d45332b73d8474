//! Local frames about a direction.

use glam::{Mat3, Vec3};

/// A right-handed frame with `n` as its z (Duff et al. 2017, "Building an Orthonormal Basis, Revisited"): world from
/// local; its transpose is local from world.
pub(crate) fn basis(n: Vec3) -> Mat3 {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    Mat3::from_cols(tangent, Vec3::new(b, sign + n.y * n.y * a, -n.y), n)
}
