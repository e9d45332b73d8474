//! Medium without a surface: smoke, mist, a flame. Light passes its boundary straight and unchanged, and is scattered and
//! absorbed inside. It adds to the media around it. Rays of light pass its boundary without a bounce.

use super::{
    Bsdf, BsdfParameters, Eval, MaterialKind, PreviewMaterial, Scattered, absorption, anisotropy, black, glow,
    no_dielectric, scattering,
};
use crate::medium::Medium;
use glam::Vec3;

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "medium",
    doc: "Smoke, mist or a flame: scatters and absorbs inside, without a surface.",
    source: "Chandrasekhar 1950; Henyey and Greenstein 1941",
    params: &[scattering("scattering", 1.0), absorption(), anisotropy(), glow()],
    albedo,
    emission: black,
    medium: |values| Medium {
        scattering: values[0],
        absorption: values[1],
        anisotropy: values[2][0],
        emission: values[3],
    },
    dielectric: no_dielectric,
    has_surface: false,
    preview: |_| PreviewMaterial { transmission: [1.0; 3], ior: 1.0, ..PreviewMaterial::default() },
    bsdf: Some(&Bsdf {
        pack: |_| BsdfParameters::default(),
        is_delta: |_| true,
        is_lambertian: false,
        focuses: |_| false,
        transmits: |_| true,
        chooses_lobes: false,
        reads_albedos: |_| false,
        compensates: |_| false,
        at_wavelength: None,
        with_index: None,
        eval: |_, _, _, _| Eval::NONE,
        sample: |_, wo, _, _| Some(Scattered { wi: -wo, weight: Vec3::ONE, pdf: 0.0, eta: 1.0 }),
        facets: None,
        in_lanes: None,
        smooth_in_lanes: None,
        wgsl: include_str!("medium.wgsl"),
    }),
};

/// Fraction of the light that is scattered where light meets a particle.
fn albedo(values: &[[f32; 3]]) -> [f32; 3] {
    std::array::from_fn(|c| values[0][c] / (values[0][c] + values[1][c]).max(1e-30))
}
