//! Rough interfaces as many small mirrors: the GGX distribution with Smith's masking and shadowing.
//!
//! Directions are in a local frame whose z is the normal on the side of `wo`; `wo` points to where the light goes, `wi` to
//! where it comes from, both away from the surface. Roughness is artists' roughness: `alpha` is its square (Burley 2012,
//! "Physically-Based Shading at Disney"). Sources: Walter et al. 2007, "Microfacet Models for Refraction through Rough
//! Surfaces" (distribution, refraction); Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based
//! BRDFs" (height-correlated masking); Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
//! The terms are arranged so that nothing is divided by a cosine. Functions over [`Real`] are for one path or for eight in
//! SIMD lanes. Twin of microfacet.wgsl.

use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3, unit_circle};
use std::f32::consts::PI;

/// Below this, a surface is a mirror: its lobe is narrower than anything a picture resolves.
pub(super) const MIRROR_ALPHA: f32 = 1e-4;
/// Largest α of a surface that throws caustics: that of roughness 0.3.
pub(super) const FOCUSING_ALPHA: f32 = 0.0901;

/// Smallest alpha of layered materials, roughness 0.0316: narrower lobes cannot be distinguished.
pub(super) const MIN_ALPHA: f32 = 1e-3;

/// Density of normals `h` over solid angle, projected: GGX.
#[inline(always)]
pub(super) fn distribution<N: Real>(h: impl Into<FieldVec3<N>>, alpha: N) -> N {
    let square = alpha * alpha;
    square / inverse_distribution(h.into(), square)
}

/// Square of alpha, of which `square` is that, divided by the [density of normals](distribution).
#[inline(always)]
fn inverse_distribution<N: Real>(h: FieldVec3<N>, square: N) -> N {
    let slope = h.x * h.x + h.y * h.y + square * h.z * h.z;
    N::constant(PI) * slope * slope
}

/// Length of a direction stretched by alpha: Smith's Λ is (stretched/|z| - 1)/2.
#[inline(always)]
pub(super) fn stretched<N: Real>(w: impl Into<FieldVec3<N>>, alpha: N) -> N {
    let w = w.into();
    (alpha * alpha * (w.x * w.x + w.y * w.y) + w.z * w.z).sqrt()
}

/// Share of the normals that `w` sees which nothing hides from it: Smith's G1.
pub(super) fn unhidden(w: Vec3, alpha: f32) -> f32 {
    2.0 * w.z.abs() / (stretched(w, alpha) + w.z.abs())
}

/// BRDF times cosine of reflection by these normals with a Fresnel factor of one, and its density when `h` is drawn by
/// [`visible_normal`].
#[inline(always)]
pub(super) fn reflection<N: Real>(
    wo: impl Into<FieldVec3<N>>,
    wi: impl Into<FieldVec3<N>>,
    h: impl Into<FieldVec3<N>>,
    alpha: N,
) -> (N, N) {
    let (wo, wi, two) = (wo.into(), wi.into(), N::constant(2.0));
    let (o, i) = (stretched(wo, alpha), stretched(wi, alpha));
    let square = alpha * alpha;
    let d = inverse_distribution(h.into(), square);
    let value = wi.z / (d * (two * (wi.z * o + wo.z * i)).max(N::constant(1e-20)));
    (square * value, square * (N::one() / (d * (two * (o + wo.z)))))
}

/// Share of what is reflected from a visible facet into `wi` that nothing shadows: the weight of a sample of a Fresnel factor
/// of one.
#[inline(always)]
pub(super) fn unshadowed<N: Real>(wo: impl Into<FieldVec3<N>>, wi: impl Into<FieldVec3<N>>, alpha: N) -> N {
    let (wo, wi) = (wo.into(), wi.into());
    let (o, i) = (stretched(wo, alpha), stretched(wi, alpha));
    wi.z * (o + wo.z) / (wi.z * o + wo.z * i)
}

