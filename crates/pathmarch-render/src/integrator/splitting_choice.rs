//! How many paths share a ray of the camera.
//!
//! **Idea.** Where most of the noise is light that bounced, a new ray of the camera for each path finds the same surface again.
//! Instead k samples in a row begin at the surface that one ray met: they differ in their random numbers from there on, and each
//! is a path of its own, so that the picture stays what it was, whatever k. In a kernel, a lane whose path has ended takes
//! the next one of its ray, and does not wait for the lanes beside it.
//!
//! What it costs is smoothness of edges, of lenses and of moving things, which converge with the number of rays. With the variance
//! B between rays and W within one, and c₀ and c₁ as the costs of a ray and of a path from there on, the error after a given
//! time is proportional to (B + W/k) (c₀ + k c₁). [`best`] estimates all four by a few thousand paths of the picture
//! itself, and counts instead of timing, so that the same picture is always split the same way. Lanes that run together last as
//! long as the longest of them: the longest of eight sums of k lengths is k + 1.4 s √k, in mean lengths of a path whose
//! deviation is s of them.
//!
//! **Sources.** Splitting: Arvo and Kirk 1990, "Particle Transport and Image Synthesis", section 5. The best number of paths by
//! the variances and costs of both parts: Bolin and Meyer 1997, "An Error Metric for Monte Carlo Ray Tracing", section 4;
//! Rath et al. 2022, "EARS: Efficiency-Aware Russian Roulette and Splitting". Paths taken anew by idle lanes: Novák, Havran and
//! Dachsbacher 2010, "Path Regeneration for Interactive Path Tracing".
//!
//! **Cost.** 20,000 paths on the CPU, for pictures of at least 200 times as many.

use super::camera::{camera_rays, pixel_sampler};
use super::path;
use super::splitting::OWN_RAYS;
use crate::intersect::march::march;
use crate::intersect::ray::RaySegment;
use crate::metrics::RELMSE_EPSILON;
use crate::ray_stats::RayCounters;
use crate::sampling::sobol::{PixelSampler, hash};
use crate::scene::{FrameUniforms, KernelConfig, RenderScene, TraceContext};
use crate::settings::MAX_SPLITTING;
use glam::Vec3;
use pathmarch_scene::Sampler;
use rayon::prelude::*;

/// Pixels that are looked at, along each side.
const LOOKS: [u32; 2] = [48, 27];
/// Rays through each of them.
const RAYS: u32 = 4;
/// Paths that share each of these.
const PATHS: u32 = 4;
/// A picture has so many paths for each that is spent on this.
const WORTH: f64 = 200.0;

/// What an evaluation of the field costs, in rays with what belongs to them.
const EVALUATION: f64 = 0.25;
/// By how much the slowest of eight lanes exceeds their mean, for one path each, in mean lengths of a path.
const WAITING: f64 = 0.9;
/// More than this share must be gained by more paths for a ray, as they cost smoothness.
const GAIN: f64 = 0.05;

