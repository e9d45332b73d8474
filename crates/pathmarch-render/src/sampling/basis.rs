//! Orthonormal bases around a direction.

use glam::{Mat3, Vec3};
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

/// Right-handed orthonormal basis with `n` as its z axis (Duff et al. 2017, "Building an Orthonormal Basis,
/// Revisited"). The matrix maps local to world space, its transpose maps world to local space.
#[inline]
pub(crate) fn basis(n: Vec3) -> Mat3 {
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    Mat3::from_cols(tangent, Vec3::new(b, sign + n.y * n.y * a, -n.y), n)
}

/// Unit vector in the direction of one whose length is one but for rounding, as [`FieldVec3::renormalized`].
#[inline]
pub(crate) fn renormalized(v: Vec3) -> Vec3 {
    v * (1.5 - 0.5 * v.length_squared())
}

/// [`basis`] of eight directions.
pub(crate) struct Basis8 {
    tangent: FieldVec3<f32x8>,
    bitangent: FieldVec3<f32x8>,
    normal: FieldVec3<f32x8>,
}

impl Basis8 {
    #[inline(always)]
    pub(crate) fn new(n: FieldVec3<f32x8>) -> Self {
        let one = f32x8::ONE;
        let sign = Real::select(Mask8(n.z.simd_lt(f32x8::ZERO)), -one, one);
        let a = -one / (sign + n.z);
        let b = n.x * n.y * a;
        let tangent = FieldVec3::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x);
        Self { tangent, bitangent: FieldVec3::new(b, sign + n.y * n.y * a, -n.y), normal: n }
    }

    /// Maps world to local space.
    #[inline(always)]
    pub(crate) fn to_local(&self, v: FieldVec3<f32x8>) -> FieldVec3<f32x8> {
        FieldVec3::new(self.tangent.dot(v), self.bitangent.dot(v), self.normal.dot(v))
    }

    /// Unit vector to the viewer in local space, as [`local_viewer`].
    #[inline(always)]
    pub(crate) fn local_viewer(&self, to_viewer: FieldVec3<f32x8>) -> FieldVec3<f32x8> {
        let wo = self.to_local(to_viewer);
        FieldVec3::new(wo.x, wo.y, wo.z.abs().fast_max(f32x8::splat(1e-5)))
    }

    /// Maps local to world space.
    #[inline(always)]
    pub(crate) fn to_world(&self, v: FieldVec3<f32x8>) -> FieldVec3<f32x8> {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}

/// Unit vector to the viewer in the frame of a BSDF, from world space, on the side of the normal. The normal of a rough field
/// may point away from the ray: then the mirrored vector replaces it.
#[inline]
pub(crate) fn local_viewer(local_from_world: Mat3, to_viewer: Vec3) -> Vec3 {
    let wo = local_from_world * to_viewer;
    wo.with_z(wo.z.abs().max(1e-5))
}