/// Density over solid angle of `wi` where `h` is drawn by [`visible_normal`] and `wo` is refracted by it into a medium of
/// relative index `eta`.
pub(super) fn refraction_pdf(wo: Vec3, wi: Vec3, h: Vec3, alpha: f32, eta: f32) -> f32 {
    let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
    let visible = 2.0 * cos_o * distribution(h, alpha) / (stretched(wo, alpha) + wo.z);
    let root = cos_o + eta * cos_i;
    visible * eta * eta * cos_i.abs() / (root * root).max(1e-20)
}

/// A normal as seen from `wo`, of density proportional to how much of it is seen.
#[inline(always)]
pub(super) fn visible_normal<N: Real>(wo: impl Into<FieldVec3<N>>, alpha: N, [u, v]: [N; 2]) -> FieldVec3<N> {
    let (wo, one, zero) = (wo.into(), N::one(), N::zero());
    let round = FieldVec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalized();
    let [cosine, sine] = unit_circle(u);
    let z = (one - v) * (one + round.z) - round.z;
    let radius = (one - z * z).max(zero).sqrt();
    let h = FieldVec3::new(radius * cosine, radius * sine, z) + round;
    FieldVec3::new(alpha * h.x, alpha * h.y, h.z.max(N::constant(1e-9))).normalized()
}

/// Schlick's approximation of Fresnel's law (1994, "An Inexpensive BRDF Model for Physically-based Rendering").
#[inline(always)]
pub(super) fn schlick<N: Real>(f0: impl Into<FieldVec3<N>>, f90: impl Into<FieldVec3<N>>, cosine: N) -> FieldVec3<N> {
    let f0 = f0.into();
    f0 + (f90.into() - f0) * fifth_power(N::one() - cosine)
}

/// Fifth power of a number, clamped to 0 to 1.
#[inline(always)]
pub(super) fn fifth_power<N: Real>(x: N) -> N {
    let x = x.clamp(N::zero(), N::one());
    x * x * x * x * x
}

/// Cosine beyond an interface of relative index `eta`; 0 where all is reflected.
pub(super) fn refracted_cosine<N: Real>(cosine: N, eta: N) -> N {
    (N::one() - (N::one() - cosine * cosine) / (eta * eta)).max(N::zero()).sqrt()
}

/// Fraction that a sheet reflects whose faces reflect `face` each.
pub(super) fn sheet_reflection(face: f32) -> f32 {
    2.0 * face / (1.0 + face)
}

/// Fresnel's law for unpolarised light: the reflected share at this cosine (0 to 1) of an interface whose refractive index
/// beyond is `eta` times that before it.
#[inline]
pub fn fresnel<N: Real>(cosine: N, eta: N) -> N {
    let beyond = refracted_cosine(cosine, eta);
    let parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
    let perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
    let reflected = N::constant(0.5) * (parallel * parallel + perpendicular * perpendicular);
    N::select(N::zero().lt(beyond), reflected, N::one())
}

/// The share that an interface of this relative index reflects of light that falls in at right angles.
pub(super) fn head_on(eta: f32) -> f32 {
    ((eta - 1.0) / (eta + 1.0)).powi(2)
}

/// `wo` mirrored by `h`.
#[inline(always)]
pub(super) fn reflect<N: Real>(wo: impl Into<FieldVec3<N>>, h: impl Into<FieldVec3<N>>) -> FieldVec3<N> {
    let (wo, h) = (wo.into(), h.into());
    h * (N::constant(2.0) * wo.dot(h)) - wo
}

/// `wo` refracted by `h` into a medium of relative index `eta`.
#[inline(always)]
pub(super) fn refract<N: Real>(wo: impl Into<FieldVec3<N>>, h: impl Into<FieldVec3<N>>, eta: N) -> FieldVec3<N> {
    let (wo, h) = (wo.into(), h.into());
    let cosine = wo.dot(h);
    h * (cosine / eta - refracted_cosine(cosine, eta)) - wo / eta
}

/// The normal that refracts `wo` into `wi`, where there is one.
pub(super) fn refracting_normal(wo: Vec3, wi: Vec3, eta: f32) -> Option<Vec3> {
    let sum = (wo + wi * eta).normalize_or_zero();
    let h = if sum.z < 0.0 { -sum } else { sum };
    (wo.dot(h) > 0.0 && wi.dot(h) < 0.0).then_some(h)
}
