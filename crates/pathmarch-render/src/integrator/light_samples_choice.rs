//! Choice of the number of light samples at the first surface of a path.
//!
//! **Idea.** Where much of the noise is direct light of many lamps, several light samples at the first surface are cheaper
//! than as many paths. They are stratified: each chooses among another part of the lights. [`best_light_samples`] renders
//! some pixels of the picture with 1, 2, 4 and 8, and compares the products of variance and cost.
//!
//! **Source.** Splitting where it reduces the error for the same cost: Arvo and Kirk 1990, "Particle Transport and Image
//! Synthesis", section 5.
//!
//! **Cost.** 18,000 paths on the CPU, for pictures of at least a hundred times as many.

use super::probe::{self, Noise};
use crate::ray_stats::RayCounters;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use rayon::prelude::*;

/// Columns and rows of probed pixels.
const PROBE_GRID: [u32; 2] = [32, 18];
/// Samples of each probed pixel.
const PROBE_SAMPLES: u32 = 8;
/// Numbers of light samples that are tried.
const CANDIDATES: [u32; 4] = [1, 2, 4, 8];
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 100.0;
/// Smallest relative reduction of the error that justifies more samples.
const MIN_GAIN: f64 = 0.05;
/// Cost of a light sample more in a kernel whose lanes take a new path when theirs has ended, in those on the CPU: where
/// lanes are at different surfaces, all wait for those at the first. On llvmpipe 5 to 6.
const COST_IN_LANES: f64 = 6.0;

/// Best number of light samples at the first surface of each path, in a picture with `samples` samples a pixel. With
/// `in_lanes`, lanes of a kernel take new paths, see [`splitting`](super::splitting).
pub(crate) fn best_light_samples(
    scene: &RenderScene,
    frame: &FrameUniforms,
    config: &KernelConfig,
    samples: u32,
    in_lanes: bool,
) -> u32 {
    let probe_paths = f64::from(PROBE_GRID[0] * PROBE_GRID[1] * PROBE_SAMPLES) * CANDIDATES.len() as f64;
    if scene.lights.len() < 2 || probe::path_count(frame, samples) < MIN_PATHS_PER_PROBE_PATH * probe_paths {
        return 1;
    }
    let pixels = probe::pixels(frame, PROBE_GRID);
    let frame = probe::frame_of(frame);
    let variance_and_cost = |light_samples: u32| {
        let config = KernelConfig { light_samples, splitting: 1, path_reuse: false, ..*config };
        let counters = RayCounters::default();
        let ctx = TraceContext { scene, frame: &frame, config: &config, stats: Some(&counters), photons: None };
        let rows = pixels.par_chunks(PROBE_GRID[0] as usize);
        let noise: Vec<Noise> = rows.flat_map_iter(|row| probe::noise(&ctx, row, PROBE_SAMPLES)).collect();
        (probe::own_variance(&noise), probe::cost(&counters))
    };
    let tried = CANDIDATES.map(variance_and_cost);
    let least_cost = tried[0].1;
    let cost_of_more = if in_lanes { COST_IN_LANES } else { 1.0 };
    let errors = tried.map(|(variance, cost)| variance * (least_cost + cost_of_more * (cost - least_cost)));
    let better = |best: usize, k: usize| if errors[k] < (1.0 - MIN_GAIN) * errors[best] { k } else { best };
    CANDIDATES[(0..CANDIDATES.len()).fold(0, better)]
}
