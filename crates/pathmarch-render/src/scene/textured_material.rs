//! Textured materials: the parameters of a material that vary along surfaces.
//!
//! A material is packed into the parameters of its BSDF. Textures, orbit traps ([`OrbitTrap`]) and decals replace some of
//! them at each surface interaction. A colour is replaced directly. For any other parameter, the material is packed in
//! advance for [`KNOTS`] values, and parameters between two knots are interpolated: the parameters of `principled` are
//! integrals that take too long for a path. The flags of a material (transmission, delta distribution) are the same
//! everywhere on it.

use super::preview_material::{self, PreviewParameters};
use crate::wgsl::shared_constants;
use pathmarch_scene::materials::{
    Bsdf, BsdfParameters, Bump, Material, NormalMap, OrbitTrap, TextureMapping, Texturing,
};
use pathmarch_scene::textures::{Decal, Pattern, Ramp, Texture};

shared_constants! {
    /// Number of values of a parameter for which the material is packed.
    pub(crate) const KNOTS: usize = 17;
}

/// Source of a value from 0 to 1 or of a colour.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Orbit(OrbitTrap),
    Texture(Texture),
    /// A picture over the colour of the layers before.
    Decal(Decal),
}

/// Parameters of the BSDF that a layer replaces.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    /// Three parameters from index `first` on: a colour of the ramp, or that of the texture without a ramp.
    Colour { first: usize, ramp: Option<Ramp> },
    /// Parameters at these indices, and their values at each knot.
    Parameters { indices: Vec<usize>, knots: Vec<Vec<f32>> },
}

/// Texture, orbit trap or decal that replaces parameters of a material.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) source: Source,
    pub(crate) change: Change,
    /// Change of the preview material: its derivative by the colour, or its values at the knots minus those without the
    /// texture.
    pub(crate) previews: Vec<PreviewParameters>,
    /// Colour of the material without the texture.
    pub(crate) base: [f32; 3],
}

/// Textures, bump map, normal map, orbit trap and decals of a material.
#[derive(Clone, Debug, Default)]
pub(crate) struct TexturedMaterial {
    pub(crate) layers: Vec<Layer>,
    pub(crate) bump: Option<Bump>,
    pub(crate) normal_map: Option<NormalMap>,
    /// Emitted radiance, in place of that of the material.
    pub(crate) emission: Option<Texture>,
}

impl TexturedMaterial {
    pub(crate) fn new(material: &Material) -> Self {
        let Some(bsdf) = material.kind.bsdf else { return Self::default() };
        let mut layers: Vec<Layer> = Vec::new();
        for textured in &material.textured {
            let source = Source::Texture(textured.texture.clone());
            let layer = match (material.kind.params[textured.param].texturing, &textured.mapping) {
                (Texturing::Colour(first), TextureMapping::Ramp(ramp)) => {
                    Layer::of_colour(material, textured.param, first, source, Some(ramp.clone()))
                }
                (Texturing::Colour(first), _) => Layer::of_colour(material, textured.param, first, source, None),
                (_, TextureMapping::Range(range)) => Layer::of_number(material, bsdf, textured.param, source, *range),
                _ => continue,
            };
            layers.push(layer);
        }
        // The orbit trap comes after textures, as it replaces them on fractals, and decals are above all.
        if let Some(Texturing::Colour(first)) = material.kind.params.first().map(|param| param.texturing) {
            if let Some(trap) = &material.orbit_trap {
                let ramp = Some(trap.ramp.clone());
                layers.push(Layer::of_colour(material, 0, first, Source::Orbit(trap.clone()), ramp));
            }
            let decals = material.decals.iter().map(|decal| Source::Decal(decal.clone()));
            layers.extend(decals.map(|decal| Layer::of_colour(material, 0, first, decal, None)));
        }
        let (normal_map, emission) = (material.normal_map.clone(), material.emission_texture.clone());
        Self { layers, bump: material.bump.clone(), normal_map, emission }
    }

    /// Reports whether the material is the same everywhere.
    pub(crate) fn is_plain(&self) -> bool {
        self.layers.is_empty() && self.bump.is_none() && self.normal_map.is_none() && self.emission.is_none()
    }

