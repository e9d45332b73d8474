//! Metal: GGX reflection with height-correlated Smith masking, single scattering, coloured by Schlick's Fresnel factor
//! from `metal` at normal incidence to `edge` at grazing. Light that would bounce between the facets is lost: at
//! roughness 1 up to half of it. `multiscatter` scales the reflection so that it is given back (Turquin 2019), coloured by
//! the next bounce; this conserves energy but is not quite reciprocal. A `roughness` below 0.01 is a perfect mirror.

use super::albedo::lookup;
use super::microfacet::{FOCUSING_ALPHA, MIRROR_ALPHA, reflect, reflection, schlick, unshadowed, visible_normal};
use super::{
    Bsdf, BsdfParameters, Eval, MaterialKind, PreviewMaterial, Scattered, Texturing, colour, colour_of, emission,
    multiscatter, roughness, no_dielectric, vacuum,
};
use glam::Vec3;
use pathmarch_field::Range;

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "metal",
    doc: "Metal, from a mirror to a brushed block: reflects in its own colour.",
    source: "Walter et al. 2007; Heitz 2014; Dupuy and Benyoub 2023; Turquin 2019",
    params: &[
        colour(
            "colour",
            0.9,
            Range::from_to(0.0, 1.0),
            "Reflected fraction of light that falls in at right angles (F0).",
            Texturing::Colour(0),
        ),
        colour(
            "edge",
            1.0,
            Range::from_to(0.0, 1.0),
            "Reflected fraction of light that grazes (F90).",
            Texturing::Colour(4),
        ),
        roughness(0.2),
        emission(),
        multiscatter(),
    ],
    albedo: |values| values[0],
    emission: |values| values[3],
    medium: vacuum,
    dielectric: no_dielectric,
    has_surface: true,
    preview: |values| PreviewMaterial {
        specular: [values[0], values[1]],
        roughness: values[2][0],
        ..PreviewMaterial::default()
    },
    bsdf: Some(&Bsdf {
        pack: |values| {
            let mut parameters = BsdfParameters::default();
            parameters[..3].copy_from_slice(&values[0]);
            parameters[3] = values[2][0] * values[2][0];
            parameters[4..7].copy_from_slice(&values[1]);
            parameters[7] = values[4][0];
            parameters
        },
        is_delta: |parameters| parameters[3] < MIRROR_ALPHA,
        is_lambertian: false,
        focuses: |parameters| parameters[3] <= FOCUSING_ALPHA,
        transmits: |_| false,
        chooses_lobes: false,
        reads_albedos: |parameters| parameters[7] > 0.0,
        compensates: |parameters| parameters[7] > 0.0,
        at_wavelength: None,
        with_index: None,
        eval,
        sample,
        wgsl: include_str!("metal.wgsl"),
    }),
};

fn fresnel(parameters: &BsdfParameters, cosine: f32) -> Vec3 {
    schlick(colour_of(parameters), Vec3::from_slice(&parameters[4..7]), cosine)
}

/// Factor that gives back light lost between the facets.
fn compensation(parameters: &BsdfParameters, wo: Vec3) -> Vec3 {
    if parameters[7] == 0.0 {
        return Vec3::ONE;
    }
    let [a, b] = lookup(wo.z, parameters[3].sqrt());
    Vec3::ONE + colour_of(parameters) * (parameters[7] * (1.0 / (a + b) - 1.0))
}

fn eval(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, _inside: bool) -> Eval {
    let alpha = parameters[3];
    if wi.z <= 0.0 || alpha < MIRROR_ALPHA {
        return Eval::NONE;
    }
    let h = (wo + wi).normalize();
    let (value, pdf) = reflection(wo, wi, h, alpha);
    Eval { value: fresnel(parameters, wo.dot(h)) * compensation(parameters, wo) * value, pdf }
}

fn sample(parameters: &BsdfParameters, wo: Vec3, _inside: bool, [u, v, _]: [f32; 3]) -> Option<Scattered> {
    let alpha = parameters[3];
    if alpha < MIRROR_ALPHA {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        return Some(Scattered { wi, weight: fresnel(parameters, wo.z), pdf: 0.0, eta: 1.0 });
    }
    let h = visible_normal(wo, alpha, [u, v]);
    let wi = reflect(wo, h);
    if wi.z <= 0.0 {
        return None;
    }
    let (_, pdf) = reflection(wo, wi, h, alpha);
    let colour = fresnel(parameters, wo.dot(h)) * compensation(parameters, wo);
    Some(Scattered { wi, weight: colour * unshadowed(wo, wi, alpha), pdf, eta: 1.0 })
}
