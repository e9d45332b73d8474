//! Encoding of a preview's data, which `preview/preview.wgsl` decodes.

use crate::preview::Preview;
use crate::wgsl::shared_constants;

shared_constants! {
    /// Offset of the lights in the data: after nine colours, the reach and the number of lights. The preview materials follow.
    pub(crate) const FIRST_LIGHT: u32 = 29;
}

/// Encodes the data of a preview.
pub(super) fn encode(preview: &Preview) -> Vec<u32> {
    let mut words: Vec<u32> = preview.ambient.iter().flat_map(|factor| factor.to_array().map(f32::to_bits)).collect();
    words.extend([preview.occlusion_distance.to_bits(), preview.lights.len() as u32]);
    debug_assert_eq!(words.len(), FIRST_LIGHT as usize);
    words.extend(preview.lights.iter().flat_map(|(index, radius)| [*index, radius.to_bits()]));
    words.extend(preview.materials.as_flattened().iter().map(|number| number.to_bits()));
    words
}
