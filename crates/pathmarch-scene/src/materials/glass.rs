//! Glass: a smooth or rough interface of a clear solid. Light is reflected by Fresnel's law and refracted by Snell's, at
//! the facets of a GGX surface where it is rough (Walter et al. 2007). Masking is height-correlated in reflection and
//! separable in refraction, where the two directions lie on opposite sides (Heitz et al. 2016, "Multiple-Scattering
//! Microfacet BSDFs with the Smith Model", section 4.2, has the exact term, which lies near). Scattering is single,
//! and the light that it loses between the facets is given back by `multiscatter`, which scales both directions by one over
//! the sum of their albedos (Turquin 2019, section 5). The
//! colour tints what goes through, once at each crossing; `absorb` takes it on the way (Beer and Lambert). Radiance is
//! scaled by the square of the relative index where it changes medium (Veach 1997, "Robust Monte Carlo Methods for Light
//! Transport Simulation", section 5.2).
//!
//! With an Abbe number, the index depends on the wavelength ([`super::dispersion`]).
//!
//! Each surface is one between the glass and air: two glasses that touch or overlap are seen as two surfaces, unless a
//! `priority` says which of them fills the space; then the integrator calls [`Bsdf::with_index`] with the index relative to
//! what is outside. A `roughness` below 0.01, or an index within 0.001 of 1, is perfectly smooth.
//!
//! **Thin** glass is a sheet with two faces at each surface. The reflections between them add up to R' = 2R / (1 + R), and
//! the rest goes straight on (Pharr et al. 2023, section 9.7).

use super::dispersion::{dispersed_index, index_difference};
use super::microfacet::{
    FOCUSING_ALPHA, MIRROR_ALPHA, fresnel, head_on, reflect, reflection, refract, refracting_normal, refraction_pdf,
    sheet_reflection, unhidden, unshadowed, visible_normal,
};
use super::{
    Bsdf, BsdfParameters, Dielectric, Eval, Facets, MaterialKind, ParametersInLanes, PreviewMaterial, Scattered,
    SmoothInLanes, SmoothSampleInLanes, Texturing, abbe, absorption, anisotropy, black, colour, colour_of, glow, ior,
    multiscatter, priority, roughness, scattering, thin,
};
use crate::medium::Medium;
use glam::Vec3;
use pathmarch_field::Range;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "glass",
    doc: "Glass, water or ice, clear or frosted: reflects and refracts.",
    source: "Walter et al. 2007; Turquin 2019",
    params: &[
        colour(
            "colour",
            1.0,
            Range::from_to(0.0, 1.0),
            "Fraction of the refracted light that passes the surface.",
            Texturing::Colour(0),
        ),
        ior(),
        roughness(0.0),
        absorption(),
        abbe(),
        scattering("scatter", 0.0),
        anisotropy(),
        glow(),
        multiscatter(),
        priority(),
        thin(),
    ],
    albedo: |values| values[0],
    emission: black,
    medium: |values| {
        if is_thin(values) {
            return Medium::VACUUM;
        }
        Medium { absorption: values[3], scattering: values[5], anisotropy: values[6][0], emission: values[7] }
    },
    dielectric: |values| Dielectric {
        ior: values[1][0],
        index_difference: if is_thin(values) { 0.0 } else { index_difference(values[1][0], values[4][0]) },
        priority: values[9][0] as i32,
        is_thin: is_thin(values),
    },
    has_surface: true,
    preview: |values| {
        let (ior, thin) = (values[1][0], is_thin(values));
        let reflected = if thin { sheet_reflection(head_on(ior)) } else { head_on(ior) };
        PreviewMaterial {
            specular: [[reflected; 3], if ior > 1.0 { [1.0; 3] } else { [0.0; 3] }],
            roughness: if thin { 0.0 } else { values[2][0] },
            transmission: values[0],
            ior: if thin { 1.0 } else { ior },
            ..PreviewMaterial::default()
        }
    },
    bsdf: Some(&Bsdf {
        pack: |values| {
            let (ior, roughness) = (values[1][0], values[2][0]);
            let mut parameters = BsdfParameters::default();
            parameters[..3].copy_from_slice(&values[0]);
            if is_thin(values) {
                parameters[IOR] = ior;
                parameters[THIN] = 1.0;
                return parameters;
            }
            // With a priority, the index relative to what is outside decides.
            let smooth = is_matched(ior) && values[9][0] == 0.0;
            parameters[3] = if smooth { 0.0 } else { roughness * roughness };
            parameters[IOR] = ior;
            parameters[5] = index_difference(ior, values[4][0]);
            parameters[MULTISCATTER] = values[8][0];
            if parameters[MULTISCATTER] > 0.0 && parameters[3] >= MIRROR_ALPHA {
                for k in 0..ALBEDOS {
                    let root = k as f32 / (ALBEDOS - 1) as f32;
                    let cosine = (root * root).max(1e-4);
                    parameters[OUTSIDE + k] = integrated_albedo(cosine, parameters[3], ior);
                    parameters[INSIDE + k] = integrated_albedo(cosine, parameters[3], 1.0 / ior);
                }
            }
            parameters
        },
        is_delta: |parameters| parameters[3] < MIRROR_ALPHA,
        is_lambertian: false,
        focuses: |parameters| parameters[3] <= FOCUSING_ALPHA,
        transmits: |_| true,
        chooses_lobes: true,
        reads_albedos: |_| false,
        compensates: |parameters| parameters[MULTISCATTER] > 0.0,
        at_wavelength: Some(|parameters, offset| {
            let mut parameters = *parameters;
            parameters[IOR] = dispersed_index(parameters[IOR], parameters[5], offset);
            parameters
        }),
        with_index: Some(|parameters, index| {
            let mut parameters = *parameters;
            if (index / parameters[IOR] - 1.0).abs() > COMPENSATED_CHANGE {
                // The table of albedos is that of glass in air.
                parameters[MULTISCATTER] = 0.0;
            }
            parameters[IOR] = index;
            if is_matched(index) {
                parameters[3] = 0.0;
            }
            parameters
        }),
        eval,
        sample,
        facets: Some(&Facets {
            share: |_, _, _, _| Vec3::ONE,
            alpha: |parameters| parameters[3],
            chance: |_, _, _| 1.0,
            are_coloured: |_| false,
        }),
        in_lanes: None,
        smooth_in_lanes: Some(&SmoothInLanes {
            is_smooth: |parameters| parameters[3] < MIRROR_ALPHA && parameters[THIN] == 0.0,
            sample: sample_smooth,
        }),
        wgsl: include_str!("glass.wgsl"),
    }),
};

