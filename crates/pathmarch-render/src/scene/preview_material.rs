//! BsdfParameters of a material for previews, in the order of `preview/preview.wgsl`.

use crate::wgsl::shared_constants;
use pathmarch_scene::materials::PreviewMaterial;

shared_constants! {
    /// BsdfParameters of a preview material: diffuse albedo, roughness, reflectance straight on and at grazing angles, transmittance, index
    /// of refraction.
    pub(crate) const PREVIEW_SIZE: usize = 14;
}

pub(crate) type PreviewNumbers = [f32; PREVIEW_SIZE];

/// Encodes a preview material.
pub(crate) fn to_numbers(material: &PreviewMaterial) -> PreviewNumbers {
    let [straight, grazing] = material.specular;
    let mut numbers = [0.0; PREVIEW_SIZE];
    numbers[..3].copy_from_slice(&material.diffuse);
    numbers[3] = material.roughness;
    numbers[4..7].copy_from_slice(&straight);
    numbers[7..10].copy_from_slice(&grazing);
    numbers[10..13].copy_from_slice(&material.transmission);
    numbers[13] = material.ior;
    numbers
}

/// Decodes a preview material.
pub(crate) fn from_numbers(numbers: &PreviewNumbers) -> PreviewMaterial {
    let three = |at: usize| [numbers[at], numbers[at + 1], numbers[at + 2]];
    PreviewMaterial {
        diffuse: three(0),
        roughness: numbers[3],
        specular: [three(4), three(7)],
        transmission: three(10),
        ior: numbers[13],
    }
}

/// Channel of a colour that a number depends on.
pub(crate) fn channel(number: usize) -> usize {
    if number < 3 { number } else { number.saturating_sub(4) % 3 }
}