/// Number of paths that should share a camera ray, in a picture of so many samples; `in_lanes` where paths wait for their
/// neighbours, as in a kernel.
pub(crate) fn best(
    scene: &RenderScene,
    frame: &FrameUniforms,
    config: &KernelConfig,
    samples: u32,
    in_lanes: bool,
) -> u32 {
    let [width, height] = frame.size();
    let looks = LOOKS.map(f64::from).iter().product::<f64>() * f64::from(RAYS * PATHS);
    if f64::from(width) * f64::from(height) * f64::from(samples) < WORTH * looks {
        return 1;
    }
    let config = KernelConfig { splitting: PATHS, ..*config };
    // The probe shares no random numbers with the picture, and has no low-discrepancy sequence.
    let frame = FrameUniforms { seed: hash(frame.seed), sampler: Sampler::Independent as u32, ..*frame };
    let pixels: Vec<(u32, u32)> = (0..LOOKS[0] * LOOKS[1])
        .map(|k| {
            let somewhere = |cell: u32, cells: u32, length: u32, random: u32| {
                let within = f64::from(hash(2 * k + random)) / f64::from(u32::MAX);
                ((f64::from(cell) + within) / f64::from(cells) * f64::from(length)) as u32
            };
            let x = somewhere(k % LOOKS[0], LOOKS[0], width, 0).min(width - 1);
            (x, somewhere(k / LOOKS[0], LOOKS[1], height, 1).min(height - 1))
        })
        .collect();
    let (rays, all) = (RayCounters::default(), RayCounters::default());
    let context = |stats| TraceContext { scene, frame: &frame, config: &config, stats: Some(stats) };
    let variances = pixels.par_chunks(LOOKS[0] as usize).map(|pixels| {
        trace_camera_rays(&context(&rays), pixels);
        variances(&context(&all), pixels)
    });
    let [between, within] = variances.reduce(|| [0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let cost = |counters: &RayCounters| {
        let total = counters.total();
        total.rays as f64 + EVALUATION * total.evaluations as f64
    };
    let ray = cost(&rays);
    let path = (cost(&all) - ray) / f64::from(PATHS);
    let waiting = if in_lanes { WAITING } else { 0.0 };
    let error = |k: u32| {
        let k = f64::from(k);
        (between.max(0.0) + within / k) * (ray + (k + waiting * k.sqrt()) * path)
    };
    let most = MAX_SPLITTING.min(samples / OWN_RAYS).max(1);
    let doubled = (0..=most.ilog2()).map(|k| 1 << k);
    doubled.fold(1, |best, k| if error(k) < (1.0 - GAIN) * error(best) { k } else { best })
}

/// Traces camera rays alone.
fn trace_camera_rays(ctx: &TraceContext, pixels: &[(u32, u32)]) {
    for ray in OWN_RAYS..OWN_RAYS + RAYS {
        let randoms: Vec<PixelSampler> = pixels.iter().map(|&(x, y)| pixel_sampler(ctx.frame, x, y, ray)).collect();
        let rays = camera_rays(ctx.frame, pixels, &randoms).into_iter();
        march(ctx, &rays.map(|ray| RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }).collect::<Vec<_>>());
    }
}

/// The variance of a pixel between rays and within one, relative to its mean and summed over pixels.
fn variances(ctx: &TraceContext, pixels: &[(u32, u32)]) -> [f64; 2] {
    let of_ray = |ray: u32| path::trace(ctx, pixels, OWN_RAYS + ray * PATHS, PATHS);
    let of_rays: Vec<Vec<Vec3>> = (0..RAYS).map(of_ray).collect();
    let mut sums = [0.0; 2];
    for pixel in 0..pixels.len() {
        let paths: Vec<&[Vec3]> =
            of_rays.iter().map(|values| &values[pixel * PATHS as usize..][..PATHS as usize]).collect();
        for channel in 0..3 {
            let [between, within] = parts(&paths, |value| f64::from(value[channel]));
            // What is not finite says nothing.
            if between.is_finite() && within.is_finite() {
                sums[0] += between;
                sums[1] += within;
            }
        }
    }
    sums
}

/// The parts of the variance of numbers that come in groups of [`PATHS`], between and within groups, relative to their mean as
/// relMSE is, and limited so that no pixel outweighs all others.
fn parts(groups: &[&[Vec3]], number: impl Fn(Vec3) -> f64) -> [f64; 2] {
    const LIMIT: f64 = 10.0;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let variance = |values: &[f64]| {
        let mean = mean(values);
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
    };
    let groups: Vec<Vec<f64>> = groups.iter().map(|group| group.iter().map(|&value| number(value)).collect()).collect();
    let means: Vec<f64> = groups.iter().map(|group| mean(group)).collect();
    let within = mean(&groups.iter().map(|group| variance(group)).collect::<Vec<_>>());
    // The means of groups vary by what is within them, too.
    let between = variance(&means) - within / groups[0].len() as f64;
    let scale = 1.0 / (mean(&means).powi(2) + RELMSE_EPSILON);
    [between * scale, within * scale].map(|part| part.clamp(-LIMIT, LIMIT))
}

#[cfg(test)]
mod tests {
    use super::super::splitting::{ray_of, together};
    use super::*;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    /// What is best for a picture of this size and these samples.
    fn best_of(text: &str, size: [u32; 2], samples: u32) -> u32 {
        let scene = Scene::parse("test.kdl", text).expect("valid");
        let settings = Settings { size, samples, ..Settings::of(&scene) };
        {
            let camera = settings.camera_of(&scene);
            let tables = RenderScene::new(&scene, camera);
            let frame = FrameUniforms::new(&scene, &settings, &tables.sky, &tables.lights);
            best(&tables, &frame, &KernelConfig::new(&tables, &settings), samples, true)
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
    fn every_sample_belongs_to_the_ray_that_it_is_begun_with() {
        for splitting in 1..=MAX_SPLITTING {
            let (mut sample, mut ray) = (0, 0);
            while sample < 100 {
                let begun = together(sample, splitting, 100 - sample);
                assert!(begun >= 1 && (sample >= OWN_RAYS || begun == 1));
                assert!((sample..sample + begun).all(|sample| ray_of(sample, splitting) == ray));
                (sample, ray) = (sample + begun, ray + 1);
            }
            assert_eq!(sample, 100);
            // One that is joined later begins with what is left of its ray.
            assert_eq!(together(OWN_RAYS + 1, splitting, 100), if splitting == 1 { 1 } else { splitting - 1 });
        }
    }

    #[test]
    fn light_that_bounced_is_split() {
        assert!(best_of(ROOM, [640, 360], 256) >= 4);
    }

    #[test]
    fn a_pixel_keeps_rays_enough_for_its_edges() {
        assert_eq!(best_of(ROOM, [640, 360], 32), 2);
        assert_eq!(best_of(ROOM, [640, 360], 31), 1);
        // Too few to look twice.
        assert_eq!(best_of(ROOM, [64, 36], 256), 1);
    }

    #[test]
    fn edges_and_lenses_are_not_split() {
        // Many bright balls, smaller than a pixel.
        let mut balls = String::from("pathmarch 1\ncamera { position 0 0 9; target 0 0 0; fov 20 }\n");
        balls += "material \"lamp\" { emit 5 }\nmaterial \"dark\" { diffuse 0 }\n";
        balls += "object \"balls\" material=\"lamp\" { repeat 0.1 0.1 0 { sphere 0.01 } }\n";
        balls += "object \"back\" material=\"dark\" { rect 9 9 { normal 0 0 1; at 0 0 -1 } }\n";
        assert_eq!(best_of(&balls, [640, 360], 256), 1);
        let lens = ROOM.replace("fov 60", "fov 60; lens radius=0.3 focus=0.5");
        assert!(best_of(&lens, [640, 360], 256) <= best_of(ROOM, [640, 360], 256));
    }
}
