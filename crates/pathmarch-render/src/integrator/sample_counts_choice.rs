//! Choice of the numbers of light samples and of indirect samples at the first surface of a path.
//!
//! **Idea.** Where much of the noise is direct light of many lamps, several light samples at the first surface are cheaper than as
//! many paths. They are stratified: each chooses among another part of the lights. Then one more ray that leaves the surface is
//! cheap beside them: several of these, each with a path of its own behind it, are the indirect samples. [`best_sample_counts`]
//! renders some pixels of the picture with several numbers of both, and compares the errors after the same time. There are fewer
//! indirect samples than light samples: where most noise is indirect light, [`splitting`](super::splitting) and
//! [`path_reuse`](super::path_reuse) reduce it.
//!
//! Successive samples of the picture's sampler are rendered, because direct light converges faster than independent samples tell.
//! Pixels at edges of emitters do not count if they have further camera rays.
//!
//! **Source.** Splitting where it reduces the error for the same cost: Arvo and Kirk 1990, "Particle Transport and Image
//! Synthesis", section 5.
//!
//! **Cost.** 56,000 paths on the CPU, for pictures of at least forty times as many.

use super::emitter_edges::EmitterEdges;
use super::probe::{self, Noise};
use crate::ray_stats::RayCounters;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use rayon::prelude::*;

/// Columns and rows of probed pixels.
const PROBE_GRID: [u32; 2] = [40, 22];
/// Successive samples of each probed pixel, with each of two seeds.
const PROBE_SAMPLES: u32 = 8;
/// Numbers of samples that are compared, the costlier ones last. Eight light samples converge no faster than four.
const CANDIDATES: [SampleCounts; 4] =
    [SampleCounts::ONE, SampleCounts::of(2, 1), SampleCounts::of(4, 1), SampleCounts::of(4, 2)];
/// Power of the number of samples by which errors fall, measured with 6 to 44 samples.
const CONVERGENCE: f64 = 1.25;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 40.0;
/// Smallest relative reduction of the error that justifies more samples.
const MIN_GAIN: f64 = 0.05;
/// Cost of a sample more in a kernel whose lanes take a new path when theirs has ended, in those on the CPU: where lanes are at
/// different surfaces, all wait for those at the first. On llvmpipe 5 to 6.
const COST_IN_LANES: f64 = 6.0;

/// Numbers of samples at the first surface of each path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleCounts {
    pub(crate) light: u32,
    pub(crate) indirect: u32,
}

impl SampleCounts {
    const ONE: Self = Self::of(1, 1);

    const fn of(light: u32, indirect: u32) -> Self {
        Self { light, indirect }
    }
}

/// Choice of the numbers of samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BestCounts {
    pub(crate) counts: SampleCounts,
    /// Best number of light samples with one indirect sample.
    pub(crate) light_alone: u32,
    /// Estimated error after the same time with the best counts, as a share of that with one indirect sample.
    pub(crate) error: f64,
}

impl BestCounts {
    /// These numbers, which nobody compared with others.
    pub(crate) fn given(counts: SampleCounts) -> Self {
        Self { counts, light_alone: counts.light, error: 1.0 }
    }

    /// One sample each.
    pub(crate) fn one() -> Self {
        Self::given(SampleCounts::ONE)
    }
}

/// Best numbers of samples at the first surface in a picture with `samples` samples a pixel. With `in_lanes`, lanes of a kernel
/// take new paths, see [`splitting`](super::splitting).
pub(crate) fn best_sample_counts(
    scene: &RenderScene,
    frame: &FrameUniforms,
    config: &KernelConfig,
    samples: u32,
    edges: Option<&EmitterEdges>,
    in_lanes: bool,
) -> BestCounts {
    let probes = 2 * PROBE_SAMPLES * CANDIDATES.len() as u32;
    let probe_paths = f64::from(PROBE_GRID[0] * PROBE_GRID[1] * probes);
    if scene.lights.len() < 2 || probe::path_count(frame, samples) < MIN_PATHS_PER_PROBE_PATH * probe_paths {
        return BestCounts::one();
    }
    let mut pixels = probe::pixels(frame, PROBE_GRID);
    pixels.retain(|&(x, y)| edges.is_none_or(|edges| !edges.contains(x, y)));
    let variance_and_cost = |counts: SampleCounts| {
        let SampleCounts { light: light_samples, indirect: indirect_samples } = counts;
        let config = KernelConfig { light_samples, indirect_samples, splitting: 1, path_reuse: false, ..*config };
        let counters = RayCounters::default();
        let ctx = TraceContext { scene, frame, config: &config, stats: Some(&counters), photons: None };
        let rows = pixels.par_chunks(PROBE_GRID[0] as usize);
        let noise: Vec<Noise> = rows.flat_map_iter(|row| probe::noise(&ctx, row, PROBE_SAMPLES)).collect();
        (probe::own_variance(&noise), probe::cost(&counters))
    };
    let tried = CANDIDATES.map(variance_and_cost);
    let least_cost = tried[0].1;
    let cost_of_more = if in_lanes { COST_IN_LANES } else { 1.0 };
    let errors = tried.map(|(variance, cost)| {
        let cost = least_cost + cost_of_more * (cost - least_cost);
        variance * cost.powf(CONVERGENCE)
    });
    let better = |best: usize, k: usize| if errors[k] < (1.0 - MIN_GAIN) * errors[best] { k } else { best };
    let best = (0..CANDIDATES.len()).fold(0, better);
    let alone = (0..CANDIDATES.len()).filter(|&k| CANDIDATES[k].indirect == 1).fold(0, better);
    BestCounts {
        counts: CANDIDATES[best],
        light_alone: CANDIDATES[alone].light,
        error: if errors[alone] > 0.0 { errors[best] / errors[alone] } else { 1.0 },
    }
}
