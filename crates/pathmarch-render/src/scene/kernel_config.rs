//! Kernel configuration: the features of the estimator that a scene uses.

use super::RenderScene;
use super::leaf::MESH_FIELD;
use super::light::LightShape;
use super::material::{BOUNDARY, DISPERSES, TRANSMITS};
use super::textured_material::TexturedMaterial;
use crate::mode::Mode;
use crate::settings::Settings;
use pathmarch_scene::{Caustics, DirectLighting};

/// Over-relaxation factor. With 2, a step ends where two neighbouring unbounding spheres just touch by the estimated
/// slope.
pub(crate) const RELAXATION: f32 = 1.9;

/// Configuration of the estimator. Its values are constants of a kernel, so that a scene pays only for the features it
/// uses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelConfig {
    /// Some solid absorbs.
    pub(crate) absorption: bool,
    /// Some medium scatters or emits light, or is anywhere but in solids with a surface; or dielectrics are nested.
    pub(crate) media: bool,
    /// Some material is the boundary of a medium.
    pub(crate) boundaries: bool,
    /// Every object with a transmissive surface is finite.
    pub(crate) media_are_bounded: bool,
    /// Some light may be inside a solid that displaces the fog.
    pub(crate) lights_in_solids: bool,
    /// Some material transmits.
    pub(crate) transmission: bool,
    /// Some BSDF takes a third random number, for the choice of its lobe.
    pub(crate) chooses_lobes: bool,
    /// Some solid that transmits has a priority: where solids overlap, the highest one fills the space.
    pub(crate) nested_dielectrics: bool,
    /// Some material disperses light.
    pub(crate) dispersion: bool,
    /// Shadow rays pass through clear glass.
    pub(crate) fast_caustics: bool,
    /// Light paths trace caustics, see [`photons`](crate::integrator::photons).
    pub(crate) traced_caustics: bool,
    /// Some light has shadows that are softened by near misses.
    pub(crate) penumbra: bool,
    /// Some material is textured.
    pub(crate) textures: bool,
    /// Some material has decals.
    pub(crate) decals: bool,
    /// Some texture is at the texture coordinates of meshes.
    pub(crate) uv_textures: bool,
    /// Some leaf is a [`MESH_FIELD`].
    pub(crate) mesh_fields: bool,
    /// An orbit trap colours some material.
    pub(crate) orbits: bool,
    /// Some material has a bump map.
    pub(crate) bump: bool,
    /// Some material has a normal map.
    pub(crate) normal_maps: bool,
    /// Some material has an emission that varies.
    pub(crate) emission_textures: bool,
    /// Shading normals differ from geometric ones: by bump or normal maps, or by the normals of a mesh.
    pub(crate) shading_normals: bool,
    pub(crate) direct_lighting: DirectLighting,
    /// [`RELAXATION`], or 0 for plain sphere tracing.
    pub(crate) relaxation: f32,
    /// Paths that share a camera ray.
    pub(crate) splitting: u32,
    /// Light samples at the first surface of a path; one elsewhere.
    pub(crate) light_samples: u32,
    /// Rays that leave the first surface of a path, each with a path of its own behind it; one elsewhere.
    pub(crate) indirect_samples: u32,
    /// Pixels share the light at second surfaces, see [`path_reuse`](crate::integrator::path_reuse).
    pub(crate) path_reuse: bool,
    /// On a software adapter, the numbers of the field and of the frame are constants of the kernel, so that it suits one
    /// picture only.
    pub(crate) constant_numbers: bool,
    /// Grazing rays use a smaller hit tolerance. True where some sphere-traced object emits and none is a fractal,
    /// because the tolerance enlarges every emitter.
    pub(crate) refined_grazing: bool,
    /// All rays are intersected in closed form, and no medium but those that absorb inside solids takes part: on the CPU, paths
    /// stay in lanes from the camera to their ends, see [`packets`](crate::integrator::packets).
    pub(crate) packets: bool,
}

impl KernelConfig {
    pub(crate) fn new(scene: &RenderScene, settings: &Settings) -> Self {
        let transmits = scene.materials.iter().any(|material| material.has(TRANSMITS));
        let penumbra = |shape: &LightShape| shape.penumbra() > 0.0;
        let textured = |has: fn(&TexturedMaterial) -> bool| scene.textured_materials.iter().any(has);
        let nested_dielectrics = scene.has_nested_dielectrics();
        let media = nested_dielectrics || scene.media.participate();
        let config = Self {
            absorption: media || scene.materials.iter().any(|material| material.absorption != [0.0; 3]),
            media,
            boundaries: media && scene.materials.iter().any(|material| material.has(BOUNDARY)),
            media_are_bounded: scene.has_bounded_media(),
            lights_in_solids: media && scene.has_lights_in_solids(),
            transmission: transmits,
            chooses_lobes: scene.bsdfs.iter().flatten().any(|bsdf| bsdf.chooses_lobes),
            nested_dielectrics,
            dispersion: scene.materials.iter().any(|material| material.has(DISPERSES)),
            fast_caustics: settings.caustics == Caustics::Fast && transmits,
            traced_caustics: false,
            penumbra: scene.lights.iter().any(|light| penumbra(&light.shape)),
            textures: textured(|material| !material.is_plain()),
            decals: textured(TexturedMaterial::has_decals),
            uv_textures: textured(TexturedMaterial::has_uv_textures),
            mesh_fields: scene.leaves.iter().any(|leaf| leaf.has(MESH_FIELD)),
            orbits: textured(TexturedMaterial::has_orbit),
            bump: textured(TexturedMaterial::has_bump),
            normal_maps: textured(|material| material.normal_map.is_some()),
            emission_textures: textured(|material| material.emission.is_some()),
            shading_normals: textured(|material| material.has_bump() || material.normal_map.is_some())
                || scene.field.has_shading_normals(),
            direct_lighting: settings.direct_lighting,
            relaxation: RELAXATION,
            splitting: if settings.mode == Mode::Path { settings.splitting.unwrap_or(1) } else { 1 },
            light_samples: 1,
            indirect_samples: 1,
            path_reuse: false,
            constant_numbers: false,
            refined_grazing: scene.has_sphere_traced_emitter(),
            packets: false,
        };
        let is_closed_form = !scene.is_sphere_traced() && !scene.field.has_triangles() && !config.mesh_fields;
        let is_plain = !config.media && !config.dispersion && !config.penumbra && !config.shading_normals;
        Self { packets: is_closed_form && is_plain, ..config }
    }
}
