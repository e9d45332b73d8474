//! Choice of the splitting: the number of paths that share a camera ray.
//!
//! **Idea.** Splitting ([`splitting`](super::splitting)) reduces the noise of indirect light. Edges, depth of field and
//! motion blur converge with the number of camera rays, so splitting makes them noisier. With variance B between camera
//! rays and W within one, and costs c₀ of a camera ray and c₁ of a path from its hit on, the error after a given time
//! is proportional to (B + W/k) (c₀ + k c₁). [`best_splitting`] estimates all four with a few thousand paths of the
//! picture itself. It counts operations and measures no time, so that the same picture always has the same splitting.
//! Lanes that run together take as long as the slowest of them: the longest of eight sums of k lengths is k + 1.4 s √k
//! mean path lengths, with s the standard deviation of a path's length in mean lengths.
//!
//! **Sources.** Splitting: Arvo and Kirk 1990, "Particle Transport and Image Synthesis", section 5. Best number of
//! paths from the variances and costs of both parts: Bolin and Meyer 1997, "An Error Metric for Monte Carlo Ray
//! Tracing", section 4; Rath et al. 2022, "EARS: Efficiency-Aware Russian Roulette and Splitting". Regeneration of
//! paths in idle lanes: Novák, Havran and Dachsbacher 2010, "Path Regeneration for Interactive Path Tracing".
//!
//! **Cost.** 20,000 paths on the CPU, for pictures of at least 200 times as many.

use super::camera::{camera_rays, pixel_sampler};
use super::splitting::UNSPLIT_SAMPLES;
use super::{path, path_reuse, probe};
use crate::intersect::march::march;
use crate::intersect::ray::RaySegment;
use crate::metrics::RELMSE_EPSILON;
use crate::ray_stats::RayCounters;
use crate::sampling::sobol::PixelSampler;
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use crate::settings::MAX_SPLITTING;
use glam::Vec3;
use rayon::prelude::*;

/// Columns and rows of probed pixels.
const PROBE_GRID: [u32; 2] = [48, 27];
/// Camera rays through each probed pixel.
const PROBE_RAYS: u32 = 4;
/// Paths that share each of these camera rays.
const PROBE_PATHS: u32 = 4;
/// Smallest number of paths of a picture for each path of the probe.
const MIN_PATHS_PER_PROBE_PATH: f64 = 200.0;

/// Excess of the slowest of eight lanes over their mean, for one path each, in mean path lengths.
const LANE_WAIT: f64 = 0.9;
/// Smallest relative reduction of the error that justifies a larger splitting, because edges are less smooth with it.
const MIN_GAIN: f64 = 0.05;

/// Best number of paths that share a camera ray, in a picture with `samples` samples a pixel. With `in_lanes`, paths
/// wait for their neighbours, as in a kernel.
pub(crate) fn best_splitting(
    scene: &RenderScene,
    frame: &FrameUniforms,
    config: &KernelConfig,
    samples: u32,
    in_lanes: bool,
) -> u32 {
    let probe_paths = PROBE_GRID.map(f64::from).iter().product::<f64>() * f64::from(PROBE_RAYS * PROBE_PATHS);
    if probe::path_count(frame, samples) < MIN_PATHS_PER_PROBE_PATH * probe_paths {
        return 1;
    }
    let config = KernelConfig { splitting: PROBE_PATHS, ..*config };
    let frame = probe::frame_of(frame);
    let pixels = probe::pixels(&frame, PROBE_GRID);
    let (ray_counters, path_counters) = (RayCounters::default(), RayCounters::default());
    let context = |stats| TraceContext { scene, frame: &frame, config: &config, stats: Some(stats), photons: None };
    let variances = pixels.par_chunks(PROBE_GRID[0] as usize).map(|pixels| {
        trace_camera_rays(&context(&ray_counters), pixels);
        variances(&context(&path_counters), pixels)
    });
    // In the order of the rows, so that the sums are always the same.
    let variances: Vec<[f64; 2]> = variances.collect();
    let [between, within] = variances.iter().fold([0.0; 2], |sum, row| [sum[0] + row[0], sum[1] + row[1]]);
    let ray_cost = probe::cost(&ray_counters);
    let path_cost = (probe::cost(&path_counters) - ray_cost) / f64::from(PROBE_PATHS);
    let lane_wait = if in_lanes { LANE_WAIT } else { 0.0 };
    let error = |k: u32| {
        let k = f64::from(k);
        (between.max(0.0) + within / k) * (ray_cost + (k + lane_wait * k.sqrt()) * path_cost)
    };
    let max_splitting = if config.path_reuse { path_reuse::MAX_SPLITTING } else { MAX_SPLITTING };
    let max_splitting = max_splitting.min(samples / UNSPLIT_SAMPLES).max(1);
    let powers_of_two = (0..=max_splitting.ilog2()).map(|k| 1 << k);
    powers_of_two.fold(1, |best, k| if error(k) < (1.0 - MIN_GAIN) * error(best) { k } else { best })
}

/// Traces camera rays alone.
fn trace_camera_rays(ctx: &TraceContext, pixels: &[(u32, u32)]) {
    for ray in UNSPLIT_SAMPLES..UNSPLIT_SAMPLES + PROBE_RAYS {
        let samplers: Vec<PixelSampler> = pixels.iter().map(|&(x, y)| pixel_sampler(ctx, x, y, ray)).collect();
        let rays = camera_rays(ctx.frame, pixels, &samplers).into_iter();
        march(ctx, &rays.map(|ray| RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }).collect::<Vec<_>>());
    }
}

