//! Choice whether pixels share the light that their paths find.
//!
//! [`pays`] renders a few tiles of the picture with and without [`path_reuse`](super::path_reuse), and compares the products of
//! variance and cost. It counts operations and measures no time, so that the same picture always decides in the same way.
//!
//! **Cost.** 25,000 paths on the CPU, for pictures of at least a hundred times as many.

use super::path;
use super::path_reuse::GROUP;
use crate::metrics::RELMSE_EPSILON;
use crate::ray_stats::RayCounters;
use crate::sampling::sobol::hash;
use crate::scene::material::LAMBERTIAN;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use glam::Vec3;
use pathmarch_scene::Sampler;
use rayon::prelude::*;

/// Columns and rows of tiles that a probe renders.
const PROBE_GRID: [u32; 2] = [8, 4];
/// Samples of the probe.
const PROBE_SAMPLES: u32 = 6;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 100.0;
/// Cost of an evaluation of the field relative to a ray and its shading.
const EVALUATION_COST: f64 = 0.25;
/// Smallest relative reduction of the error that justifies sharing, because the noise of neighbours is related.
const MIN_GAIN: f64 = 0.2;
/// Largest relative variance of a pixel of the probe, so that none dominates.
const MAX_VARIANCE: f64 = 10.0;

/// True in scenes where some surface is Lambertian, and nothing but the geometry decides what one sees of another.
pub(crate) fn is_possible(scene: &RenderScene, config: &KernelConfig) -> bool {
    let is_plain = !config.media && !config.shading_normals && !config.fast_caustics && !config.traced_caustics;
    is_plain && scene.materials.iter().any(|material| material.has(LAMBERTIAN))
}

/// True if a picture with this number of samples a pixel converges sooner with path reuse.
pub(crate) fn pays(scene: &RenderScene, frame: &FrameUniforms, config: &KernelConfig, samples: u32) -> bool {
    let [width, height] = frame.size();
    let probe_paths = 2 * PROBE_SAMPLES * PROBE_GRID[0] * PROBE_GRID[1] * GROUP * GROUP;
    let paths = f64::from(width) * f64::from(height) * f64::from(samples);
    if paths < MIN_PATHS_PER_PROBE_PATH * f64::from(probe_paths) || width.min(height) < GROUP {
        return false;
    }
    // The probe uses other random numbers than the picture, and independent ones.
    let frame = FrameUniforms { seed: hash(frame.seed), sampler: Sampler::Independent as u32, ..*frame };
    let error = |path_reuse: bool| {
        let config = KernelConfig { path_reuse, splitting: 1, ..*config };
        let counters = RayCounters::default();
        let ctx = TraceContext { scene, frame: &frame, config: &config, stats: Some(&counters), photons: None };
        let tiles = (0..PROBE_GRID[0] * PROBE_GRID[1]).into_par_iter();
        let variance: f64 = tiles.map(|tile| probe(&ctx, tile)).collect::<Vec<_>>().iter().sum();
        let total = counters.total();
        variance * (total.rays as f64 + EVALUATION_COST * total.evaluations as f64)
    };
    error(true) < (1.0 - MIN_GAIN) * error(false)
}

/// Variance of the pixels of a tile of the probe, relative to their means as in relMSE and summed.
fn probe(ctx: &TraceContext, tile: u32) -> f64 {
    let [width, height] = ctx.frame.size();
    let corner = |cell: u32, cells: u32, length: u32| {
        let tiles = length / GROUP;
        (tiles * (2 * cell + 1) / (2 * cells)).min(tiles - 1) * GROUP
    };
    let left = corner(tile % PROBE_GRID[0], PROBE_GRID[0], width);
    let top = corner(tile / PROBE_GRID[0], PROBE_GRID[1], height);
    let pixels: Vec<(u32, u32)> = (top..top + GROUP).flat_map(|y| (left..left + GROUP).map(move |x| (x, y))).collect();
    let values: Vec<Vec<Vec3>> = (0..PROBE_SAMPLES).map(|sample| path::trace(ctx, &pixels, sample, 1)).collect();
    let count = f64::from(PROBE_SAMPLES);
    let mut total = 0.0;
    for pixel in 0..pixels.len() {
        for channel in 0..3 {
            let components = || values.iter().map(|sample| f64::from(sample[pixel][channel]));
            let mean = components().sum::<f64>() / count;
            let variance = components().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let relative = variance / (mean * mean + RELMSE_EPSILON);
            // Ignore values that are not finite.
            total += if relative.is_finite() { relative.min(MAX_VARIANCE) } else { 0.0 };
        }
    }
    total
}
