//! Arbitrary output variables (AOVs): albedo, normal, depth, position and indices of the first hits, for compositing
//! and denoising.
//!
//! **Idea.** One ray through the centre of each pixel, and sixteen through a regular grid of four by four positions in
//! it, all through the centre of the lens. Albedo and normal are means over the grid, so that edges are smooth. Depth,
//! position and indices have no meaningful mean; they are those at the centre. There are no random numbers: the layers
//! have no noise and are the same for both backends. Out of focus, they are sharper than the picture.
//!
//! **Source.** Features of first hits as guides of a denoiser: Rousselle, Manzi, Zwicker, "Robust Denoising using
//! Feature and Color Information", 2013. Names of channels are those of layers in OpenEXR ("Technical Introduction to
//! OpenEXR", 2013), with the suffixes of Blender's passes.
//!
//! **Cost.** Seventeen rays a pixel, eight at a time, on all cores: 1.7 s for 1280x720 pixels of
//! `scenes/thesis/combinations.kdl` on two cores.

use super::{ViewScene, display_colour, is_dark_side};
use crate::error::RenderError;
use crate::integrator::camera::central_ray;
use crate::intersect::march::march;
use crate::intersect::ray::RaySegment;
use crate::output::film::Film;
use crate::output::image::{Channel, ChannelValues};
use crate::scene::TraceContext;
use crate::settings::Settings;
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::shading::textured_point::TexturedPoint;
use glam::Vec3;
use pathmarch_scene::Scene;
use rayon::prelude::*;

/// Group of channels of a file besides R, G and B.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// Albedo.
    Albedo,
    /// World-space normal.
    Normal,
    /// Distance along the camera's axis.
    Depth,
    /// World-space position.
    Position,
    /// Number of the object.
    ObjectId,
    /// Number of the material.
    MaterialId,
    /// Accepted samples of the pixel, [`Film::sample_counts`].
    SampleCount,
}

impl Layer {
    /// All layers.
    pub const ALL: [Self; 7] =
        [Self::Albedo, Self::Normal, Self::Depth, Self::Position, Self::ObjectId, Self::MaterialId, Self::SampleCount];

    /// Name of the layer: the part of its channels' names before the dot.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::ObjectId => "objectId",
            Self::MaterialId => "materialId",
            Self::SampleCount => "sampleCount",
        }
    }

    /// Last parts of the names of its channels, as in `albedo.R`.
    pub fn parts(self) -> &'static [char] {
        match self {
            Self::Albedo => &['R', 'G', 'B'],
            Self::Normal | Self::Position => &['X', 'Y', 'Z'],
            Self::Depth => &['Z'],
            Self::ObjectId | Self::MaterialId | Self::SampleCount => &['X'],
        }
    }

    /// Help text, one line.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Albedo => "Base colour, or a light source's radiance clipped to 1; pixel mean.",
            Self::Normal => "World-space normal facing the camera; normalised pixel mean.",
            Self::Depth => "Metres along the camera's axis at the pixel's centre; infinite for the background.",
            Self::Position => "World-space position at the pixel's centre, metres.",
            Self::ObjectId => "Object at the pixel's centre: an integer from 1 in scene order, 0 for the background.",
            Self::MaterialId => {
                "Material at the pixel's centre: an integer from 1 in scene order, 0 for the background."
            }
            Self::SampleCount => "Number of samples of the pixel, an integer.",
        }
    }

    /// Layer of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// Channels of the layer, for a file.
    pub fn channels(self, aovs: &Aovs, film: &Film) -> Vec<Channel> {
        let component = |values: &[[f32; 3]], k: usize| ChannelValues::F32(values.iter().map(|v| v[k]).collect());
        let channels = self.parts().iter().enumerate().map(|(k, part)| Channel {
            name: format!("{}.{part}", self.name()),
            values: match self {
                Self::Albedo => component(&aovs.albedo, k),
                Self::Normal => component(&aovs.normal, k),
                Self::Depth => ChannelValues::F32(aovs.depth.clone()),
                Self::Position => component(&aovs.position, k),
                Self::ObjectId => ChannelValues::U32(aovs.object.clone()),
                Self::MaterialId => ChannelValues::U32(aovs.material.clone()),
                Self::SampleCount => ChannelValues::U32(film.sample_counts()),
            },
        });
        channels.collect()
    }
}

/// Attributes of the first hits of camera rays, pixel by pixel, the top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Albedo of the material, linear Rec. 709, 0 to 1; of an emitter, its radiance clipped to 1. Black without a hit.
    /// Blended materials are blended in sixteenths.
    pub albedo: Vec<[f32; 3]>,
    /// Unit normal in world space, on the side of the camera; zero without a hit.
    pub normal: Vec<[f32; 3]>,
    /// Distance from the camera along its view axis, not along the ray, metres; infinite without a hit.
    pub depth: Vec<f32>,
    /// Position in world space, metres; zero without a hit.
    pub position: Vec<[f32; 3]>,
    /// One more than the index into [`Scene::objects`]; 0 without a hit.
    pub object: Vec<u32>,
    /// One more than the index into [`Scene::materials`]; where materials blend, that with the largest weight; 0
    /// without a hit.
    pub material: Vec<u32>,
}

