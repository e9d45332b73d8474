//! Choice of the number of light paths of each sample.
//!
//! **Idea.** With n light paths the variance of a sample is C + L/n, and its cost c + n l, where c is the cost of its camera paths.
//! The error after a given time is proportional to their product. [`best_path_count`] renders some pixels of the picture with two
//! seeds of camera paths and two of light paths. Values of one seed of camera paths differ by L/n, those where both seeds differ by
//! all the variance. It counts operations and measures no time, so that the same picture always has the same number.
//!
//! The discs of photons shrink as samples add up, so that light paths become noisier. So the samples that are rendered are in
//! the middle of the picture's.
//!
//! **Source.** Numbers of samples from the variances and costs of both parts: Bolin and Meyer 1997, "An Error Metric for Monte Carlo
//! Ray Tracing", section 4.
//!
//! **Cost.** 131,000 light paths and 14,000 camera paths on the CPU, for pictures of at least forty times as many paths.

use super::MIN_LIGHT_PATHS;
use super::emission::Emission;
use super::light_path::photons;
use crate::integrator::path;
use crate::integrator::probe::{self, MAX_VARIANCE, Noise};
use crate::integrator::splitting::camera_ray_index;
use crate::ray_stats::RayCounters;
use crate::sampling::sobol::hash;
use crate::scene::{FrameUniforms, KernelConfig, PhotonMap, TraceContext};
use crate::settings::MAX_LIGHT_PATHS;
use glam::DVec3;
use rayon::prelude::*;

/// Columns and rows of probed pixels.
const PROBE_GRID: [u32; 2] = [40, 22];
/// Successive samples of each probed pixel, with each pair of seeds.
const PROBE_SAMPLES: u32 = 4;
/// Light paths of each of these samples.
const PROBE_LIGHT_PATHS: u32 = 1 << 14;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 40.0;
/// Numbers of light paths for each pixel that are compared. Few, so that machines which round differently agree.
const PATHS_PER_PIXEL: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 1.0, 2.0];

/// Cost of a ray of a light path on the CPU and of what it leaves in the map, relative to a ray of a camera path: 1.1 to 2.1, and 0.7
/// where paths stay in glass for long.
pub(crate) const CPU_LIGHT_RAY_COST: f64 = 1.5;
/// Cost of a ray of a light path, which the CPU traces, relative to a ray of a camera path on a GPU; not measured.
const GPU_LIGHT_RAY_COST: f64 = 30.0;

/// Cost of a ray of a light path, relative to a ray of a camera path in a kernel.
pub(crate) fn kernel_light_ray_cost(is_software: bool) -> f64 {
    if is_software { CPU_LIGHT_RAY_COST } else { GPU_LIGHT_RAY_COST }
}

/// Best number of light paths of a sample in a picture with `samples` samples a pixel; `None` if it is too small for a probe. A
/// ray of a light path costs as much as this number of rays of camera paths.
pub(crate) fn best_path_count(
    picture: &TraceContext,
    emission: &Emission,
    samples: u32,
    light_ray_cost: f64,
) -> Option<u32> {
    let pixels = probe::pixels(picture.frame, PROBE_GRID);
    let probe_light_paths = f64::from(2 * PROBE_SAMPLES * PROBE_LIGHT_PATHS);
    let probe_camera_paths = f64::from(4 * PROBE_SAMPLES) * pixels.len() as f64;
    let smallest = MIN_PATHS_PER_PROBE_PATH * (probe_light_paths + probe_camera_paths);
    if probe::path_count(picture.frame, samples) < smallest {
        return None;
    }
    let config = KernelConfig { splitting: 1, ..*picture.config };
    let frames = [1, 2].map(|seed| FrameUniforms { seed: hash(picture.frame.seed ^ seed), ..*picture.frame });
    let [light_counters, camera_counters] = [RayCounters::default(), RayCounters::default()];
    let middle = camera_ray_index(samples / 2, picture.config.splitting);
    let first = middle - middle % PROBE_SAMPLES;
    let maps_of = |frame| {
        let ctx = TraceContext { frame, config: &config, stats: Some(&light_counters), ..*picture };
        let map = |sample| PhotonMap::new(frame, photons(&ctx, emission, sample, PROBE_LIGHT_PATHS), sample);
        (first..first + PROBE_SAMPLES).map(map).collect::<Vec<_>>()
    };
    let means_of = |frame, maps: &[PhotonMap]| {
        let ctx = TraceContext { frame, config: &config, stats: Some(&camera_counters), ..*picture };
        let of_row = |row: &[(u32, u32)]| {
            let mut sums = vec![DVec3::ZERO; row.len()];
            for (sample, map) in (first..).zip(maps) {
                let values = path::trace(&TraceContext { photons: Some(map), ..ctx }, row, sample, 1);
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value.as_dvec3());
            }
            sums.into_iter().map(|sum| sum / f64::from(PROBE_SAMPLES))
        };
        pixels.par_chunks(PROBE_GRID[0] as usize).flat_map_iter(of_row).collect::<Vec<_>>()
    };
    // By seed of the light paths and seed of the camera paths.
    let means = frames.each_ref().map(maps_of).map(|maps| frames.each_ref().map(|frame| means_of(frame, &maps)));

    let [[a, b], [c, d]] = &means;
    let radiance: Vec<DVec3> = (0..pixels.len()).map(|k| 0.25 * (a[k] + b[k] + c[k] + d[k])).collect();
    let variance_between = |pairs: [[&Vec<DVec3>; 2]; 2]| {
        let squares = |k: usize| pairs.iter().map(|[a, b]| (a[k] - b[k]) * (a[k] - b[k])).sum::<DVec3>();
        let noise = |k: usize| Noise { mean: radiance[k], variance: 0.25 * squares(k) };
        probe::relative_variance(&(0..pixels.len()).map(noise).collect::<Vec<_>>(), &radiance, MAX_VARIANCE)
    };
    let of_light_paths = variance_between([[a, c], [b, d]]);
    let of_camera_paths = (variance_between([[a, d], [b, c]]) - of_light_paths).max(0.0);

    let pixel_count = probe::path_count(picture.frame, 1);
    let light_path_cost = light_ray_cost * probe::cost(&light_counters) / probe_light_paths;
    let camera_cost = pixel_count * probe::cost(&camera_counters) / probe_camera_paths;
    // Paths that share a camera ray share a map.
    let sharing = f64::from(picture.config.splitting);
    let error = |paths: f64| {
        let of_light_paths = of_light_paths * f64::from(PROBE_LIGHT_PATHS) / paths;
        (of_camera_paths + of_light_paths) * (camera_cost * sharing + paths * light_path_cost)
    };
    let counts = PATHS_PER_PIXEL.map(|share| share * pixel_count);
    let counts = counts.map(|count| count.clamp(f64::from(MIN_LIGHT_PATHS), f64::from(MAX_LIGHT_PATHS)));
    counts.into_iter().min_by(|a, b| error(*a).total_cmp(&error(*b))).map(|count| count as u32)
}
