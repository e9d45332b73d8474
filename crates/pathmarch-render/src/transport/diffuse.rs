//! Lambert's cosine law: radiance factor albedo/π in every direction, sampled by the cosine (Malley's method; Pharr,
//! Jakob and Humphreys, "Physically Based Rendering", 4th ed. 2023, section A.5.3), so that the weight of a sample is the
//! albedo itself.

use glam::Vec3;
use std::f32::consts::TAU;

/// Two unit vectors that make a right-handed basis with `n` (Duff et al. 2017, "Building an Orthonormal Basis,
/// Revisited").
pub(crate) fn basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// A direction about `n`, its density cosine/π over solid angle.
pub(crate) fn cosine_direction(n: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let radius = u.sqrt();
    let (sine, cosine) = (TAU * v).sin_cos();
    let (tangent, bitangent) = basis(n);
    let height = (1.0 - u).max(0.0).sqrt();
    (tangent * (radius * cosine) + bitangent * (radius * sine) + n * height).normalize()
}
