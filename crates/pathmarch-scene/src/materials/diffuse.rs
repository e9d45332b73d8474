//! Lambertian reflection: the same radiance in every direction (Lambert 1760, "Photometria"). BRDF albedo / π, sampled
//! by the cosine (Malley's method; Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th ed. 2023, section
//! A.5.3), so that the weight of a sample is the albedo.

use super::{
    no_dielectric, vacuum, Bsdf, BsdfParameters, Eval, MaterialKind, PreviewMaterial, Scattered, Texturing, colour, colour_of, emission,
};
use glam::Vec3;
use pathmarch_field::Range;
use std::f32::consts::{PI, TAU};

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "diffuse",
    doc: "Matt surface that looks equally bright from everywhere.",
    source: "Lambert 1760, Photometria",
    params: &[
        colour(
            "albedo",
            0.8,
            Range::from_to(0.0, 1.0),
            "Fraction of the light that is reflected.",
            Texturing::Colour(0),
        ),
        emission(),
    ],
    albedo: |values| values[0],
    emission: |values| values[1],
    medium: vacuum,
    dielectric: no_dielectric,
    has_surface: true,
    preview: |values| PreviewMaterial { diffuse: values[0], ..PreviewMaterial::default() },
    bsdf: Some(&Bsdf {
        pack: |values| {
            let [r, g, b] = values[0];
            let mut parameters = BsdfParameters::default();
            parameters[..3].copy_from_slice(&[r, g, b]);
            parameters
        },
        is_delta: |_| false,
        is_lambertian: true,
        focuses: |_| false,
        transmits: |_| false,
        chooses_lobes: false,
        reads_albedos: |_| false,
        compensates: |_| false,
        at_wavelength: None,
        with_index: None,
        eval,
        sample,
        wgsl: include_str!("diffuse.wgsl"),
    }),
};

fn eval(parameters: &BsdfParameters, _wo: Vec3, wi: Vec3, _inside: bool) -> Eval {
    let pdf = wi.z.max(0.0) / PI;
    Eval { value: colour_of(parameters) * pdf, pdf }
}

fn sample(parameters: &BsdfParameters, _wo: Vec3, _inside: bool, [u, v, _]: [f32; 3]) -> Option<Scattered> {
    let wi = cosine_direction([u, v]);
    Some(Scattered { wi, weight: colour_of(parameters), pdf: wi.z / PI, eta: 1.0 })
}

/// A direction about z, its density cosine/π over solid angle.
pub(super) fn cosine_direction([u, v]: [f32; 2]) -> Vec3 {
    let radius = u.sqrt();
    let (sine, cosine) = (TAU * v).sin_cos();
    Vec3::new(radius * cosine, radius * sine, (1.0 - u).max(1e-8).sqrt())
}
