//! Views of the first hit of camera rays: albedo, normal, depth, object, material, and the cost of sphere tracing.
//!
//! **Idea.** One ray, no light. What can be a table is one, made here for both backends: a colour for each leaf
//! (albedo, object, material) or for each number of steps. Normals and depths are codes, which a screen shall show as they
//! are, and become light by the inverse of the sRGB curve; the mean over a pixel is then one of light.
//!
//! - **Depth** z, along the camera's axis, has the code 1 / (1 + ((z - a)/s)²) for z beyond a, else 1. With D the distance
//!   from the camera to its target and R the radius of what of the scene is limited, s = min(R, D) and a = D - s: white at
//!   the near end of the scene, middle grey at its target, a fifth at its far end, black infinitely far.
//! - **Steps** are evaluations of the field of what must be marched, at most 256, on the scale of
//!   [`heat`](crate::mode::heat): log2(1 + steps) / 8. Rays that evaluate nothing are black, also where they meet an object
//!   in closed form. On the GPU the field's function counts its calls; the march knows nothing of it.
//! - **Violations** are of |f(a) - f(b)| ≤ L |a - b| for neighbouring points a and b of the march (Hart 1996, section 2.2):
//!   the largest ratio of the sides along the ray, less what rounding explains. Grey up to 1, then
//!   [`heat`](crate::mode::heat) of 1/2 + log2(ratio)/4, so that four times too steep is dark red.
//!
//! **Cost.** One march and one evaluation of the gradient a sample.

pub mod aov;
pub(crate) mod pick;

use crate::integrator::camera::central_ray;
use crate::intersect::march::{MAX_STEPS, march_with_stats};
use crate::intersect::ray::RaySegment;
use crate::mode::{Mode, colour_of_number, heat};
use crate::output::tonemap::srgb_decode;
use crate::ray_stats::MarchStats;
use crate::sampling::r2_sequence;
use crate::scene::{Extent, FrameUniforms, KernelConfig, RenderScene, TraceContext};
use crate::settings::Settings;
use crate::shading::surface_interaction::interactions;
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_scene::{Camera, Scene};

/// A scene from the camera, for rays that look and carry no light.
pub(crate) struct ViewScene {
    scene: RenderScene,
    frame: FrameUniforms,
    config: KernelConfig,
}

impl ViewScene {
    /// Tables of a scene; the lens is a point.
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        let settings = Settings { mode: Mode::Normal, ..settings.clone() };
        let tables = RenderScene::new(scene, settings.camera_of(scene));
        let frame = FrameUniforms::new(scene, &settings, &tables.sky, &tables.lights);
        let config = KernelConfig::new(&tables, &settings);
        Self { scene: tables, frame, config }
    }

    /// Context of its rays.
    pub(crate) fn context(&self) -> TraceContext<'_> {
        TraceContext { scene: &self.scene, frame: &self.frame, config: &self.config, stats: None }
    }
}

/// Colours or numbers of a view, for [`view`] and its WGSL twin.
pub(crate) fn table(mode: Mode, scene: &Scene, camera: &Camera) -> Vec<f32> {
    let by_leaf = |colour: &dyn Fn(&pathmarch_field::graph::Leaf) -> [f32; 3]| {
        scene.field.leaves().iter().flat_map(colour).collect()
    };
    match mode {
        Mode::Path | Mode::Preview | Mode::Normal | Mode::Variance => Vec::new(),
        Mode::Albedo => by_leaf(&|leaf| display_colour(scene, leaf.tag)),
        Mode::ObjectId => by_leaf(&|leaf| colour_of_number(leaf.object)),
        Mode::MaterialId => by_leaf(&|leaf| colour_of_number(leaf.tag)),
        Mode::Depth => {
            let distance = Vec3::from(camera.position).distance(Vec3::from(camera.target));
            let scale = Extent::new(scene, camera).radius.min(distance);
            vec![distance - scale, scale]
        }
        Mode::Violations => (0..=VIOLATIONS as u32).flat_map(|k| violation(k as f32 / VIOLATIONS_UNIT)).collect(),
        Mode::Steps => (0..=MAX_STEPS)
            .flat_map(|steps| if steps == 0 { [0.0; 3] } else { heat((1.0 + steps as f32).log2() / 8.0) })
            .collect(),
    }
}

