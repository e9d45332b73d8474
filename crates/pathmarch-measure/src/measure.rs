//! Measurements shared by `bench` and `study`: time per sample, and error against a converged reference.
//!
//! **Idea.** The error of a picture is its relMSE against a reference, which has noise of its own. The reference is the
//! mean of two halves with equally many samples and different seeds. The relMSE of one half against that mean estimates
//! the relMSE of the mean itself, as the mean's variance is a fourth of the variance of the difference of the halves.
//! Errors of independent pictures add up, so subtracting this estimate leaves the error of the measured picture, which
//! has yet another seed.
//!
//! **Source.** relMSE: [`pathmarch_render::metrics`]. Variance from two independent halves: Rousselle, Knaus, Zwicker,
//! "Robust Denoising using Feature and Color Information", Pacific Graphics 2013, section 3.
//!
//! **Cost.** A reference with four times the samples of the measured picture has at most a fourth of its error.

use pathmarch_cli::Failure;
use pathmarch_render::image::{self, Picture, Provenance};
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::{Caustics, Scene, Tonemap};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Job, RenderError, Renderer, Settings, adapters, scene_hash};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Sample count of pictures that are limited by time.
pub const MAX_SAMPLES: u32 = 1_000_000;

/// Ctrl-C, checked between slices of work.
#[derive(Clone)]
pub struct Interrupt(pub Arc<AtomicBool>);

impl Interrupt {
    /// Fails if the user has pressed Ctrl-C.
    pub fn check(&self) -> Result<(), Failure> {
        if self.0.load(Ordering::SeqCst) { Err(Failure::Interrupted) } else { Ok(()) }
    }
}

/// Backend with its adapter, as named in results.
pub fn backend_label(renderer: &Renderer) -> String {
    format!("{} ({})", renderer.backend().name, renderer.backend().adapter)
}

/// Opens the backends to measure: without a choice, every usable adapter and the CPU. `adapter` is part of an adapter's
/// name.
pub fn renderers(backend: Option<Backend>, adapter: Option<&str>) -> Result<Vec<Renderer>, Failure> {
    let open = |backend, adapter: Option<&str>| Renderer::open(backend, adapter).map_err(Failure::other);
    let mut renderers = Vec::new();
    if backend == Some(Backend::Auto) {
        renderers.push(open(Backend::Auto, adapter)?);
    } else if backend != Some(Backend::Cpu) {
        if let Some(adapter) = adapter {
            renderers.push(open(Backend::Gpu, Some(adapter))?);
        } else {
            for found in adapters().iter().filter(|adapter| adapter.unusable.is_none()) {
                renderers.push(open(Backend::Gpu, Some(&found.name))?);
            }
        }
    }
    if backend.is_none() || backend == Some(Backend::Cpu) {
        renderers.push(open(Backend::Cpu, None)?);
    }
    if renderers.is_empty() {
        return Err(Failure::Other("no GPU adapter is usable; `pathmarch devices` lists the reasons".to_owned()));
    }
    Ok(renderers)
}

/// Settings that other path tracers share: no simplified caustics, and no limit of radiance.
pub fn unbiased(settings: Settings) -> Settings {
    Settings { caustics: Caustics::Sampled, clamp: None, ..settings }
}

/// Starts a picture; settings out of range are a usage error.
pub fn start(renderer: &Renderer, scene: &Scene, settings: &Settings) -> Result<Job, Failure> {
    renderer.start(scene, settings).map_err(|error| match error {
        RenderError::Settings(message) => Failure::Usage(message),
        other => Failure::other(other),
    })
}

/// Renders until `samples` are done, including the GPU's work.
pub fn until(job: &mut Job, samples: u32, interrupt: &Interrupt) -> Result<(), Failure> {
    while job.samples_done() < f64::from(samples) {
        interrupt.check()?;
        job.advance(samples).map_err(Failure::other)?;
    }
    job.wait().map_err(Failure::other)
}

/// Measures milliseconds per sample of every pixel; the first sample is warm-up. The pictures take turns in each round,
/// so that drifting clock speeds affect all alike. Stops after `seconds`, but not before the minimum number of rounds.
pub fn time_interleaved(
    jobs: &mut [Job],
    rounds: RangeInclusive<u32>,
    samples: u32,
    seconds: f64,
    interrupt: &Interrupt,
) -> Result<Vec<Times>, Failure> {
    let mut times = vec![Times(Vec::new()); jobs.len()];
    let began = Instant::now();
    for job in &mut *jobs {
        until(job, 1, interrupt)?;
    }
    for round in 0..*rounds.end() {
        for (job, times) in jobs.iter_mut().zip(&mut times) {
            let started = Instant::now();
            until(job, 1 + (round + 1) * samples, interrupt)?;
            times.0.push(started.elapsed().as_secs_f64() * 1e3 / f64::from(samples));
        }
        if round + 1 >= *rounds.start() && began.elapsed().as_secs_f64() > seconds {
            break;
        }
    }
    Ok(times)
}

