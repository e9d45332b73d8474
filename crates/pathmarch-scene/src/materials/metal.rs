//! Metal: GGX reflection with height-correlated Smith masking, single scattering, coloured by Schlick's Fresnel factor
//! from `metal` at normal incidence to `edge` at grazing. Light that would bounce between the facets is lost: at
//! roughness 1 up to half of it. `multiscatter` scales the reflection so that it is given back (Turquin 2019), coloured by
//! the next bounce; this conserves energy but is not quite reciprocal. A `roughness` below 0.01 is a perfect mirror.

use super::albedo::lookup;
use super::microfacet::{FOCUSING_ALPHA, MIRROR_ALPHA, reflect, reflection, schlick, unshadowed, visible_normal};
use super::{
    Bsdf, BsdfInLanes, BsdfParameters, Eval, EvalInLanes, Facets, KindInLanes, MaterialKind, ParametersInLanes,
    PreviewMaterial, Scattered, ScatteredInLanes, Texturing, colour, emission, multiscatter, no_dielectric, roughness,
    vacuum,
};
use glam::Vec3;
use pathmarch_field::Range;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

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
        facets: Some(&Facets {
            share: |_, _, _, _| Vec3::ONE,
            alpha: |parameters| parameters[3],
            chance: |_, _, _| 1.0,
            are_coloured: |_| true,
        }),
        in_lanes: Some(KindInLanes::Metal),
        smooth_in_lanes: None,
        wgsl: include_str!("metal.wgsl"),
    }),
};

/// Metal for one path, or for eight.
struct Metal<N> {
    f0: FieldVec3<N>,
    f90: FieldVec3<N>,
    alpha: N,
    /// Factor that gives back light lost between the facets.
    compensation: FieldVec3<N>,
}

impl<N: Real> Metal<N> {
    /// Metal of these parameters, seen at this cosine; `compensates` if `multiscatter` is above 0 anywhere.
    #[inline(always)]
    fn new(parameters: [N; 8], cosine: N, compensates: bool) -> Self {
        let [r, g, b, alpha, edge_r, edge_g, edge_b, multiscatter] = parameters;
        let (f0, mut compensation) = (FieldVec3::new(r, g, b), FieldVec3::splat(N::one()));
        if compensates {
            let [a, b] = lookup(cosine, alpha.sqrt());
            compensation = compensation + f0 * (multiscatter * (N::one() / (a + b) - N::one()));
        }
        Self { f0, f90: FieldVec3::new(edge_r, edge_g, edge_b), alpha, compensation }
    }

    fn is_mirror(&self) -> N::Mask {
        self.alpha.lt(N::constant(MIRROR_ALPHA))
    }

    /// Reflected share of the light that falls on facets at this cosine.
    #[inline(always)]
    fn colour(&self, cosine: N) -> FieldVec3<N> {
        schlick(self.f0, self.f90, cosine)
    }

    /// Value and density of a direction; zero for a mirror.
    #[inline(always)]
    fn eval(&self, wo: FieldVec3<N>, wi: FieldVec3<N>) -> (FieldVec3<N>, N) {
        let h = (wo + wi).normalized();
        let (value, pdf) = reflection(wo, wi, h, self.alpha);
        let value = self.colour(wo.dot(h)).times(self.compensation) * value;
        let is_reflected = N::zero().lt(wi.z) & !self.is_mirror();
        (FieldVec3::select(is_reflected, value, FieldVec3::splat(N::zero())), N::select(is_reflected, pdf, N::zero()))
    }

    /// Direction, its weight and density (0 for a mirror); the light is lost where the direction points below the surface.
    #[inline(always)]
    fn sample(&self, wo: FieldVec3<N>, position: [N; 2]) -> (FieldVec3<N>, FieldVec3<N>, N) {
        let (is_mirror, up) = (self.is_mirror(), FieldVec3::constant([0.0, 0.0, 1.0]));
        let alpha = self.alpha.max(N::constant(MIRROR_ALPHA));
        let h = FieldVec3::select(is_mirror, up, visible_normal(wo, alpha, position));
        let wi = reflect(wo, h);
        let (_, pdf) = reflection(wo, wi, h, alpha);
        let weight = self.compensation * unshadowed(wo, wi, alpha);
        let weight = FieldVec3::select(is_mirror, FieldVec3::splat(N::one()), weight);
        (wi, self.colour(wo.dot(h)).times(weight), N::select(is_mirror, N::zero(), pdf))
    }
}

impl Metal<f32> {
    fn of(parameters: &BsdfParameters, wo: Vec3) -> Self {
        let numbers: [f32; 8] = std::array::from_fn(|k| parameters[k]);
        Self::new(numbers, wo.z, numbers[7] > 0.0)
    }
}

fn eval(parameters: &BsdfParameters, wo: Vec3, wi: Vec3, _inside: bool) -> Eval {
    let (value, pdf) = Metal::of(parameters, wo).eval(wo.into(), wi.into());
    Eval { value: value.into(), pdf }
}

fn sample(parameters: &BsdfParameters, wo: Vec3, _inside: bool, [u, v, _]: [f32; 3]) -> Option<Scattered> {
    let (wi, weight, pdf) = Metal::of(parameters, wo).sample(wo.into(), [u, v]);
    (wi.z > 0.0).then(|| Scattered { wi: wi.into(), weight: weight.into(), pdf, eta: 1.0 })
}

/// Metal for eight paths.
pub struct MetalInLanes(Metal<f32x8>);

impl BsdfInLanes for MetalInLanes {
    const PARAMETERS: usize = 8;

    #[inline(always)]
    fn new(parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, _inside: Mask8) -> Self {
        let numbers: [f32x8; 8] = std::array::from_fn(|k| parameters.first[k]);
        Self(Metal::new(numbers, wo.z, numbers[7].to_array() != [0.0; 8]))
    }

    #[inline(always)]
    fn eval(&self, _parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, wi: FieldVec3<f32x8>) -> EvalInLanes {
        let (value, pdf) = self.0.eval(wo, wi);
        EvalInLanes { value, pdf }
    }

    #[inline(always)]
    fn sample(&self, _parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, [u, v, _]: [f32x8; 3]) -> ScatteredInLanes {
        let (wi, weight, pdf) = self.0.sample(wo, [u, v]);
        ScatteredInLanes { wi, weight, pdf }
    }
}