/// AOVs of a pixel.
#[derive(Clone, Copy)]
struct PixelAovs {
    albedo: Vec3,
    normal: Vec3,
    depth: f32,
    position: Vec3,
    object: u32,
    material: u32,
}

/// Number of positions along a side of the grid in a pixel.
const GRID_SIDE: u32 = 4;
/// Number of positions of the grid.
const GRID_POSITIONS: u32 = GRID_SIDE * GRID_SIDE;
/// Index of the pixel's centre, after the positions of the grid.
const CENTRE: u32 = GRID_POSITIONS;
/// Number of pixels whose rays are traced together.
const BATCH_PIXELS: u32 = 256;

/// Renders the AOVs of a scene on all cores. Samples, bounces and seed of the settings have no effect.
///
/// # Errors
/// [`RenderError::Settings`] if settings are out of range.
pub fn render(scene: &Scene, settings: &Settings) -> Result<Aovs, RenderError> {
    settings.check(scene)?;
    let view = ViewScene::new(scene, settings);
    let ctx = view.context();
    let colours: Vec<Vec3> = (0..scene.materials.len() as u32).map(|m| display_colour(scene, m).into()).collect();
    let [width, height] = settings.size;
    let starts: Vec<u32> = (0..width * height).step_by(BATCH_PIXELS as usize).collect();
    let pixels: Vec<PixelAovs> = starts
        .par_iter()
        .flat_map_iter(|&start| render_batch(&ctx, &colours, start..(start + BATCH_PIXELS).min(width * height)))
        .collect();
    Ok(Aovs {
        width,
        height,
        albedo: pixels.iter().map(|pixel| pixel.albedo.into()).collect(),
        normal: pixels.iter().map(|pixel| pixel.normal.into()).collect(),
        depth: pixels.iter().map(|pixel| pixel.depth).collect(),
        position: pixels.iter().map(|pixel| pixel.position.into()).collect(),
        object: pixels.iter().map(|pixel| pixel.object).collect(),
        material: pixels.iter().map(|pixel| pixel.material).collect(),
    })
}

/// AOVs of a range of pixels.
fn render_batch(ctx: &TraceContext, colours: &[Vec3], range: std::ops::Range<u32>) -> Vec<PixelAovs> {
    let frame = ctx.frame;
    let positions = range.flat_map(|index| (0..=CENTRE).map(move |position_index| (index, position_index)));
    let segments: Vec<RaySegment> = positions
        .map(|(index, position_index)| {
            let [dx, dy] = if position_index == CENTRE {
                [0.5; 2]
            } else {
                [position_index % GRID_SIDE, position_index / GRID_SIDE].map(|k| (k as f32 + 0.5) / GRID_SIDE as f32)
            };
            let ray = central_ray(frame, (index % frame.width) as f32 + dx, (index / frame.width) as f32 + dy);
            RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let hits = march(ctx, &segments);
    let (indices, segment_hits): (Vec<usize>, Vec<_>) =
        hits.iter().enumerate().filter_map(|(index, hit)| Some((index, (segments[index], (*hit)?)))).unzip();
    let position_index = |index: usize| index as u32 % (GRID_POSITIONS + 1);
    let interactions =
        surface_interactions(ctx, &segment_hits, |k, blend| blend_threshold(position_index(indices[k]), blend));
    let no_hit = PixelAovs {
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: f32::INFINITY,
        position: Vec3::ZERO,
        object: 0,
        material: 0,
    };
    let mut pixels = vec![no_hit; segments.len() / (GRID_POSITIONS as usize + 1)];
    for (index, interaction) in indices.into_iter().zip(interactions) {
        add_hit(ctx, colours, position_index(index), &interaction, &mut pixels[index / (GRID_POSITIONS as usize + 1)]);
    }
    for pixel in &mut pixels {
        pixel.normal = pixel.normal.normalize_or_zero();
    }
    pixels
}

/// Weight above which the second material of a blend is chosen at a position. Over the grid, the thresholds of each
/// blend are evenly spaced, so that the mean is the blend; those of two blends form a lattice.
fn blend_threshold(position_index: u32, blend: u32) -> f32 {
    if position_index == CENTRE {
        return 0.5;
    }
    let multiplier = 2 * (blend % GRID_POSITIONS) + 1;
    (((position_index * multiplier) % GRID_POSITIONS) as f32 + 0.5) / GRID_POSITIONS as f32
}

/// Adds the hit of the ray through a position of a pixel to the pixel.
fn add_hit(
    ctx: &TraceContext,
    colours: &[Vec3],
    position_index: u32,
    interaction: &SurfaceInteraction,
    pixel: &mut PixelAovs,
) {
    let &SurfaceInteraction { p, leaf, normal, .. } = interaction;
    let material = ctx.scene.leaves[leaf].material as usize;
    if position_index == CENTRE {
        pixel.position = p;
        pixel.depth = (p - Vec3::from(ctx.frame.position)).dot(Vec3::from(ctx.frame.forward));
        pixel.object = ctx.scene.field.leaves()[leaf].object + 1;
        pixel.material = material as u32 + 1;
        return;
    }
    pixel.normal += normal;
    if !is_dark_side(ctx, leaf, normal) {
        let textured = TexturedPoint::new(ctx, interaction, interaction.length);
        pixel.albedo +=
            textured.and_then(|textured| textured.colour()).unwrap_or(colours[material]) / GRID_POSITIONS as f32;
    }
}