/// True if the glass is `thin`.
fn is_thin(values: &[[f32; 3]]) -> bool {
    values[10][0] > 0.0
}

/// True if an index is so near to 1 that light is not bent.
fn is_matched(index: f32) -> bool {
    (index - 1.0).abs() < MATCHED_INDEX
}

/// Transmittance of smooth glass with these parameters for an unrefracted ray; `cosine` is that of the angle of
/// incidence.
#[inline]
pub fn straight_transmittance(parameters: &BsdfParameters, cosine: f32) -> Vec3 {
    let face = fresnel(cosine, parameters[IOR]);
    let reflected = if parameters[THIN] > 0.0 { sheet_reflection(face) } else { face };
    colour_of(parameters) * (1.0 - reflected)
}

/// Relative change of the index up to which lost light is given back.
pub(super) const COMPENSATED_CHANGE: f32 = 0.02;
/// Distance from an index of 1 below which a rough surface is smooth.
pub(super) const MATCHED_INDEX: f32 = 1e-3;

// Places in the parameters.
const IOR: usize = 4;
const MULTISCATTER: usize = 6;
const OUTSIDE: usize = 7;
const INSIDE: usize = OUTSIDE + ALBEDOS;
const THIN: usize = INSIDE + ALBEDOS;
/// Number of cosines at which the parameters contain the albedo of each side.
const ALBEDOS: usize = 12;
/// Along each edge of the grid of sampled normals.
const SAMPLES: usize = 24;

/// Albedo of reflection and refraction together, without tint, at a cosine.
fn integrated_albedo(cosine: f32, alpha: f32, eta: f32) -> f32 {
    let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let facet = |k: usize| {
        let at = |k: usize| (k as f32 + 0.5) / SAMPLES as f32;
        let h: Vec3 = visible_normal(wo, alpha, [at(k % SAMPLES), at(k / SAMPLES)]).into();
        let reflected = fresnel(wo.dot(h), eta);
        let (above, below): (Vec3, Vec3) = (reflect(wo, h).into(), refract(wo, h, eta).into());
        let reflection = if above.z > 0.0 { reflected * unshadowed(wo, above, alpha) } else { 0.0 };
        let refraction = if below.z < 0.0 { (1.0 - reflected) * unhidden(below, alpha) } else { 0.0 };
        reflection + refraction
    };
    (0..SAMPLES * SAMPLES).map(facet).sum::<f32>() / (SAMPLES * SAMPLES) as f32
}

