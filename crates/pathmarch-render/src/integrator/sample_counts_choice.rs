//! Choice of the numbers of light samples and of indirect samples at the first surface of a path.
//!
//! **Idea.** Where much of the noise is direct light of many lamps, several light samples at the first surface are cheaper than as
//! many paths. They are stratified: each chooses among another part of the lights. Then one more ray that leaves the surface is
//! cheap beside them: several of these, each with a path of its own behind it, are the indirect samples. [`best_sample_counts`]
//! renders some pixels of the picture with 1, 2, 4 and 8 light samples and with four indirect samples, and compares the products of
//! variance and cost. There are at most half as many indirect samples as light samples: where most noise is indirect light,
//! [`splitting`](super::splitting) and [`path_reuse`](super::path_reuse) reduce it.
//!
//! Successive samples of the picture's sampler are rendered, because direct light converges faster than independent samples tell.
//! Pixels at edges of emitters do not count if they have further camera rays.
//!
//! **Source.** Splitting where it reduces the error for the same cost: Arvo and Kirk 1990, "Particle Transport and Image
//! Synthesis", section 5.
//!
//! **Cost.** 46,000 paths on the CPU, for pictures of at least a hundred times as many.

use super::emitter_edges::EmitterEdges;
use super::probe::{self, Noise};
use crate::ray_stats::RayCounters;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use crate::settings::MAX_LIGHT_SAMPLES;
use rayon::prelude::*;

/// Columns and rows of probed pixels.
const PROBE_GRID: [u32; 2] = [32, 18];
/// Successive samples of each probed pixel, with each of two seeds.
const PROBE_SAMPLES: u32 = 8;
/// Numbers of light samples that are compared, and of indirect samples.
const CANDIDATES: [u32; 4] = [1, 2, 4, MAX_LIGHT_SAMPLES];
/// Number of indirect samples of the probe that tells their share of the noise.
const PROBED_INDIRECT_SAMPLES: u32 = 4;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 100.0;
/// Smallest relative reduction of the error that justifies more samples.
const MIN_GAIN: f64 = 0.1;
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
    const ONE: Self = Self { light: 1, indirect: 1 };
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
    let probes = 2 * PROBE_SAMPLES * (CANDIDATES.len() as u32 + 1);
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
    let of_light_samples = CANDIDATES.map(|light| variance_and_cost(SampleCounts { light, indirect: 1 }));
    // With most light samples, so that their noise hides little.
    let [(_, cost), .., (most_variance, most_cost)] = of_light_samples;
    let indirect = PROBED_INDIRECT_SAMPLES;
    let (least_variance, more_cost) = variance_and_cost(SampleCounts { light: MAX_LIGHT_SAMPLES, indirect });
    let probed = f64::from(indirect);
    // Variance that indirect samples reduce, and the cost of one.
    let indirect_variance = ((most_variance - least_variance) / (1.0 - 1.0 / probed)).max(0.0);
    let indirect_cost = (more_cost - most_cost) / (probed - 1.0);
    let cost_of_more = if in_lanes { COST_IN_LANES } else { 1.0 };
    let error = |(light, indirect): (usize, usize)| {
        let (variance_of_light, cost_of_light) = of_light_samples[light];
        let rays = f64::from(CANDIDATES[indirect]);
        let variance = variance_of_light - indirect_variance * (1.0 - 1.0 / rays);
        let more = cost_of_light - cost + indirect_cost * (rays - 1.0);
        variance.max(0.0) * (cost + cost_of_more * more)
    };
    let indices = 0..CANDIDATES.len();
    let alone = best_among(indices.clone().map(|light| (light, 0)), error);
    let halves = indices.flat_map(|light| (0..light.max(1)).map(move |indirect| (light, indirect)));
    let best = best_among(halves, error);
    BestCounts {
        counts: SampleCounts { light: CANDIDATES[best.0], indirect: CANDIDATES[best.1] },
        light_alone: CANDIDATES[alone.0],
        error: if error(alone) > 0.0 { error(best) / error(alone) } else { 1.0 },
    }
}

/// Pair of indices of numbers of light samples and of indirect samples with the least error, the costlier ones last.
fn best_among(pairs: impl Iterator<Item = (usize, usize)>, error: impl Fn((usize, usize)) -> f64) -> (usize, usize) {
    let better = |best, pair| if error(pair) < (1.0 - MIN_GAIN) * error(best) { pair } else { best };
    pairs.fold((0, 0), better)
}