/// Milliseconds per sample, one value per round.
#[derive(Clone, Debug)]
pub struct Times(Vec<f64>);

impl Times {
    /// Number of rounds.
    pub fn rounds(&self) -> u32 {
        self.0.len() as u32
    }
    /// Median, minimum and maximum.
    pub fn spread(&self) -> [f64; 3] {
        let mut times = self.0.clone();
        times.sort_by(f64::total_cmp);
        [times[times.len() / 2], times[0], times[times.len() - 1]]
    }
}

/// Median of at least one value; the mean of the two in the middle of an even number.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2])
}

/// Budget of a picture.
#[derive(Clone, Copy)]
pub enum Budget {
    /// Number of samples.
    Samples(u32),
    /// Time in seconds; the sample in progress is finished.
    Seconds(f64),
}

/// A picture with its samples and render time.
pub struct TimedPicture {
    /// Mean of the samples.
    pub picture: Picture,
    /// Samples per pixel.
    pub samples: u32,
    /// Render time without compilation, seconds.
    pub seconds: f64,
}

/// Renders a picture within a budget.
pub fn render_for(
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    budget: Budget,
    interrupt: &Interrupt,
) -> Result<TimedPicture, Failure> {
    let most = match budget {
        Budget::Samples(samples) => samples,
        Budget::Seconds(_) => MAX_SAMPLES,
    };
    let mut job = start(renderer, scene, &Settings { samples: most, ..settings.clone() })?;
    let started = Instant::now();
    let late = |started: Instant| match budget {
        Budget::Samples(_) => false,
        Budget::Seconds(seconds) => started.elapsed().as_secs_f64() >= seconds,
    };
    while job.samples_done() < f64::from(most) && !late(started) {
        interrupt.check()?;
        job.advance(most).map_err(Failure::other)?;
    }
    let film = job.film().map_err(Failure::other)?;
    Ok(TimedPicture { picture: film.mean(), samples: film.samples, seconds: started.elapsed().as_secs_f64() })
}

/// Reference to compare with.
pub struct Reference {
    /// The reference picture.
    pub picture: Picture,
    /// Samples per pixel, if known.
    pub samples: Option<u32>,
    /// relMSE of the reference itself, if known.
    pub noise: Option<f64>,
}

impl Reference {
    /// Averages two pictures with equally many samples and independent noise.
    pub fn from_halves(a: &Picture, b: &Picture, samples: u32) -> Result<Self, Failure> {
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let pixels = a.pixels.iter().zip(&b.pixels).map(mean).collect();
        let picture = Picture { width: a.width, height: a.height, pixels };
        let noise = relmse(a, &picture).map_err(Failure::other)?;
        Ok(Self { picture, samples: Some(2 * samples), noise: Some(noise) })
    }

    /// relMSE of a picture with another seed, minus the noise of the reference; zero or negative if smaller than that
    /// noise.
    pub fn error_of(&self, picture: &Picture) -> Result<f64, Failure> {
        Ok(relmse(picture, &self.picture).map_err(Failure::other)? - self.noise.unwrap_or(0.0))
    }

    /// Relative difference of the means over all pixels and channels: shows bias earlier than relMSE.
    pub fn mean_difference(&self, picture: &Picture) -> f64 {
        let sum = |picture: &Picture| picture.mean_colour().iter().sum::<f64>();
        sum(picture) / sum(&self.picture).max(1e-12) - 1.0
    }
}

/// Makes a directory and those above it, unless they exist.
pub fn make_directory(directory: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(directory).map_err(|error| Failure::Other(format!("{}: {error}", directory.display())))
}

/// Seeds of the two halves of a reference; measured pictures have seed 0.
const SEEDS: [u32; 2] = [0x5eed_0001, 0x5eed_0002];

/// References stored as files.
pub struct ReferenceStore {
    folder: PathBuf,
    /// Render time for a missing reference, seconds.
    seconds: f64,
}

impl ReferenceStore {
    /// Uses a directory, which is made if there is none.
    pub fn new(folder: PathBuf, seconds: f64) -> Result<Self, Failure> {
        make_directory(&folder)?;
        Ok(Self { folder, seconds })
    }