/// Variance of a pixel between camera rays and within one, relative to its mean and summed over pixels.
fn variances(ctx: &TraceContext, pixels: &[(u32, u32)]) -> [f64; 2] {
    let trace_ray = |ray: u32| path::trace(ctx, pixels, UNSPLIT_SAMPLES + ray * PROBE_PATHS, PROBE_PATHS);
    let values_of_rays: Vec<Vec<Vec3>> = (0..PROBE_RAYS).map(trace_ray).collect();
    let mut sums = [0.0; 2];
    for pixel in 0..pixels.len() {
        let paths: Vec<&[Vec3]> = values_of_rays
            .iter()
            .map(|values| &values[pixel * PROBE_PATHS as usize..][..PROBE_PATHS as usize])
            .collect();
        for channel in 0..3 {
            let [between, within] = variance_components(&paths, |value| f64::from(value[channel]));
            // Ignore values that are not finite.
            if between.is_finite() && within.is_finite() {
                sums[0] += between;
                sums[1] += within;
            }
        }
    }
    sums
}

/// Variance between and within groups of [`PROBE_PATHS`] values, relative to their mean as in relMSE, and clamped so
/// that no pixel dominates the sum.
fn variance_components(groups: &[&[Vec3]], component: impl Fn(Vec3) -> f64) -> [f64; 2] {
    const LIMIT: f64 = 10.0;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let variance = |values: &[f64]| {
        let mean = mean(values);
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
    };
    let groups: Vec<Vec<f64>> =
        groups.iter().map(|group| group.iter().map(|&value| component(value)).collect()).collect();
    let means: Vec<f64> = groups.iter().map(|group| mean(group)).collect();
    let within = mean(&groups.iter().map(|group| variance(group)).collect::<Vec<_>>());
    // The variance within groups adds to that of their means.
    let between = variance(&means) - within / groups[0].len() as f64;
    let scale = 1.0 / (mean(&means).powi(2) + RELMSE_EPSILON);
    [between * scale, within * scale].map(|component| component.clamp(-LIMIT, LIMIT))
}

#[cfg(test)]
mod tests {
    use super::super::splitting::{camera_ray_index, samples_sharing_ray};
    use super::*;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    /// Best splitting of a scene for a picture of this size and number of samples.
    fn best_for(text: &str, size: [u32; 2], samples: u32) -> u32 {
        let scene = Scene::parse("test.kdl", text).expect("valid");
        let settings = Settings { size, samples, ..Settings::of(&scene) };
        {
            let camera = settings.camera_of(&scene);
            let render_scene = RenderScene::new(&scene, camera);
            let frame = FrameUniforms::new(&scene, &settings, &render_scene);
            best_splitting(&render_scene, &frame, &KernelConfig::new(&render_scene, &settings), samples, true)
        }
    }

    const ROOM: &str = r#"pathmarch 1
camera { position 0 1 0.9; target 0 1 -1; fov 60 }
render { bounces 6 }
material "white" { diffuse 0.8 }
material "lamp" { emit 20 }
object "room" material="white" { box 2 2 2 { at 0 1 0 } }
object "lamp" material="lamp" { sphere 0.1 { at 0.6 1.7 0.5 } }
"#;

    #[test]
    fn every_sample_belongs_to_the_ray_that_it_starts_with() {
        for splitting in 1..=MAX_SPLITTING {
            let (mut sample, mut ray) = (0, 0);
            while sample < 100 {
                let count = samples_sharing_ray(sample, splitting, 100 - sample);
                assert!(count >= 1 && (sample >= UNSPLIT_SAMPLES || count == 1));
                assert!((sample..sample + count).all(|sample| camera_ray_index(sample, splitting) == ray));
                (sample, ray) = (sample + count, ray + 1);
            }
            assert_eq!(sample, 100);
            // A range that starts in the middle of a ray takes the remaining samples of the ray.
            assert_eq!(
                samples_sharing_ray(UNSPLIT_SAMPLES + 1, splitting, 100),
                if splitting == 1 { 1 } else { splitting - 1 }
            );
        }
    }

    #[test]
    fn indirect_light_is_split() {
        assert!(best_for(ROOM, [640, 360], 256) >= 4);
    }

    #[test]
    fn a_pixel_keeps_enough_rays_for_its_edges() {
        assert_eq!(best_for(ROOM, [640, 360], 32), 2);
        assert_eq!(best_for(ROOM, [640, 360], 31), 1);
        // Too few paths to pay for the probe.
        assert_eq!(best_for(ROOM, [64, 36], 256), 1);
    }

    #[test]
    fn edges_and_lenses_are_not_split() {
        // Many bright spheres, smaller than a pixel.
        let mut balls = String::from("pathmarch 1\ncamera { position 0 0 9; target 0 0 0; fov 20 }\n");
        balls += "material \"lamp\" { emit 5 }\nmaterial \"dark\" { diffuse 0 }\n";
        balls += "object \"balls\" material=\"lamp\" { repeat 0.1 0.1 0 { sphere 0.01 } }\n";
        balls += "object \"back\" material=\"dark\" { rect 9 9 { normal 0 0 1; at 0 0 -1 } }\n";
        assert_eq!(best_for(&balls, [640, 360], 256), 1);
        let lens = ROOM.replace("fov 60", "fov 60; lens radius=0.3 focus=0.5");
        assert!(best_for(&lens, [640, 360], 256) <= best_for(ROOM, [640, 360], 256));
    }
}
