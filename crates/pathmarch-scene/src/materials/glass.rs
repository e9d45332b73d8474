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
//! Each surface is one between the glass and air: two glasses that touch or overlap are seen as two surfaces. A
//! `roughness` below 0.01, or an `ior` within 0.001 of 1, is perfectly smooth.

use super::dispersion::{dispersed_index, index_difference};
use super::microfacet::{
    MIRROR_ALPHA, fresnel, head_on, reflect, reflection, refract, refracting_normal, refraction_pdf, unhidden,
    unshadowed, visible_normal,
};
use super::{
    Bsdf, BsdfParameters, Eval, MaterialKind, PreviewMaterial, Scattered, Texturing, abbe, absorption, anisotropy, black,
    colour, colour_of, glow, ior, multiscatter, roughness, scattering,
};
use crate::medium::Medium;
use glam::Vec3;
use pathmarch_field::Range;

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
    ],
    albedo: |values| values[0],
    emission: black,
    medium: |values| Medium {
        absorption: values[3],
        scattering: values[5],
        anisotropy: values[6][0],
        emission: values[7],
    },
    has_surface: true,
    preview: |values| PreviewMaterial {
        specular: [[head_on(values[1][0]); 3], if values[1][0] > 1.0 { [1.0; 3] } else { [0.0; 3] }],
        roughness: values[2][0],
        transmission: values[0],
        ior: values[1][0],
        ..PreviewMaterial::default()
    },
    bsdf: Some(&Bsdf {
        pack: |values| {
            let (ior, roughness) = (values[1][0], values[2][0]);
            let smooth = (ior - 1.0).abs() < 1e-3;
            let mut parameters = BsdfParameters::default();
            parameters[..3].copy_from_slice(&values[0]);
            parameters[3] = if smooth { 0.0 } else { roughness * roughness };
            parameters[4] = ior;
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
        transmits: |_| true,
        chooses_lobes: true,
        reads_albedos: |_| false,
        compensates: |parameters| parameters[MULTISCATTER] > 0.0,
        at_wavelength: Some(|parameters, offset| {
            let mut parameters = *parameters;
            parameters[4] = dispersed_index(parameters[4], parameters[5], offset);
            parameters
        }),
        eval,
        sample,
        wgsl: include_str!("glass.wgsl"),
    }),
};

// Places in the parameters.
const MULTISCATTER: usize = 6;
const OUTSIDE: usize = 7;
const INSIDE: usize = OUTSIDE + ALBEDOS;
/// Number of cosines at which the parameters contain the albedo of each side.
const ALBEDOS: usize = 12;
/// Along each edge of the grid of sampled normals.
const SAMPLES: usize = 24;

/// Albedo of reflection and refraction together, without tint, at a cosine.
fn integrated_albedo(cosine: f32, alpha: f32, eta: f32) -> f32 {
    let wo = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let facet = |k: usize| {
        let at = |k: usize| (k as f32 + 0.5) / SAMPLES as f32;
        let h = visible_normal(wo, alpha, [at(k % SAMPLES), at(k / SAMPLES)]);
        let reflected = fresnel(wo.dot(h), eta);
        let (above, below) = (reflect(wo, h), refract(wo, h, eta));
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
    if inside { 1.0 / parameters[4] } else { parameters[4] }
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
    let smooth = alpha < MIRROR_ALPHA;
    let h = if smooth { Vec3::Z } else { visible_normal(wo, alpha, [u, v]) };
    let reflected = fresnel(wo.dot(h), eta);
    if choice < reflected {
        let wi = reflect(wo, h);
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
    let wi = refract(wo, h, eta);
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
