//! Parameters of preview materials, in the order of `preview/preview.wgsl`.

use crate::wgsl::shared_constants;
use pathmarch_scene::materials::PreviewMaterial;

shared_constants! {
    /// Number of parameters of a preview material: diffuse albedo, roughness, specular reflectance at normal incidence
    /// and at grazing angles, transmittance, index of refraction.
    pub(crate) const PREVIEW_PARAMETERS: usize = 14;
}

/// Parameters of a preview material as an array.
pub(crate) type PreviewParameters = [f32; PREVIEW_PARAMETERS];

/// Encodes a preview material as an array.
pub(crate) fn encode(material: &PreviewMaterial) -> PreviewParameters {
    let [f0, f90] = material.specular;
    let mut parameters = [0.0; PREVIEW_PARAMETERS];
    parameters[..3].copy_from_slice(&material.diffuse);
    parameters[3] = material.roughness;
    parameters[4..7].copy_from_slice(&f0);
    parameters[7..10].copy_from_slice(&f90);
    parameters[10..13].copy_from_slice(&material.transmission);
    parameters[13] = material.ior;
    parameters
}

/// Decodes a preview material from an array.
pub(crate) fn decode(parameters: &PreviewParameters) -> PreviewMaterial {
    let colour = |first: usize| [parameters[first], parameters[first + 1], parameters[first + 2]];
    PreviewMaterial {
        diffuse: colour(0),
        roughness: parameters[3],
        specular: [colour(4), colour(7)],
        transmission: colour(10),
        ior: parameters[13],
    }
}

/// Colour channel that a parameter depends on.
pub(crate) fn channel(parameter: usize) -> usize {
    if parameter < 3 { parameter } else { parameter.saturating_sub(4) % 3 }
}
