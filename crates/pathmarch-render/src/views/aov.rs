//! What the camera sees besides light: colours, normals, depths and numbers of surfaces, for compositing and denoising
//! (arbitrary output variables).
//!
//! **Idea.** One ray through the centre of a pixel, and sixteen through a regular grid of four by four positions in it, all
//! through the middle of the lens, as far as the first surface. Albedo and normal are means over the grid, so that edges are
//! smooth; depth, position and numbers have no meaningful mean and are those at the centre. No random numbers: the layers
//! have no noise, and are the same whatever backend renders the light. Out of focus they are sharper than the picture.
//!
//! **Source.** Features of first surfaces as guides of a denoiser: Rousselle, Manzi, Zwicker, "Robust Denoising using Feature
//! and Color Information", 2013. The names of channels are those of layers in OpenEXR ("Technical Introduction to
//! OpenEXR", 2013), their parts after the dot those of Blender's passes.
//!
//! **Cost.** Seventeen rays a pixel, eight to a march, over all cores: 1.7 s for 1280x720 pixels of
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
use crate::shading::surface_interaction::{SurfaceInteraction, interactions};
use crate::shading::textured_point::TexturedPoint;
use glam::Vec3;
use pathmarch_scene::Scene;
use rayon::prelude::*;

/// A group of channels that a file can have beside its R, G and B.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// `albedo.R`, `.G`, `.B`
    Albedo,
    /// `normal.X`, `.Y`, `.Z`
    Normal,
    /// `depth.Z`
    Depth,
    /// `position.X`, `.Y`, `.Z`
    Position,
    /// `objectId.X`, an integer
    ObjectId,
    /// `materialId.X`, an integer
    MaterialId,
    /// `sampleCount.X`, an integer: samples of the pixel that count, [`Film::sample_counts`]
    SampleCount,
}

impl Layer {
    /// Every one.
    pub const ALL: [Self; 7] =
        [Self::Albedo, Self::Normal, Self::Depth, Self::Position, Self::ObjectId, Self::MaterialId, Self::SampleCount];

    /// The part of its channels' names before the dot.
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

    /// The one of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// Its channels, for a file.
    pub fn channels(self, aovs: &Aovs, film: &Film) -> Vec<Channel> {
        let channel = |part: char, values: ChannelValues| Channel { name: format!("{}.{part}", self.name()), values };
        let three = |parts: [char; 3], values: &[[f32; 3]]| {
            let component = |k: usize| ChannelValues::F32(values.iter().map(|value| value[k]).collect());
            parts.into_iter().enumerate().map(|(k, part)| channel(part, component(k))).collect()
        };
        match self {
            Self::Albedo => three(['R', 'G', 'B'], &aovs.albedo),
            Self::Normal => three(['X', 'Y', 'Z'], &aovs.normal),
            Self::Depth => vec![channel('Z', ChannelValues::F32(aovs.depth.clone()))],
            Self::Position => three(['X', 'Y', 'Z'], &aovs.position),
            Self::ObjectId => vec![channel('X', ChannelValues::U32(aovs.object.clone()))],
            Self::MaterialId => vec![channel('X', ChannelValues::U32(aovs.material.clone()))],
            Self::SampleCount => vec![channel('X', ChannelValues::U32(film.sample_counts()))],
        }
    }
}

/// The first surfaces that the camera sees; one of each for each pixel, the top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Linear Rec. 709, 0 to 1: the colour of the material; of a lamp, its radiance, clipped. Black
    /// where nothing is hit. Blended materials are blended in sixteenths.
    pub albedo: Vec<[f32; 3]>,
    /// In the world, on the side towards the camera, of length one; zero where nothing is hit.
    pub normal: Vec<[f32; 3]>,
    /// Metres from the camera along its view axis, not along the ray; infinite where nothing is hit.
    pub depth: Vec<f32>,
    /// In the world, metres; zero where nothing is hit.
    pub position: Vec<[f32; 3]>,
    /// One more than the index into [`Scene::objects`]; 0 where nothing is hit.
    pub object: Vec<u32>,
    /// One more than the index into [`Scene::materials`], of blended ones the heaviest; 0 where nothing is hit.
    pub material: Vec<u32>,
}

