//! Features: attributes of the first surfaces that scatter light, which guide the filter.
//!
//! **Idea.** Camera rays of the picture's own first samples, so that edges, depth of field and antialiasing agree with
//! those of the picture. A ray passes mirrors and smooth glass as a path does, so that the features of a reflection are
//! those of what is reflected; it ends at solids inside which light is scattered. Two halves of the rays measure the noise of the features.
//! Mirror images, leaves and the spread of the positions are for the temporal pass.
//!
//! **Source.** Feature buffers with half buffers: Rousselle, Manzi, Zwicker 2013, "Robust Denoising using Feature and
//! Color Information".
//!
//! **Cost.** [`FEW_RAYS`] camera rays a pixel on the CPU, whichever backend renders the picture: as long as one or two
//! samples of paths with eight bounces. Pictures of many samples have an eighth as many rays, at most [`MAX_RAYS`].

use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::integrator::camera::{camera_rays, pixel_sampler};
use crate::integrator::light_sampling;
use crate::integrator::medium::{medium_beyond, transmittance};
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment};
use crate::job::Shutter;
use crate::sampling::basis::{basis, local_viewer};
use crate::sampling::sobol::{PixelSampler, hash, pair};
use crate::scene::material::{DELTA, GLOWS};
use crate::scene::{FrameUniforms, RenderScene, TraceContext};
use crate::settings::Settings;
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use glam::Vec3;
use pathmarch_field::graph::Batch;
use pathmarch_scene::{Animation, Scene};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of camera rays of a pixel of 16 to 128 samples.
pub const FEW_RAYS: u32 = 16;
/// Largest number of camera rays of a pixel.
pub const MAX_RAYS: u32 = 64;
/// Largest number of mirrors and glass surfaces that a ray passes.
const MAX_DELTA_SURFACES: u32 = 12;
/// Number of pixels whose rays are traced together.
const BATCH_PIXELS: usize = 256;

/// Features of a pixel: sums over camera rays.
#[derive(Clone, Copy, Debug, Default)]
pub struct PixelFeatures {
    /// Albedo of the surface times the reflectance and transmittance on the way there; 0 for light sources.
    pub albedo: Vec3,
    /// Radiance of the light source or sky that a ray reaches.
    pub emission: Vec3,
    /// Unit normal of the surface, on the side of the ray.
    pub normal: Vec3,
    /// Position of the surface in world space, metres.
    pub position: Vec3,
    /// Hash of the material, 0 to 1.
    pub material: f32,
    /// Length of the path, metres.
    pub length: f32,
    /// Number of rays that reach a surface that scatters light.
    pub surfaces: f32,
    /// Point at the length of the path on the straight camera ray: the position itself, or that of its mirror image,
    /// metres.
    pub image: Vec3,
    /// Sum of the squared distances of the positions from their mean, square metres.
    pub squared_spread: f32,
    /// Leaf of the surface that all rays reach.
    pub(super) leaf: SeenLeaf,
    /// Surface next to the camera.
    pub(super) front: Option<FrontPoint>,
}

/// First point of a camera ray on a surface of any kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrontPoint {
    /// Position in world space, metres.
    pub(super) position: Vec3,
    /// Unit normal on the side of the camera.
    pub(super) normal: Vec3,
    /// Distance from the camera, metres.
    pub(super) length: f32,
    pub(super) leaf: u32,
}

impl FrontPoint {
    /// The nearer of two points.
    pub(super) fn nearer(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        match (a, b) {
            (Some(a), Some(b)) => Some(if b.length < a.length { b } else { a }),
            (a, b) => a.or(b),
        }
    }
}

/// Leaf of the surfaces that camera rays reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum SeenLeaf {
    /// No surface.
    #[default]
    None,
    /// One leaf, seen directly.
    Direct(u32),
    /// One leaf, through mirrors or glass.
    Indirect(u32),
    /// Several leaves.
    Several,
}

impl SeenLeaf {
    /// Leaf of the rays of both.
    fn joined(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, leaf) | (leaf, Self::None) => leaf,
            (a, b) if a == b => a,
            _ => Self::Several,
        }
    }
}

impl std::ops::AddAssign for PixelFeatures {
    fn add_assign(&mut self, other: Self) {
        self.squared_spread += other.squared_spread;
        if self.surfaces > 0.0 && other.surfaces > 0.0 {
            // Sums of two parts: pairwise algorithm, Chan et al. 1983.
            let apart = self.position / self.surfaces - other.position / other.surfaces;
            let count = self.surfaces * other.surfaces / (self.surfaces + other.surfaces);
            self.squared_spread += apart.length_squared() * count;
        }
        self.leaf = self.leaf.joined(other.leaf);
        self.front = FrontPoint::nearer(self.front, other.front);
        self.image += other.image;
        self.albedo += other.albedo;
        self.emission += other.emission;
        self.normal += other.normal;
        self.position += other.position;
        self.material += other.material;
        self.length += other.length;
        self.surfaces += other.surfaces;
    }
}

