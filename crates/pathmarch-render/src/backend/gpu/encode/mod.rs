//! Encoding of a scene for the kernel's buffers.
//!
//! Leaves and materials have one layout for both backends. The other tables are encoded here: lights as records, textures, the sky's
//! sampling tables, the directional albedos of GGX and the data of the mode as words of one buffer.

mod light;
mod preview;
mod texture;

pub(super) use light::{KIND_NAMES, LightRecord};
pub(super) use preview::FIRST_LIGHT;
pub(super) use texture::{COLOURS, LEAF_WORDS, NUMBERS, ORBIT, OWN_COLOURS, PACKED, PICTURE, computed_kind};

use crate::backend::{ModeData, RenderInput};
use pathmarch_scene::materials::albedo;

/// Words that the kernel reads, and the offset of each table in them.
pub(crate) struct SceneData {
    pub(super) words: Vec<u32>,
    /// Texels of the environment map, row by row from the zenith; fourth numbers are unused.
    pub(super) sky_texels: Vec<[f32; 4]>,
    /// Offset of the alias tables of the environment map.
    pub(super) sky: usize,
    /// Offset of the directional albedos of GGX.
    pub(super) ggx: usize,
    /// Offset of leaves, materials and textures.
    pub(super) textures: usize,
    /// Offset of the data of the mode.
    pub(super) mode: usize,
}

impl SceneData {
    /// Encodes a scene and its mode.
    pub(super) fn new(input: &RenderInput) -> Self {
        let scene = &input.scene;
        let mut words: Vec<u32> =
            scene.sky.alias_tables().flat_map(|&(threshold, alias)| [threshold.to_bits(), alias]).collect();
        let texels = scene.sky.environment().map_or(&[][..], |environment| &environment.texels);
        let sky_texels = texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        let ggx = words.len();
        if scene.bsdfs.iter().flatten().any(|bsdf| bsdf.reads_albedos) {
            words.extend(albedo::table().iter().flatten().map(|value| value.to_bits()));
        }
        let textures = words.len();
        if input.config.textures {
            words.extend(texture::encode(&scene.field, &scene.textured_materials, textures));
        }
        let mode = words.len();
        match &input.data {
            ModeData::None => {}
            ModeData::Preview(data) => words.extend(preview::encode(data)),
            ModeData::View(table) => words.extend(table.iter().map(|number| number.to_bits())),
        }
        Self { words, sky_texels, sky: 0, ggx, textures, mode }
    }
}