    /// Returns the reference of a scene: the user's file `NAME.exr`, or the stored halves, or newly rendered ones,
    /// which are then stored.
    pub fn get(
        &self,
        name: &str,
        scene: &Scene,
        settings: &Settings,
        renderer: &Renderer,
        interrupt: &Interrupt,
    ) -> Result<Reference, Failure> {
        let own = self.folder.join(format!("{name}.exr"));
        if own.is_file() {
            let loaded = image::load(&own).map_err(Failure::other)?;
            let size = [loaded.picture.width, loaded.picture.height];
            if size != settings.size {
                let [width, height] = size;
                let path = own.display();
                return Err(Failure::Other(format!("{path} has {width}x{height} pixels; set --error-size to that")));
            }
            let samples = loaded.provenance.map(|provenance| provenance.samples);
            return Ok(Reference { picture: loaded.picture, samples, noise: None });
        }
        let [width, height] = settings.size;
        let hash = scene_hash(scene);
        let stem = format!("{name}-{width}x{height}-b{}-{}", settings.bounces, &hash[..12]);
        let files = ["a", "b"].map(|half| self.folder.join(format!("{stem}-{half}.exr")));
        if let Some(kept) = kept(&files, settings.size)? {
            return Ok(kept);
        }
        let mut budget = Budget::Seconds(self.seconds / 2.0);
        let mut halves = Vec::new();
        for seed in SEEDS {
            let half = render_for(renderer, scene, &Settings { seed, ..settings.clone() }, budget, interrupt)?;
            budget = Budget::Samples(half.samples);
            halves.push(half);
        }
        for ((file, half), seed) in files.iter().zip(&halves).zip(SEEDS) {
            let provenance = Provenance {
                scene_hash: hash.clone(),
                samples: half.samples,
                first_sample: 0,
                seed,
                bounces: settings.bounces,
                mode: settings.mode.name().to_owned(),
                adapter: renderer.backend().adapter,
                backend: renderer.backend().name,
                version: env!("CARGO_PKG_VERSION").to_owned(),
                denoiser: None,
            };
            let display = Display { tonemap: Tonemap::Srgb, exposure_stops: 0.0 };
            image::save(file, &half.picture, &display, &provenance).map_err(Failure::other)?;
        }
        Reference::from_halves(&halves[0].picture, &halves[1].picture, halves[0].samples)
    }
}

/// Loads a reference from two files, if they exist and match.
fn kept(files: &[PathBuf; 2], size: [u32; 2]) -> Result<Option<Reference>, Failure> {
    if !files.iter().all(|file| file.is_file()) {
        return Ok(None);
    }
    let load = |file: &Path| image::load(file).map_err(Failure::other);
    let [a, b] = [load(&files[0])?, load(&files[1])?];
    let samples = |half: &image::Loaded| half.provenance.as_ref().map_or(0, |provenance| provenance.samples);
    let fits = |half: &image::Loaded| [half.picture.width, half.picture.height] == size;
    if samples(&a) == 0 || samples(&a) != samples(&b) || !fits(&a) || !fits(&b) {
        return Ok(None);
    }
    Reference::from_halves(&a.picture, &b.picture, samples(&a)).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures with independent noise around a known truth: the estimates hold within the accuracy of 10,000 pixels.
    #[test]
    fn the_noise_of_a_reference_is_estimated_and_subtracted() {
        let mut state = 1u64;
        let mut noisy = |deviation: f32| {
            Picture::from_fn(100, 100, |_, _| {
                [0; 3].map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    let uniform = (state >> 40) as f32 / 16_777_216.0;
                    1.0 + deviation * (uniform - 0.5) * 12f32.sqrt()
                })
            })
        };
        let reference = Reference::from_halves(&noisy(0.1), &noisy(0.1), 8).expect("of one size");
        let truth = Picture::from_fn(100, 100, |_, _| [1.0; 3]);
        let of_reference = relmse(&reference.picture, &truth).expect("of one size");
        let message = reference.noise.expect("known");
        assert!((message / of_reference - 1.0).abs() < 0.05, "{message} for {of_reference}");
        let measured = noisy(0.05);
        let error = relmse(&measured, &truth).expect("of one size");
        let message = reference.error_of(&measured).expect("of one size");
        assert!((message / error - 1.0).abs() < 0.1, "{message} for {error}");
        assert_eq!(reference.samples, Some(16));
        assert!(reference.mean_difference(&measured).abs() < 1e-3);
    }

    #[test]
    fn spreads_are_median_least_and_most() {
        assert_eq!(Times(vec![3.0, 1.0, 2.0]).spread(), [2.0, 1.0, 3.0]);
        assert_eq!(Times(vec![7.0]).spread(), [7.0; 3]);
    }
}