/// Features of a picture, in two halves of `rays` camera rays each.
#[derive(Clone, Debug)]
pub struct Features {
    /// Camera rays of a pixel in each half.
    pub rays: u32,
    /// Side of a pixel at a distance of one metre, metres.
    pub pixel: f32,
    /// Sums of both halves, pixel by pixel, the top row first.
    pub halves: [Vec<PixelFeatures>; 2],
    /// Scene and camera; with motion blur, at a moment while the shutter is open.
    pub(super) view: View,
}

/// Scene and camera of a picture.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) scene: Arc<RenderScene>,
    pub(super) frame: FrameUniforms,
}

impl Features {
    /// Traces the features of a path-traced picture with `samples` samples of a still scene.
    ///
    /// # Errors
    /// [`RenderError::Settings`] if settings are out of range.
    pub fn trace(scene: &Scene, settings: &Settings, samples: u32) -> Result<Self, RenderError> {
        settings.check(scene)?;
        let input = RenderInput::new(scene, settings);
        Self::trace_at(settings, samples, |_| Ok(input.clone()))
    }

    /// Traces the features of a picture that [`Renderer::start_motion_blur`](crate::Renderer::start_motion_blur) renders
    /// with the same arguments: each camera ray at the moment of its sample.
    ///
    /// # Errors
    /// Those of [`trace`](Self::trace), and [`RenderError::Scene`] if the animation is not a valid scene at a moment.
    pub fn trace_motion_blur(
        animation: &Mutex<Animation>,
        scene: &Scene,
        settings: &Settings,
        shutter: Shutter,
        samples: u32,
    ) -> Result<Self, RenderError> {
        if !shutter.blurs(scene, settings) {
            return Self::trace(scene, settings, samples);
        }
        Self::trace_at(settings, samples, |sample| {
            let moment = shutter.moment(settings.seed, sample);
            let scene = animation.lock().unwrap_or_else(PoisonError::into_inner).at(moment)?;
            settings.check(&scene)?;
            Ok(RenderInput::new(&scene, settings))
        })
    }

    /// Traces features; `input_at` returns the input of a sample.
    fn trace_at(
        settings: &Settings,
        samples: u32,
        mut input_at: impl FnMut(u32) -> Result<RenderInput, RenderError>,
    ) -> Result<Self, RenderError> {
        let rays = rays_of(samples) / 2;
        let [width, height] = settings.size;
        let pixels: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
        let mut halves = [vec![PixelFeatures::default(); pixels.len()], vec![PixelFeatures::default(); pixels.len()]];
        let first = input_at(settings.first_sample)?;
        let view = View { scene: first.scene, frame: first.frame };
        for ray in 0..2 * rays {
            let sample = settings.first_sample + ray;
            let input = input_at(sample)?;
            let ctx = input.context(None);
            let sums = halves[(ray / rays) as usize].par_chunks_mut(BATCH_PIXELS);
            sums.zip(pixels.par_chunks(BATCH_PIXELS)).for_each(|(sums, pixels)| trace_rays(&ctx, pixels, sample, sums));
        }
        Ok(Self { rays, pixel: view.frame.pixel, halves, view })
    }
}

/// Number of camera rays for a picture of so many samples: two or more, and as many in each half.
fn rays_of(samples: u32) -> u32 {
    2 * (samples.min((samples / 8).clamp(FEW_RAYS, MAX_RAYS)) / 2).max(1)
}

/// Adds the features of the camera rays of one sample of these pixels to their sums.
fn trace_rays(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32, sums: &mut [PixelFeatures]) {
    let samplers: Vec<PixelSampler> = pixels.iter().map(|&(x, y)| pixel_sampler(ctx, x, y, sample)).collect();
    let rays = camera_rays(ctx.frame, pixels, &samplers).into_iter().zip(samplers);
    let mut walks: Vec<Walk> =
        rays.enumerate().map(|(slot, (ray, sampler))| Walk::new(ctx, slot, ray, sampler)).collect();
    for surface_index in 0.. {
        if walks.is_empty() {
            return;
        }
        walks = advanced(ctx, walks, surface_index, sums);
    }
}

/// Ray on its way to the first surface that scatters light.
struct Walk {
    /// Index of the pixel.
    slot: usize,
    camera_ray: Ray,
    ray: Ray,
    sampler: PixelSampler,
    throughput: Vec3,
    /// Absorption coefficient of the medium around the ray, per metre.
    medium: Vec3,
    /// Length of the path, metres.
    length: f32,
}

impl Walk {
    fn new(ctx: &TraceContext, slot: usize, ray: Ray, sampler: PixelSampler) -> Self {
        let camera_ray = ray;
        Self {
            slot,
            camera_ray,
            ray,
            sampler,
            throughput: Vec3::ONE,
            medium: Vec3::from(ctx.frame.medium),
            length: 0.0,
        }
    }
}

