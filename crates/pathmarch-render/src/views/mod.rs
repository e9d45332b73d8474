//! Views: albedo, normal, depth, object and material of the first hit of camera rays, and the cost of sphere tracing.
//!
//! **Idea.** One camera ray a sample and no light transport. Colours are looked up in a table that is computed once for
//! both backends: a colour for each leaf (albedo, object, material) or for each number of steps. Normals and depths are
//! display codes. They are decoded to linear light with the inverse of the sRGB transfer function, so that a screen
//! shows the codes and a pixel is a mean of light.
//!
//! - **Depth** z, along the camera's axis, has the code 1 / (1 + ((z - a)/s)²) for z beyond a, else 1. With D the
//!   distance from the camera to its target and R the radius of the finite objects, s = min(R, D) and a = D - s: white
//!   at the near end of the scene, middle grey at the target, a fifth at the far end, black at infinity.
//! - **Steps** are evaluations of the sphere-traced field, at most 256, on the scale of [`heat`](crate::mode::heat):
//!   log2(1 + steps) / 8. Rays without any evaluation are black, also those with an analytic hit. On the GPU, the
//!   distance function of the field counts its calls; the code of sphere tracing is unchanged.
//! - **Violations** are of |f(a) - f(b)| ≤ L |a - b| for consecutive points a and b of a ray (Hart 1996, section 2.2):
//!   the largest ratio of both sides along the ray, less the effect of rounding. Grey up to 1, then
//!   [`heat`](crate::mode::heat) of 1/2 + log2(ratio)/4, so that a ratio of four is dark red.
//!
//! **Cost.** One ray and one evaluation of the gradient a sample.

pub mod aov;
pub(crate) mod pick;

use crate::integrator::camera::central_ray;
use crate::intersect::march::{MAX_STEPS, march_with_stats};
use crate::intersect::ray::RaySegment;
use crate::mode::{Mode, heat, index_colour};
use crate::output::tonemap::srgb_decode;
use crate::ray_stats::MarchStats;
use crate::sampling::r2_sequence;
use crate::scene::{Extent, FrameUniforms, KernelConfig, RenderScene, TraceContext, base_colour};
use crate::settings::Settings;
use crate::shading::surface_interaction::surface_interactions;
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_scene::{Camera, Scene};

/// Scene, frame and configuration for camera rays without light transport.
pub(crate) struct ViewScene {
    scene: RenderScene,
    frame: FrameUniforms,
    config: KernelConfig,
}

impl ViewScene {
    /// Builds the tables of a scene, with a pinhole camera.
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let settings = Settings { mode: Mode::Normal, ..settings.clone() };
        let render_scene = RenderScene::new(scene, settings.camera_of(scene));
        let frame = FrameUniforms::new(scene, &settings, &render_scene);
        let config = KernelConfig::new(&render_scene, &settings);
        Self { scene: render_scene, frame, config }
    }

    /// Context of the rays.
    pub(crate) fn context(&self) -> TraceContext<'_> {
        TraceContext { scene: &self.scene, frame: &self.frame, config: &self.config, stats: None, photons: None }
    }
}

/// Lookup table of a view, for [`view`] and its WGSL twin.
pub(crate) fn table(mode: Mode, scene: &Scene, camera: &Camera) -> Vec<f32> {
    let by_leaf = |colour: &dyn Fn(&pathmarch_field::graph::Leaf) -> [f32; 3]| {
        scene.field.leaves().iter().flat_map(colour).collect()
    };
    match mode {
        Mode::Path | Mode::Preview | Mode::Normal | Mode::Variance => Vec::new(),
        Mode::Albedo => by_leaf(&|leaf| display_colour(scene, leaf.tag)),
        Mode::ObjectId => by_leaf(&|leaf| index_colour(leaf.object)),
        Mode::MaterialId => by_leaf(&|leaf| index_colour(leaf.tag)),
        Mode::Depth => {
            let distance = Vec3::from(camera.position).distance(Vec3::from(camera.target));
            let scale = Extent::new(scene, camera).radius.min(distance);
            vec![distance - scale, scale]
        }
        Mode::Violations => {
            (0..=MAX_VIOLATION as u32).flat_map(|k| violation_colour(k as f32 / VIOLATION_SCALE)).collect()
        }
        Mode::Steps => (0..=MAX_STEPS)
            .flat_map(|steps| if steps == 0 { [0.0; 3] } else { heat((1.0 + steps as f32).log2() / 8.0) })
            .collect(),
    }
}