    pub(crate) fn has_bump(&self) -> bool {
        self.bump.is_some()
    }

    pub(crate) fn has_uv_textures(&self) -> bool {
        self.textures().any(|texture| matches!(texture.pattern, Pattern::UvPicture { .. }))
    }

    pub(crate) fn has_orbit(&self) -> bool {
        self.trap_centre().is_some()
    }

    /// Centre of the orbit trap, in the local coordinates of the fractal.
    pub(crate) fn trap_centre(&self) -> Option<[f32; 3]> {
        self.layers.iter().find_map(|layer| match &layer.source {
            Source::Orbit(trap) => Some(trap.centre),
            Source::Texture(_) | Source::Decal(_) => None,
        })
    }

    pub(crate) fn has_decals(&self) -> bool {
        self.layers.iter().any(|layer| matches!(layer.source, Source::Decal(_)))
    }

    /// Textures of all layers, of the bump and normal map, and of the emission.
    pub(crate) fn textures(&self) -> impl Iterator<Item = &Texture> {
        let of_layers = self.layers.iter().filter_map(|layer| match &layer.source {
            Source::Texture(texture) => Some(texture),
            Source::Orbit(_) | Source::Decal(_) => None,
        });
        let maps = self.bump.iter().map(|bump| &bump.texture).chain(self.normal_map.iter().map(|map| &map.texture));
        of_layers.chain(maps).chain(&self.emission)
    }

    /// Parameters at all knots of all layers. They decide whether the material transmits or is a delta distribution.
    pub(crate) fn knot_parameters(&self, untextured: &BsdfParameters) -> Vec<BsdfParameters> {
        let mut all_parameters = Vec::new();
        for layer in &self.layers {
            if let Change::Parameters { indices, knots } = &layer.change {
                all_parameters.extend(knots.iter().map(|knot| {
                    let mut parameters = *untextured;
                    indices.iter().zip(knot).for_each(|(index, parameter)| parameters[*index] = *parameter);
                    parameters
                }));
            }
        }
        all_parameters
    }
}

impl Layer {
    /// Layer that replaces a colour.
    fn of_colour(material: &Material, param: usize, first: usize, source: Source, ramp: Option<Ramp>) -> Self {
        let preview_of = |grey: f32| {
            let mut values = material.values.clone();
            values[param] = [grey; 3];
            preview_material::encode(&(material.kind.preview)(&values))
        };
        let (black, white) = (preview_of(0.0), preview_of(1.0));
        // Roughness and index of refraction have no channels.
        let derivative = std::array::from_fn(|k| if k == 3 || k == 13 { 0.0 } else { white[k] - black[k] });
        let change = Change::Colour { first, ramp };
        Self { source, change, previews: vec![derivative], base: material.values[param] }
    }

    /// Layer that replaces a scalar parameter.
    fn of_number(material: &Material, bsdf: &Bsdf, param: usize, source: Source, [from, to]: [f32; 2]) -> Self {
        let values: Vec<Vec<[f32; 3]>> = (0..KNOTS)
            .map(|k| {
                let mut values = material.values.clone();
                values[param][0] = from + (to - from) * k as f32 / (KNOTS - 1) as f32;
                values
            })
            .collect();
        let packed: Vec<BsdfParameters> = values.iter().map(|values| (bsdf.pack)(values)).collect();
        let indices: Vec<usize> =
            (0..packed[0].len()).filter(|&k| packed.iter().any(|parameters| parameters[k] != packed[0][k])).collect();
        let knots = packed.iter().map(|parameters| indices.iter().map(|&index| parameters[index]).collect()).collect();
        let untextured = preview_material::encode(&material.preview());
        let previews = values.iter().map(|values| {
            let preview = preview_material::encode(&(material.kind.preview)(values));
            std::array::from_fn(|k| preview[k] - untextured[k])
        });
        Self { source, change: Change::Parameters { indices, knots }, previews: previews.collect(), base: [0.0; 3] }
    }
}
