//! Textured materials: which parameters of a material vary along surfaces, and how.
//!
//! A material is packed into the parameters that its BSDF reads. Where textures or an orbit trap ([`OrbitTrap`]) stand for
//! parameters, each surface interaction has parameters of its own. A colour is put in its place there. For any other parameter
//! the material is packed for [`KNOTS`] values of it in advance, and values between two of these are interpolated: the
//! parameters of `principled` are integrals that take too long for a path. Whether a material transmits and whether it scatters in
//! single directions is decided once for the whole of it.

use super::preview_material::{self, PreviewNumbers};
use crate::wgsl::shared_constants;
use pathmarch_scene::materials::{Bsdf, BsdfParameters, Bump, Material, OrbitTrap, TextureMapping, Texturing};
use pathmarch_scene::textures::Texture;

shared_constants! {
    /// Values of a parameter for which its material is packed.
    pub(crate) const KNOTS: usize = 17;
}

/// Source of a value from 0 to 1, or of a colour.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Orbit(OrbitTrap),
    Texture(Texture),
}

/// Parameters that a layer changes.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    /// The three parameters from this place on: a colour of this ramp, or the texture's own.
    Colour { place: usize, colours: Option<Vec<[f32; 3]>> },
    /// The parameters at these places, for each knot.
    BsdfParameters { places: Vec<usize>, knots: Vec<Vec<f32>> },
}

/// Texture or orbit trap that stands for parameters of a material.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) source: Source,
    pub(crate) change: Change,
    /// Change of the preview material: its slope over the colour, or its values at the knots less those without the texture.
    pub(crate) previews: Vec<PreviewNumbers>,
    /// Colour without the texture.
    pub(crate) base: [f32; 3],
}

/// Textures, bump map and orbit trap of a material.
#[derive(Clone, Debug, Default)]
pub(crate) struct TexturedMaterial {
    pub(crate) layers: Vec<Layer>,
    pub(crate) bump: Option<Bump>,
}

impl TexturedMaterial {
    pub(crate) fn new(material: &Material) -> Self {
        let Some(bsdf) = material.kind.bsdf else { return Self::default() };
        let mut layers: Vec<Layer> = Vec::new();
        for painted in &material.textured {
            let source = Source::Texture(painted.texture.clone());
            let layer = match (material.kind.params[painted.param].texturing, &painted.mapping) {
                (Texturing::Colour(place), TextureMapping::Ramp(colours)) => {
                    Layer::of_colour(material, painted.param, place, source, Some(colours.clone()))
                }
                (Texturing::Colour(place), _) => Layer::of_colour(material, painted.param, place, source, None),
                (_, TextureMapping::Range(range)) => Layer::of_number(material, bsdf, painted.param, source, *range),
                _ => continue,
            };
            layers.push(layer);
        }
        // The orbit trap comes last: on fractals it replaces textures.
        if let Some(trap) = &material.orbit_trap
            && let Some(Texturing::Colour(place)) = material.kind.params.first().map(|param| param.texturing)
        {
            let colours = Some(trap.colours.clone());
            layers.push(Layer::of_colour(material, 0, place, Source::Orbit(trap.clone()), colours));
        }
        Self { layers, bump: material.bump.clone() }
    }

    /// Whether nothing varies.
    pub(crate) fn is_plain(&self) -> bool {
        self.layers.is_empty() && self.bump.is_none()
    }

    pub(crate) fn has_bump(&self) -> bool {
        self.bump.is_some()
    }

    pub(crate) fn has_orbit(&self) -> bool {
        self.layers.iter().any(|layer| matches!(layer.source, Source::Orbit(_)))
    }

    /// Textures of all layers and of the bump map.
    pub(crate) fn textures(&self) -> impl Iterator<Item = &Texture> {
        let of_layers = self.layers.iter().filter_map(|layer| match &layer.source {
            Source::Texture(texture) => Some(texture),
            Source::Orbit(_) => None,
        });
        of_layers.chain(self.bump.iter().map(|bump| &bump.texture))
    }

    /// Parameters at all knots of all layers: what decides whether the material transmits or is a delta distribution.
    pub(crate) fn extremes(&self, numbers: &BsdfParameters) -> Vec<BsdfParameters> {
        let mut all = Vec::new();
        for layer in &self.layers {
            if let Change::BsdfParameters { places, knots } = &layer.change {
                all.extend(knots.iter().map(|knot| {
                    let mut own = *numbers;
                    places.iter().zip(knot).for_each(|(place, number)| own[*place] = *number);
                    own
                }));
            }
        }
        all
    }
}

impl Layer {
    fn of_colour(
        material: &Material,
        param: usize,
        place: usize,
        source: Source,
        colours: Option<Vec<[f32; 3]>>,
    ) -> Self {
        let preview_of = |grey: f32| {
            let mut values = material.values.clone();
            values[param] = [grey; 3];
            preview_material::to_numbers(&(material.kind.preview)(&values))
        };
        let (black, white) = (preview_of(0.0), preview_of(1.0));
        // Roughness and index of refraction have no channels.
        let slope = std::array::from_fn(|k| if k == 3 || k == 13 { 0.0 } else { white[k] - black[k] });
        let change = Change::Colour { place, colours };
        Self { source, change, previews: vec![slope], base: material.values[param] }
    }

    fn of_number(material: &Material, bsdf: &Bsdf, param: usize, source: Source, [from, to]: [f32; 2]) -> Self {
        let values: Vec<Vec<[f32; 3]>> = (0..KNOTS)
            .map(|k| {
                let mut values = material.values.clone();
                values[param][0] = from + (to - from) * k as f32 / (KNOTS - 1) as f32;
                values
            })
            .collect();
        let packed: Vec<BsdfParameters> = values.iter().map(|values| (bsdf.pack)(values)).collect();
        let places: Vec<usize> =
            (0..packed[0].len()).filter(|&k| packed.iter().any(|numbers| numbers[k] != packed[0][k])).collect();
        let knots = packed.iter().map(|numbers| places.iter().map(|&place| numbers[place]).collect()).collect();
        let middle = preview_material::to_numbers(&material.preview());
        let previews = values.iter().map(|values| {
            let preview = preview_material::to_numbers(&(material.kind.preview)(values));
            std::array::from_fn(|k| preview[k] - middle[k])
        });
        Self { source, change: Change::BsdfParameters { places, knots }, previews: previews.collect(), base: [0.0; 3] }
    }
}