shared_constants! {
    /// Index of the last colour in the table of violations.
    const MAX_VIOLATION: f32 = 1024.0;
    /// Colours in the table of violations for each unit of steepness.
    const VIOLATION_SCALE: f32 = 256.0;
}

/// Colour of a steepness, relative to the Lipschitz constant.
fn violation_colour(steepness: f32) -> [f32; 3] {
    /// Largest steepness by rounding and curvature that is no violation.
    const MAX_TOLERATED: f32 = 1.01;
    if steepness <= MAX_TOLERATED {
        return [0.02 + 0.18 * steepness; 3];
    }
    heat(0.5 + 0.25 * steepness.log2())
}

/// Display colour of a material: its albedo; of an emitter, its radiance clipped to 1.
pub(crate) fn display_colour(scene: &Scene, material: u32) -> [f32; 3] {
    base_colour(&scene.materials[material as usize]).map(|channel| channel.min(1.0))
}

/// Film values of one sample of each of these pixels.
pub(crate) fn view(ctx: &TraceContext, mode: Mode, table: &[f32], pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let [dx, dy] = r2_sequence::sample_2d(sample);
    let frame = ctx.frame;
    let segments: Vec<RaySegment> = pixels
        .iter()
        .map(|&(x, y)| {
            let ray = central_ray(frame, x as f32 + dx, y as f32 + dy);
            RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let (hits, stats) = march_with_stats(ctx, &segments);
    let colour = |k: usize| Vec3::from_slice(&table[3 * k..3 * k + 3]);
    if mode == Mode::Steps {
        return stats.iter().map(|ray| colour(ray.evaluations as usize)).collect();
    }
    if mode == Mode::Violations {
        let index = |ray: &MarchStats| (ray.steepest * VIOLATION_SCALE).round().clamp(0.0, MAX_VIOLATION);
        let violation = |ray: &MarchStats| if ray.evaluations > 0 { colour(index(ray) as usize) } else { Vec3::ZERO };
        return stats.iter().map(violation).collect();
    }
    let (slots, segment_hits): (Vec<usize>, Vec<_>) =
        hits.iter().enumerate().filter_map(|(slot, hit)| Some((slot, (segments[slot], (*hit)?)))).unzip();
    let mut colours = vec![Vec3::ZERO; pixels.len()];
    for (slot, interaction) in
        slots.into_iter().zip(surface_interactions(ctx, &segment_hits, |_, blend| r2_sequence::choice(sample, blend)))
    {
        colours[slot] = match mode {
            Mode::Normal => Vec3::from((Vec3::splat(0.5) + 0.5 * interaction.normal).to_array().map(srgb_decode)),
            Mode::Depth => {
                let depth = (interaction.p - Vec3::from(frame.position)).dot(Vec3::from(frame.forward));
                let beyond = (depth - table[0]).max(0.0) / table[1];
                Vec3::splat(srgb_decode(1.0 / (1.0 + beyond * beyond)))
            }
            Mode::Albedo if is_dark_side(ctx, interaction.leaf, interaction.normal) => Vec3::ZERO,
            Mode::Albedo => {
                let textured = TexturedPoint::new(ctx, &interaction, interaction.length);
                textured.and_then(|textured| textured.colour()).unwrap_or(colour(interaction.leaf))
            }
            _ => colour(interaction.leaf),
        };
    }
    colours
}

/// Reports whether this is the side of an emitter that does not emit.
pub(crate) fn is_dark_side(ctx: &TraceContext, leaf: usize, normal: Vec3) -> bool {
    ctx.scene.material_of(leaf).emits() && !ctx.scene.emits_towards(leaf, normal)
}