/// Intersects rays with the scene; adds the features of those that have reached their surface, and returns the others.
fn advanced(ctx: &TraceContext, walks: Vec<Walk>, surface_index: u32, sums: &mut [PixelFeatures]) -> Vec<Walk> {
    let segment = |walk: &Walk| RaySegment { ray: walk.ray, path_length: walk.length, limit: f32::INFINITY };
    let segments: Vec<RaySegment> = walks.iter().map(segment).collect();
    let hits = march(ctx, &segments);
    let (mut reached, mut segment_hits) = (Vec::with_capacity(walks.len()), Vec::with_capacity(walks.len()));
    for ((mut walk, segment), hit) in walks.into_iter().zip(segments).zip(hits) {
        walk.throughput *= transmittance(walk.medium, hit.map_or(f32::INFINITY, |hit| hit.t));
        if let Some(hit) = hit {
            walk.length += hit.t;
            reached.push(walk);
            segment_hits.push((segment, hit));
        } else {
            let direction = walk.ray.direction;
            let sky = ctx.scene.sky.radiance(direction).0 + light_sampling::sun_radiance(ctx, direction, 0.0);
            sums[walk.slot].emission += walk.throughput * sky;
        }
    }
    let seed = |k: usize| reached[k].sampler.unstratified_seed(surface_index);
    let interactions = surface_interactions(ctx, &segment_hits, |k, blend| f32::choice(seed(k), blend));
    let continued = reached.into_iter().zip(interactions);
    continued.filter_map(|(walk, interaction)| scattered(ctx, walk, &interaction, surface_index, sums)).collect()
}

/// Next ray of a walk at a mirror or smooth glass; `None` after adding the features of any other surface.
fn scattered(
    ctx: &TraceContext,
    walk: Walk,
    interaction: &SurfaceInteraction,
    surface_index: u32,
    sums: &mut [PixelFeatures],
) -> Option<Walk> {
    let &SurfaceInteraction { p, normal, inside, normal_offset, .. } = interaction;
    if surface_index == 0 {
        let point = FrontPoint { position: p, normal, length: walk.length, leaf: interaction.leaf as u32 };
        let front = &mut sums[walk.slot].front;
        *front = FrontPoint::nearer(*front, Some(point));
    }
    let leaf = &ctx.scene.leaves[interaction.leaf];
    let material = &ctx.scene.materials[leaf.material as usize];
    if material.emits() {
        if ctx.scene.emits_towards(interaction.leaf, normal) {
            sums[walk.slot].emission += walk.throughput * Vec3::from(material.emission);
        }
        return None;
    }
    let textured = TexturedPoint::new(ctx, interaction, walk.length);
    if material.has(GLOWS) && ctx.scene.emits_towards(interaction.leaf, normal) {
        let emission = textured.as_ref().and_then(TexturedPoint::emission).unwrap_or(material.emission.into());
        sums[walk.slot].emission += walk.throughput * emission;
    }
    let ns = shading_normal(ctx.config, textured.as_ref(), interaction, -walk.ray.direction);
    let bsdf = ctx.scene.bsdfs[leaf.material as usize]?;
    // Light that walks through wax comes from everywhere: what is behind does not show.
    let is_clear = !ctx.scene.media.of_materials[leaf.material as usize].scatters();
    let passes = material.has(DELTA) && is_clear && surface_index <= MAX_DELTA_SURFACES.min(ctx.frame.bounces);
    if !passes {
        let plain = Vec3::from(ctx.scene.base_colours[leaf.material as usize]);
        let colour = textured.and_then(|textured| textured.colour()).unwrap_or(plain);
        sums[walk.slot] += PixelFeatures {
            albedo: walk.throughput * colour,
            emission: Vec3::ZERO,
            normal: ns,
            position: p,
            material: hash(leaf.material) as f32 / u32::MAX as f32,
            length: walk.length,
            surfaces: 1.0,
            image: walk.camera_ray.origin + walk.camera_ray.direction * walk.length,
            squared_spread: 0.0,
            leaf: match surface_index {
                0 => SeenLeaf::Direct(interaction.leaf as u32),
                _ => SeenLeaf::Indirect(interaction.leaf as u32),
            },
            front: None,
        };
        return None;
    }
    let textured_parameters = textured.as_ref().map(|textured| textured.parameters(&material.parameters));
    let parameters = textured_parameters.as_ref().unwrap_or(&material.parameters);
    let world_from_local = basis(ns);
    let wo = local_viewer(world_from_local.transpose(), -walk.ray.direction);
    let first_pair = pair::PAIR_SURFACE + pair::PAIRS_PER_SURFACE * surface_index;
    let [u, v] = walk.sampler.sample_2d(first_pair + pair::PAIR_SCATTER);
    let [lobe, _] = walk.sampler.sample_2d(first_pair + pair::PAIR_LOBE);
    let next = (bsdf.sample)(parameters, wo, inside, [u, v, lobe])?;
    let is_transmission = next.wi.z < 0.0;
    Some(Walk {
        ray: Ray {
            origin: p + if is_transmission { -normal_offset } else { normal_offset },
            direction: (world_from_local * next.wi).normalize(),
        },
        throughput: walk.throughput * next.weight,
        medium: match is_transmission {
            true => medium_beyond(walk.medium, Vec3::from(material.absorption), inside),
            false => walk.medium,
        },
        ..walk
    })
}