/// Factor that gives back light lost between the facets.
fn compensation(parameters: &BsdfParameters, wo: Vec3, inside: bool) -> f32 {
    let share = parameters[MULTISCATTER];
    if share == 0.0 {
        return 1.0;
    }
    let table = &parameters[if inside { INSIDE } else { OUTSIDE }..][..ALBEDOS];
    let place = wo.z.clamp(0.0, 1.0).sqrt() * (ALBEDOS - 1) as f32;
    let k = (place as usize).min(ALBEDOS - 2);
    let albedo = table[k] + (table[k + 1] - table[k]) * (place - k as f32);
    1.0 + share * (1.0 / albedo.max(0.1) - 1.0)
}

fn relative_index(parameters: &BsdfParameters, inside: bool) -> f32 {
    if inside { 1.0 / parameters[IOR] } else { parameters[IOR] }
}

fn eval(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Eval {
    let (alpha, eta) = (parameters[3], relative_index(parameters, inside));
    if alpha < MIRROR_ALPHA || wi.z == 0.0 {
        return Eval::NONE;
    }
    if wi.z > 0.0 {
        let h = (wo + wi).normalize();
        let reflected = fresnel(wo.dot(h), eta);
        let (value, pdf) = reflection(wo, wi, h, alpha);
        let value = reflected * value * compensation(parameters, wo, inside);
        return Eval { value: Vec3::splat(value), pdf: reflected * pdf };
    }
    let Some(h) = refracting_normal(wo, wi, eta) else { return Eval::NONE };
    let refracted = 1.0 - fresnel(wo.dot(h), eta);
    let pdf = refracted * refraction_pdf(wo, wi, h, alpha, eta);
    let given_back = compensation(parameters, wo, inside);
    Eval { value: colour_of(parameters) * (pdf * unhidden(wi, alpha) * given_back / (eta * eta)), pdf }
}

fn sample(parameters: &BsdfParameters, wo: Vec3, inside: bool, [u, v, choice]: [f32; 3]) -> Option<Scattered> {
    let (alpha, eta) = (parameters[3], relative_index(parameters, inside));
    if parameters[THIN] > 0.0 {
        // Both faces lie between the same two media, whichever side light comes from.
        let reflected = sheet_reflection(fresnel(wo.z, parameters[IOR]));
        return Some(match choice < reflected {
            true => Scattered { wi: reflect(wo, Vec3::Z).into(), weight: Vec3::ONE, pdf: 0.0, eta: 1.0 },
            false => Scattered { wi: -wo, weight: colour_of(parameters), pdf: 0.0, eta: 1.0 },
        });
    }
    let smooth = alpha < MIRROR_ALPHA;
    let h = if smooth { Vec3::Z } else { visible_normal(wo, alpha, [u, v]).into() };
    let reflected = fresnel(wo.dot(h), eta);
    if choice < reflected {
        let wi: Vec3 = reflect(wo, h).into();
        if smooth {
            return Some(Scattered { wi, weight: Vec3::ONE, pdf: 0.0, eta: 1.0 });
        }
        if wi.z <= 0.0 {
            return None;
        }
        let (_, pdf) = reflection(wo, wi, h, alpha);
        let weight = unshadowed(wo, wi, alpha) * compensation(parameters, wo, inside);
        return Some(Scattered { wi, weight: Vec3::splat(weight), pdf: reflected * pdf, eta: 1.0 });
    }
    let wi: Vec3 = refract(wo, h, eta).into();
    if wi.z >= 0.0 {
        return None;
    }
    let weight = colour_of(parameters) / (eta * eta);
    if smooth {
        return Some(Scattered { wi, weight, pdf: 0.0, eta });
    }
    let pdf = (1.0 - reflected) * refraction_pdf(wo, wi, h, alpha, eta);
    let weight = weight * (unhidden(wi, alpha) * compensation(parameters, wo, inside));
    Some(Scattered { wi, weight, pdf, eta })
}

/// [`sample`] of perfectly smooth glass that is not thin, for eight paths.
fn sample_smooth(
    parameters: &ParametersInLanes,
    wo: FieldVec3<f32x8>,
    inside: Mask8,
    choice: f32x8,
) -> SmoothSampleInLanes {
    let (zero, one) = (f32x8::ZERO, f32x8::ONE);
    let [r, g, b] = [0, 1, 2].map(|k| parameters.first[k]);
    let index = parameters.first[IOR];
    let eta = Real::select(inside, one / index, index);
    let h = FieldVec3::new(zero, zero, one);
    let is_reflected = Mask8(choice.simd_lt(fresnel(wo.dot(h), eta)));
    let colour = FieldVec3::new(r, g, b);
    SmoothSampleInLanes {
        wi: FieldVec3::select(is_reflected, reflect(wo, h), refract(wo, h, eta)),
        weight: FieldVec3::select(is_reflected, FieldVec3::splat(one), colour / (eta * eta)),
        eta: Real::select(is_reflected, one, eta),
    }
}
