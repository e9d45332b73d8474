//! Choice whether pixels share the light that their paths find.
//!
//! [`pays`] renders a few tiles of the picture with and without [`path_reuse`](super::path_reuse), and compares the products of
//! variance and cost.
//!
//! **Cost.** 25,000 paths on the CPU, for pictures of at least a hundred times as many.

use super::path_reuse::GROUP;
use super::{path, probe};
use crate::metrics::RELMSE_EPSILON;
use crate::ray_stats::RayCounters;
use crate::scene::material::LAMBERTIAN;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use glam::Vec3;
use rayon::prelude::*;

/// Columns and rows of tiles that a probe renders.
const PROBE_GRID: [u32; 2] = [8, 4];
/// Samples of the probe.
const PROBE_SAMPLES: u32 = 6;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 100.0;
/// Smallest relative reduction of the error that justifies sharing, because the noise of neighbours is related.
const MIN_GAIN: f64 = 0.2;
/// Largest relative variance of a pixel of the probe, so that none dominates.
const MAX_VARIANCE: f64 = 10.0;

/// Cost of a connection in a kernel on a software adapter, relative to a ray: its lanes exchange what they share through
/// memory, one by one. On llvmpipe 2 to 3.7.
pub(crate) const SOFTWARE_CONNECTION_COST: f64 = 3.0;

/// True in scenes where some surface is Lambertian, and nothing but the geometry decides what one sees of another.
pub(crate) fn is_possible(scene: &RenderScene, config: &KernelConfig) -> bool {
    let is_plain = !config.media && !config.shading_normals && !config.fast_caustics && !config.traced_caustics;
    is_plain && scene.materials.iter().any(|material| material.has(LAMBERTIAN))
}

/// True if a picture with this number of samples a pixel converges sooner with path reuse, if a connection costs as much as
/// this number of rays.
pub(crate) fn pays(
    scene: &RenderScene,
    frame: &FrameUniforms,
    config: &KernelConfig,
    samples: u32,
    connection_cost: f64,
) -> bool {
    let [width, height] = frame.size();
    let probe_paths = 2 * PROBE_SAMPLES * PROBE_GRID[0] * PROBE_GRID[1] * GROUP * GROUP;
    let is_large = probe::path_count(frame, samples) >= MIN_PATHS_PER_PROBE_PATH * f64::from(probe_paths);
    if !is_large || width.min(height) < GROUP {
        return false;
    }
    let frame = probe::frame_of(frame);
    let [[variance, cost], [shared_variance, shared_cost]] = [false, true].map(|path_reuse| {
        let config = KernelConfig { path_reuse, splitting: 1, ..*config };
        let counters = RayCounters::default();
        let ctx = TraceContext { scene, frame: &frame, config: &config, stats: Some(&counters), photons: None };
        let tiles = (0..PROBE_GRID[0] * PROBE_GRID[1]).into_par_iter();
        let variance: f64 = tiles.map(|tile| variance_of_tile(&ctx, tile)).collect::<Vec<_>>().iter().sum();
        [variance, probe::cost(&counters)]
    });
    let shared_cost = cost + connection_cost * (shared_cost - cost);
    shared_variance * shared_cost < (1.0 - MIN_GAIN) * variance * cost
}

/// Variance of the pixels of a tile of the probe, relative to their means as in relMSE and summed.
fn variance_of_tile(ctx: &TraceContext, tile: u32) -> f64 {
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