shared_constants! {
    /// Index of the last colour of violations.
    const VIOLATIONS: f32 = 1024.0;
    /// Index of the colour of a steepness of 1.
    const VIOLATIONS_UNIT: f32 = 256.0;
}

/// The colour of a steepness over the one allowed.
fn violation(steepness: f32) -> [f32; 3] {
    /// What rounding and the curvature of what is shown may make of 1.
    const TOLERATED: f32 = 1.01;
    if steepness <= TOLERATED {
        return [0.02 + 0.18 * steepness; 3];
    }
    heat(0.5 + 0.25 * steepness.log2())
}

/// Display colour of a material: its albedo; of an emitter, its radiance clipped to 1.
pub(crate) fn display_colour(scene: &Scene, material: u32) -> [f32; 3] {
    let material = &scene.materials[material as usize];
    let colour = if material.emits() { material.emission() } else { material.albedo() };
    colour.map(|channel| channel.min(1.0))
}

/// One sample of a view through each of these pixels.
pub(crate) fn view(ctx: &TraceContext, mode: Mode, table: &[f32], pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let [dx, dy] = r2_sequence::sample_2d(sample);
    let frame = ctx.frame;
    let marches: Vec<RaySegment> = pixels
        .iter()
        .map(|&(x, y)| {
            let ray = central_ray(frame, x as f32 + dx, y as f32 + dy);
            RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let (hits, stats) = march_with_stats(ctx, &marches);
    let colour = |k: usize| Vec3::from_slice(&table[3 * k..3 * k + 3]);
    if mode == Mode::Steps {
        return stats.iter().map(|ray| colour(ray.evaluations as usize)).collect();
    }
    if mode == Mode::Violations {
        let place = |ray: &MarchStats| (ray.steepest * VIOLATIONS_UNIT).round().clamp(0.0, VIOLATIONS);
        let seen = |ray: &MarchStats| if ray.evaluations > 0 { colour(place(ray) as usize) } else { Vec3::ZERO };
        return stats.iter().map(seen).collect();
    }
    let (slots, met): (Vec<usize>, Vec<_>) =
        hits.iter().enumerate().filter_map(|(slot, hit)| Some((slot, (marches[slot], (*hit)?)))).unzip();
    let mut colours = vec![Vec3::ZERO; pixels.len()];
    for (slot, seen) in slots.into_iter().zip(interactions(ctx, &met, |_, blend| r2_sequence::choice(sample, blend))) {
        colours[slot] = match mode {
            Mode::Normal => Vec3::from((Vec3::splat(0.5) + 0.5 * seen.normal).to_array().map(srgb_decode)),
            Mode::Depth => {
                let depth = (seen.p - Vec3::from(frame.position)).dot(Vec3::from(frame.forward));
                let beyond = (depth - table[0]).max(0.0) / table[1];
                Vec3::splat(srgb_decode(1.0 / (1.0 + beyond * beyond)))
            }
            Mode::Albedo if is_dark_side(ctx, seen.leaf, seen.normal) => Vec3::ZERO,
            Mode::Albedo => {
                let textured = TexturedPoint::new(ctx, seen.leaf, seen.p, seen.outward(), seen.length);
                textured.and_then(|textured| textured.colour()).unwrap_or(colour(seen.leaf))
            }
            _ => colour(seen.leaf),
        };
    }
    colours
}

/// Whether this is the side of an emitter that does not emit.
pub(crate) fn is_dark_side(ctx: &TraceContext, leaf: usize, normal: Vec3) -> bool {
    ctx.scene.material_of(leaf).emits() && !ctx.scene.emits_towards(leaf, normal)
}
