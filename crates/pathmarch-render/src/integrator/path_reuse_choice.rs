//! Choice whether pixels share the light that their paths find.
//!
//! [`pays`] renders a few tiles of the picture with and without [`path_reuse`](super::path_reuse), and compares the products of
//! variance and cost. The variance of a pixel is taken relative to its own mean, as in relMSE, and relative to the radiance around
//! it. Either may decide: in a room that is lit through a keyhole, most pixels of the probe find no light, and their own means
//! would tell that they have no noise.
//!
//! Independent samples would not tell: shared paths are points of one net, and their variance falls faster.
//!
//! **Cost.** 66,000 paths on the CPU, for pictures of at least forty times as many.

use super::path_reuse::REUSE_TILE;
use super::probe::{self, Noise};
use crate::ray_stats::RayCounters;
use crate::scene::material::LAMBERTIAN;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use glam::DVec3;
use rayon::prelude::*;

/// Columns and rows of tiles that a probe renders.
const PROBE_GRID: [u32; 2] = [8, 4];
/// Successive samples of a pixel of the probe, with each of two seeds.
const PROBE_SAMPLES: u32 = 8;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 40.0;
/// Smallest relative reduction of the error that justifies sharing, because the noise of neighbours is related.
const MIN_GAIN: f64 = 0.2;
/// Largest variance of a pixel of the probe, relative to the radiance around it.
const MAX_RARE_VARIANCE: f64 = 3000.0;

/// Cost of a connection on the CPU, relative to a ray and its shading: 0.54 to 0.66.
const CPU_CONNECTION_COST: f64 = 0.6;
/// The same where rays and shading cost half, in [`packets`](super::packets): 1.2 to 1.3.
const PACKETS_CONNECTION_COST: f64 = 1.25;
/// Cost of a connection on the GPU, relative to a ray and its shading; not measured.
const GPU_CONNECTION_COST: f64 = 1.0;
/// Cost of a connection in a kernel on a software adapter, relative to a ray and its shading: its lanes exchange what they share
/// through memory, one by one. On llvmpipe 2.6 to 6.3.
const SOFTWARE_CONNECTION_COST: f64 = 4.0;

/// Cost of a connection on the CPU, relative to a ray and its shading.
pub(crate) fn cpu_connection_cost(config: &KernelConfig) -> f64 {
    if config.packets { PACKETS_CONNECTION_COST } else { CPU_CONNECTION_COST }
}

/// Cost of a connection in a kernel, relative to a ray and its shading.
pub(crate) fn kernel_connection_cost(is_software: bool) -> f64 {
    if is_software { SOFTWARE_CONNECTION_COST } else { GPU_CONNECTION_COST }
}

/// True in scenes where some surface is Lambertian, and nothing but the geometry decides what one sees of another.
pub(crate) fn is_possible(scene: &RenderScene, config: &KernelConfig) -> bool {
    let is_plain = !config.media && !config.shading_normals && !config.fast_caustics && !config.traced_caustics;
    is_plain && scene.materials.iter().any(|material| material.has(LAMBERTIAN))
}

/// True if a picture with this number of samples a pixel converges sooner with path reuse, if a connection costs as much as
/// this number of rays. `rival` is the error after the same time by other means, as a share of that of this configuration.
pub(crate) fn pays(
    scene: &RenderScene,
    frame: &FrameUniforms,
    config: &KernelConfig,
    samples: u32,
    rival: f64,
    connection_cost: f64,
) -> bool {
    let [width, height] = frame.size();
    let probe_paths = 2 * 2 * PROBE_SAMPLES * PROBE_GRID[0] * PROBE_GRID[1] * REUSE_TILE * REUSE_TILE;
    let is_large = probe::path_count(frame, samples) >= MIN_PATHS_PER_PROBE_PATH * f64::from(probe_paths);
    if !is_large || width.min(height) < REUSE_TILE {
        return false;
    }
    let counters = [RayCounters::default(), RayCounters::default()];
    let [apart, shared] = [false, true].map(|path_reuse| KernelConfig { path_reuse, splitting: 1, ..*config });
    let noise_of = |config, stats, tile| {
        noise_of_tile(&TraceContext { scene, frame, config, stats: Some(stats), photons: None }, tile)
    };
    let tiles = (0..PROBE_GRID[0] * PROBE_GRID[1]).into_par_iter();
    let variances: Vec<[[f64; 2]; 2]> = tiles
        .map(|tile| {
            let noise = [noise_of(&apart, &counters[0], tile), noise_of(&shared, &counters[1], tile)];
            let around = radiance_around(&noise[1]);
            let [apart, shared] = noise.map(|noise| {
                let own = probe::own_variance(&noise);
                [own, probe::relative_variance(&noise, &around, MAX_RARE_VARIANCE)]
            });
            [0, 1].map(|measure| [apart[measure], shared[measure]])
        })
        .collect();
    let [cost, shared_cost] = counters.each_ref().map(probe::cost);
    let shared_cost = cost + connection_cost * (shared_cost - cost);
    // By either measure.
    [0, 1].into_iter().any(|measure| {
        let sum = |side: usize| variances.iter().map(|tile| tile[measure][side]).sum::<f64>();
        sum(1) * shared_cost < (1.0 - MIN_GAIN) * rival * sum(0) * cost
    })
}

/// Noise of the pixels of a tile of the probe.
fn noise_of_tile(ctx: &TraceContext, tile: u32) -> Vec<Noise> {
    let [width, height] = ctx.frame.size();
    let corner = |cell: u32, cells: u32, length: u32| {
        let tiles = length / REUSE_TILE;
        (tiles * (2 * cell + 1) / (2 * cells)).min(tiles - 1) * REUSE_TILE
    };
    let left = corner(tile % PROBE_GRID[0], PROBE_GRID[0], width);
    let top = corner(tile / PROBE_GRID[0], PROBE_GRID[1], height);
    let pixels: Vec<(u32, u32)> =
        (top..top + REUSE_TILE).flat_map(|y| (left..left + REUSE_TILE).map(move |x| (x, y))).collect();
    probe::noise(ctx, &pixels, PROBE_SAMPLES)
}

/// Radiance around each pixel of a tile: that of its neighbours or of the tile, whichever is brighter. Its own samples do not
/// count, so that a pixel that is bright by chance is no less noisy for it.
fn radiance_around(tile: &[Noise]) -> Vec<DVec3> {
    let side = REUSE_TILE as usize;
    let of_tile = tile.iter().map(|noise| noise.mean).sum::<DVec3>() / tile.len() as f64;
    let near = |at: usize| at.saturating_sub(1)..(at + 2).min(side);
    let of_neighbours = |pixel: usize| {
        let (x, y) = (pixel % side, pixel / side);
        let neighbours = near(y).flat_map(|y| near(x).map(move |x| y * side + x)).filter(|&other| other != pixel);
        let (sum, count) =
            neighbours.fold((DVec3::ZERO, 0.0), |(sum, count), other| (sum + tile[other].mean, count + 1.0));
        sum / count
    };
    (0..tile.len()).map(|pixel| of_neighbours(pixel).max(of_tile)).collect()
}