/// What one pixel sees.
#[derive(Clone, Copy)]
struct Pixel {
    albedo: Vec3,
    normal: Vec3,
    depth: f32,
    position: Vec3,
    object: u32,
    material: u32,
}

/// Positions along a side of the grid in a pixel.
const SIDE: u32 = 4;
/// Positions of the grid.
const GRID: u32 = SIDE * SIDE;
/// The number of the position after those of the grid: the pixel's centre.
const CENTRE: u32 = GRID;
/// Pixels whose rays are marched together.
const BATCH: u32 = 256;

/// Finds what the camera sees, on all cores. Samples, bounces and seed of the settings have no effect.
///
/// # Errors
/// [`RenderError::Settings`] where settings are out of range.
pub fn render(scene: &Scene, settings: &Settings) -> Result<Aovs, RenderError> {
    settings.check(scene)?;
    let view = ViewScene::new(scene, settings);
    let ctx = view.context();
    let colours: Vec<Vec3> = (0..scene.materials.len() as u32).map(|m| display_colour(scene, m).into()).collect();
    let [width, height] = settings.size;
    let starts: Vec<u32> = (0..width * height).step_by(BATCH as usize).collect();
    let pixels: Vec<Pixel> = starts
        .par_iter()
        .flat_map_iter(|&start| batch(&ctx, &colours, start..(start + BATCH).min(width * height)))
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

/// What a range of pixels sees.
fn batch(ctx: &TraceContext, colours: &[Vec3], range: std::ops::Range<u32>) -> Vec<Pixel> {
    let frame = ctx.frame;
    let places = range.flat_map(|index| (0..=CENTRE).map(move |place| (index, place)));
    let marches: Vec<RaySegment> = places
        .map(|(index, place)| {
            let [dx, dy] = if place == CENTRE {
                [0.5; 2]
            } else {
                [place % SIDE, place / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32)
            };
            let ray = central_ray(frame, (index % frame.width) as f32 + dx, (index / frame.width) as f32 + dy);
            RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let hits = march(ctx, &marches);
    let (indices, met): (Vec<usize>, Vec<_>) =
        hits.iter().enumerate().filter_map(|(index, hit)| Some((index, (marches[index], (*hit)?)))).unzip();
    let place = |index: usize| index as u32 % (GRID + 1);
    let surfaces = interactions(ctx, &met, |k, blend| blend_threshold(place(indices[k]), blend));
    let nothing = Pixel {
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: f32::INFINITY,
        position: Vec3::ZERO,
        object: 0,
        material: 0,
    };
    let mut pixels = vec![nothing; marches.len() / (GRID as usize + 1)];
    for (index, surface) in indices.into_iter().zip(surfaces) {
        add(ctx, colours, place(index), &surface, &mut pixels[index / (GRID as usize + 1)]);
    }
    for pixel in &mut pixels {
        pixel.normal = pixel.normal.normalize_or_zero();
    }
    pixels
}

/// The weight above which the second material of a blend shows. Over the grid the thresholds of each blend are evenly
/// spaced, so that the mean is the blend; those of two blends form a lattice.
fn blend_threshold(place: u32, blend: u32) -> f32 {
    if place == CENTRE {
        return 0.5;
    }
    let turn = 2 * (blend % GRID) + 1;
    (((place * turn) % GRID) as f32 + 0.5) / GRID as f32
}

/// Adds what the ray through this place of a pixel has met to it.
fn add(ctx: &TraceContext, colours: &[Vec3], place: u32, surface: &SurfaceInteraction, pixel: &mut Pixel) {
    let &SurfaceInteraction { p, leaf, normal, .. } = surface;
    let material = ctx.scene.leaves[leaf].material as usize;
    if place == CENTRE {
        pixel.position = p;
        pixel.depth = (p - Vec3::from(ctx.frame.position)).dot(Vec3::from(ctx.frame.forward));
        pixel.object = ctx.scene.field.leaves()[leaf].object + 1;
        pixel.material = material as u32 + 1;
        return;
    }
    pixel.normal += normal;
    if !is_dark_side(ctx, leaf, normal) {
        let textured = TexturedPoint::new(ctx, leaf, p, surface.outward(), surface.length);
        pixel.albedo += textured.and_then(|textured| textured.colour()).unwrap_or(colours[material]) / GRID as f32;
    }
}
