//! Lambertian reflection: the same radiance in every direction (Lambert 1760, "Photometria"). BRDF albedo / π, sampled
//! by the cosine (Malley's method; Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th ed. 2023, section
//! A.5.3), so that the weight of a sample is the albedo.

use super::{
    Bsdf, BsdfInLanes, BsdfParameters, Eval, EvalInLanes, KindInLanes, MaterialKind, ParametersInLanes,
    PreviewMaterial, Scattered, ScatteredInLanes, Texturing, colour, colour_of, emission, no_dielectric, vacuum,
};
use glam::Vec3;
use pathmarch_field::Range;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3, unit_circle};
use std::f32::consts::FRAC_1_PI;
use wide::f32x8;

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
        facets: None,
        in_lanes: Some(KindInLanes::Diffuse),
        smooth_in_lanes: None,
        wgsl: include_str!("diffuse.wgsl"),
    }),
};

fn eval(parameters: &BsdfParameters, _wo: Vec3, wi: Vec3, _inside: bool) -> Eval {
    let pdf = wi.z.max(0.0) * FRAC_1_PI;
    Eval { value: colour_of(parameters) * pdf, pdf }
}

fn sample(parameters: &BsdfParameters, _wo: Vec3, _inside: bool, [u, v, _]: [f32; 3]) -> Option<Scattered> {
    let wi = cosine_direction([u, v]);
    Some(Scattered { wi: wi.into(), weight: colour_of(parameters), pdf: wi.z * FRAC_1_PI, eta: 1.0 })
}

/// Lambertian reflection of these albedos for eight paths.
pub struct DiffuseInLanes(FieldVec3<f32x8>);

impl BsdfInLanes for DiffuseInLanes {
    const PARAMETERS: usize = 3;

    #[inline(always)]
    fn new(parameters: &ParametersInLanes, _wo: FieldVec3<f32x8>, _inside: Mask8) -> Self {
        let [r, g, b, ..] = parameters.first;
        Self(FieldVec3::new(r, g, b))
    }

    #[inline(always)]
    fn eval(&self, _parameters: &ParametersInLanes, _wo: FieldVec3<f32x8>, wi: FieldVec3<f32x8>) -> EvalInLanes {
        let pdf = wi.z.max(f32x8::ZERO) * f32x8::splat(FRAC_1_PI);
        EvalInLanes { value: self.0 * pdf, pdf }
    }

    #[inline(always)]
    fn sample(
        &self,
        _parameters: &ParametersInLanes,
        _wo: FieldVec3<f32x8>,
        [u, v, _]: [f32x8; 3],
    ) -> ScatteredInLanes {
        let wi = cosine_direction([u, v]);
        ScatteredInLanes { wi, weight: self.0, pdf: wi.z * f32x8::splat(FRAC_1_PI) }
    }
}

/// A direction about z, its density cosine/π over solid angle.
#[inline(always)]
pub(super) fn cosine_direction<N: Real>([u, v]: [N; 2]) -> FieldVec3<N> {
    let radius = u.sqrt();
    let [cosine, sine] = unit_circle(v);
    FieldVec3::new(radius * cosine, radius * sine, (N::one() - u).max(N::constant(1e-8)).sqrt())
}
