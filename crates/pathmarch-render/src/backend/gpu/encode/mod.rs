//! Encoding of a scene for the kernel's buffers.
//!
//! Leaves and materials have the same layout on both backends. This module encodes the other tables: lights as records, and
//! textures, the sky's alias tables, the directional albedos of GGX, the data of the mode and meshes as words of one buffer.

pub(super) mod light;
pub(super) mod preview;
pub(super) mod texture;

pub(super) use light::LightRecord;
pub(super) use texture::computed_kind;

use crate::backend::{ModeData, RenderInput};
use crate::scene::{LightTree, Media, Medium, SkyLight};
use crate::wgsl::write_constant;
use pathmarch_field::wgsl::Program;
use pathmarch_scene::Sampler;
use pathmarch_scene::materials::albedo;

/// Words of the scene-data buffer, and the offset of each table.
pub(crate) struct SceneData {
    pub(super) words: Vec<u32>,
    /// Texels of the environment map, row by row from the zenith, with an unused component, and nodes of the light tree.
    pub(super) vectors: Vec<[f32; 4]>,
    /// Offset of the nodes among the vectors.
    pub(super) light_tree: usize,
    /// Offset of the photon map, which follows the vectors in their buffer.
    pub(super) photons: usize,
    /// Offset of the alias tables of the environment map.
    pub(super) sky: usize,
    /// Offset of the directional albedos of GGX.
    pub(super) ggx: usize,
    /// Offset of leaves, materials and textures.
    pub(super) textures: usize,
    /// Offset of the data of the mode.
    pub(super) mode: usize,
    /// Offset of the emitting triangles.
    pub(super) mesh_lights: usize,
    /// Offset of the meshes.
    pub(super) meshes: usize,
    /// Offset of the media: the fog, then those of the materials.
    pub(super) media: usize,
    /// Offset of the dielectric of each leaf.
    pub(super) dielectrics: usize,
    /// Offset of the pixels at edges of emitters.
    pub(super) edges: usize,
}

impl SceneData {
    /// Encodes a scene and its mode. `stored_tree` is the light tree if it is in storage memory.
    pub(super) fn new(input: &RenderInput, program: &Program, stored_tree: Option<&LightTree>) -> Self {
        let scene = &input.scene;
        let mut words: Vec<u32> =
            scene.sky.alias_tables().flat_map(|&(threshold, alias)| [threshold.to_bits(), alias]).collect();
        let texels = scene.sky.environment().map_or(&[][..], |environment| &environment.texels);
        let mut vectors: Vec<_> = texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        let light_tree = vectors.len();
        if let Some(tree) = stored_tree {
            vectors.extend_from_slice(bytemuck::cast_slice(&tree.nodes));
        }
        let photons = vectors.len();
        let ggx = words.len();
        if scene.any_bsdf(|bsdf| bsdf.reads_albedos) {
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
        let mesh_lights = words.len();
        words.extend(light::encode_mesh_lights(scene, mesh_lights));
        let meshes = words.len();
        words.extend(program.mesh_words());
        let media = words.len();
        if input.config.media {
            let Media { fog, of_materials, .. } = &scene.media;
            words.extend(std::iter::once(fog).chain(of_materials).flat_map(Medium::words));
        }
        let dielectrics = words.len();
        if input.config.nested_dielectrics {
            words.extend((0..scene.leaves.len()).flat_map(|leaf| scene.dielectric_words(leaf)));
        }
        let edges = words.len();
        words.extend(input.edges.iter().flat_map(|edges| edges.pixels()));
        Self {
            words,
            vectors,
            light_tree,
            photons,
            sky: 0,
            ggx,
            textures,
            mode,
            mesh_lights,
            meshes,
            media,
            dielectrics,
            edges,
        }
    }
}

/// Kind of a sky.
#[derive(Clone, Copy)]
pub(super) enum SkyKind {
    Constant,
    Gradient,
    Environment,
}

/// Kind of a sky, for the kernel.
pub(super) fn sky_kind(sky: &SkyLight) -> SkyKind {
    match (sky.environment(), sky.is_gradient()) {
        (Some(_), _) => SkyKind::Environment,
        (None, true) => SkyKind::Gradient,
        (None, false) => SkyKind::Constant,
    }
}

/// Kinds of skies in WGSL.
pub(super) fn sky_kinds_wgsl() -> String {
    let mut code = String::new();
    write_constant(&mut code, &[], "SKY_CONSTANT", &(SkyKind::Constant as u32));
    write_constant(&mut code, &[], "SKY_GRADIENT", &(SkyKind::Gradient as u32));
    code
}

/// Kinds of samplers in WGSL.
pub(super) fn samplers_wgsl() -> String {
    let mut code = String::new();
    write_constant(&mut code, &[], "INDEPENDENT", &(Sampler::Independent as u32));
    code
}
