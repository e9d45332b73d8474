//! What `bench` and `study` measure alike: the time of a sample, and how far a picture is from the converged one.
//!
//! **Idea.** The error of a picture is its relMSE against a reference, and the reference has noise of its own. It is
//! rendered as two halves of equally many samples with seeds of their own; the reference is their mean, and the relMSE of
//! one half against that mean estimates the relMSE of the mean itself, because the mean's variance is a fourth of the
//! variance of the difference of the halves. Errors of independent pictures add up, so that what is left after
//! subtracting it is the error of the measured picture, which has yet another seed.
//!
//! **Source.** relMSE: [`pathmarch_render::metrics`]. Two independent halves as an estimate of variance: Rousselle, Knaus,
//! Zwicker, "Robust Denoising using Feature and Color Information", Pacific Graphics 2013, section 3.
//!
//! **Cost.** A reference of four times the samples of what is measured has a fourth of its error or less.

use pathmarch_cli::Failure;
use pathmarch_render::image::{self, Picture, Provenance};
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::{Scene, Tonemap};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Job, RenderError, Renderer, Settings, adapters, scene_hash};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Samples of a picture whose end is a time.
pub const ENDLESS: u32 = 1_000_000;

/// Ctrl-C, asked for between slices of work.
#[derive(Clone)]
pub struct Watch(pub Arc<AtomicBool>);

impl Watch {
    /// Whether work has to end.
    pub fn check(&self) -> Result<(), Failure> {
        if self.0.load(Ordering::SeqCst) { Err(Failure::Interrupted) } else { Ok(()) }
    }
}

/// A backend with its adapter, as it is named in results.
pub fn described(renderer: &Renderer) -> String {
    format!("{} ({})", renderer.backend().name, renderer.backend().adapter)
}

/// Backends to measure: without a choice every usable adapter and the CPU; `adapter` is part of an adapter's name.
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
        return Err(Failure::Other("no GPU adapter is usable; `pathmarch devices` says why".to_owned()));
    }
    Ok(renderers)
}

/// Begins a picture; settings out of range are a mistake of the user.
pub fn start(renderer: &Renderer, scene: &Scene, settings: &Settings) -> Result<Job, Failure> {
    renderer.start(scene, settings).map_err(|error| match error {
        RenderError::Settings(message) => Failure::Usage(message),
        other => Failure::other(other),
    })
}

/// Renders until this many samples are done, the GPU's work included.
pub fn until(job: &mut Job, samples: u32, watch: &Watch) -> Result<(), Failure> {
    while job.samples_done() < f64::from(samples) {
        watch.check()?;
        job.advance(samples).map_err(Failure::other)?;
    }
    job.wait().map_err(Failure::other)
}

/// Milliseconds for one sample of every pixel, round after round; the first sample warms up and does not count. Pictures
/// take turns, so that a machine whose speed drifts treats all alike. Ends early once `seconds` are over and there are as
/// many rounds as the range begins with.
pub fn time_in_turn(
    jobs: &mut [Job],
    rounds: RangeInclusive<u32>,
    samples: u32,
    seconds: f64,
    watch: &Watch,
) -> Result<Vec<Times>, Failure> {
    let mut times = vec![Times(Vec::new()); jobs.len()];
    let began = Instant::now();
    for job in &mut *jobs {
        until(job, 1, watch)?;
    }
    for round in 0..*rounds.end() {
        for (job, times) in jobs.iter_mut().zip(&mut times) {
            let started = Instant::now();
            until(job, 1 + (round + 1) * samples, watch)?;
            times.0.push(started.elapsed().as_secs_f64() * 1e3 / f64::from(samples));
        }
        if round + 1 >= *rounds.start() && began.elapsed().as_secs_f64() > seconds {
            break;
        }
    }
    Ok(times)
}

/// Milliseconds, of one or more rounds.
#[derive(Clone, Debug)]
pub struct Times(Vec<f64>);

impl Times {
    /// How many.
    pub fn rounds(&self) -> u32 {
        self.0.len() as u32
    }
    /// Median, least and most.
    pub fn spread(&self) -> [f64; 3] {
        let mut times = self.0.clone();
        times.sort_by(f64::total_cmp);
        [times[times.len() / 2], times[0], times[times.len() - 1]]
    }
}

/// How long to render.
#[derive(Clone, Copy)]
pub enum Effort {
    /// So many samples.
    Samples(u32),
    /// The sample with which these seconds are over, and all before it.
    Seconds(f64),
}

/// A picture, its samples, and the seconds that they took without compilation.
pub struct Taken {
    /// The mean of the samples.
    pub picture: Picture,
    /// Samples of every pixel.
    pub samples: u32,
    /// Seconds.
    pub seconds: f64,
}

/// Renders for so long.
pub fn take(
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    effort: Effort,
    watch: &Watch,
) -> Result<Taken, Failure> {
    let most = match effort {
        Effort::Samples(samples) => samples,
        Effort::Seconds(_) => ENDLESS,
    };
    let mut job = start(renderer, scene, &Settings { samples: most, ..settings.clone() })?;
    let started = Instant::now();
    let late = |started: Instant| match effort {
        Effort::Samples(_) => false,
        Effort::Seconds(seconds) => started.elapsed().as_secs_f64() >= seconds,
    };
    while job.samples_done() < f64::from(most) && !late(started) {
        watch.check()?;
        job.advance(most).map_err(Failure::other)?;
    }
    let film = job.film().map_err(Failure::other)?;
    Ok(Taken { picture: film.mean(), samples: film.samples, seconds: started.elapsed().as_secs_f64() })
}

/// What pictures are measured against.
pub struct Reference {
    /// The picture.
    pub picture: Picture,
    /// Its samples, where they are known.
    pub samples: Option<u32>,
    /// Its own relMSE, where it is known.
    pub noise: Option<f64>,
}

impl Reference {
    /// The mean of two pictures of equally many samples with independent noise.
    pub fn of_halves(a: &Picture, b: &Picture, samples: u32) -> Result<Self, Failure> {
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let pixels = a.pixels.iter().zip(&b.pixels).map(mean).collect();
        let picture = Picture { width: a.width, height: a.height, pixels };
        let noise = relmse(a, &picture).map_err(Failure::other)?;
        Ok(Self { picture, samples: Some(2 * samples), noise: Some(noise) })
    }

    /// The relMSE of a picture of another seed, without the noise of the reference; zero or less where that hides it.
    pub fn error_of(&self, picture: &Picture) -> Result<f64, Failure> {
        Ok(relmse(picture, &self.picture).map_err(Failure::other)? - self.noise.unwrap_or(0.0))
    }

    /// The relative difference of the means over all pixels and channels: bias shows in it before it shows in relMSE.
    pub fn mean_difference(&self, picture: &Picture) -> f64 {
        let sum = |picture: &Picture| picture.mean_colour().iter().sum::<f64>();
        sum(picture) / sum(&self.picture).max(1e-12) - 1.0
    }
}

/// The seeds of a reference's halves; what is measured has seed 0.
const SEEDS: [u32; 2] = [0x5eed_0001, 0x5eed_0002];

/// References that are kept as files.
pub struct References {
    folder: PathBuf,
    /// Seconds for one that is not there.
    seconds: f64,
}

impl References {
    /// In a folder that is there.
    pub fn new(folder: PathBuf, seconds: f64) -> Self {
        Self { folder, seconds }
    }

    /// That of a picture: the user's own file `NAME.exr`, or the halves that were kept, or new ones, which are kept.
    pub fn get(
        &self,
        name: &str,
        scene: &Scene,
        settings: &Settings,
        renderer: &Renderer,
        watch: &Watch,
    ) -> Result<Reference, Failure> {
        let own = self.folder.join(format!("{name}.exr"));
        if own.is_file() {
            let loaded = image::load(&own).map_err(Failure::other)?;
            let size = [loaded.picture.width, loaded.picture.height];
            if size != settings.size {
                let [width, height] = size;
                let path = own.display();
                return Err(Failure::Other(format!("{path} is of {width}x{height} pixels; choose --error-size so")));
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
        let mut effort = Effort::Seconds(self.seconds / 2.0);
        let mut halves = Vec::new();
        for seed in SEEDS {
            let half = take(renderer, scene, &Settings { seed, ..settings.clone() }, effort, watch)?;
            effort = Effort::Samples(half.samples);
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
            };
            let display = Display { tonemap: Tonemap::Srgb, exposure_stops: 0.0 };
            image::save(file, &half.picture, &display, &provenance).map_err(Failure::other)?;
        }
        Reference::of_halves(&halves[0].picture, &halves[1].picture, halves[0].samples)
    }
}

/// The reference of two files, if they are there and belong together.
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
    Reference::of_halves(&a.picture, &b.picture, samples(&a)).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures of independent noise around one truth: the estimates hold to the accuracy of 10,000 pixels.
    #[test]
    fn a_references_noise_is_known_and_taken_off() {
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
        let reference = Reference::of_halves(&noisy(0.1), &noisy(0.1), 8).expect("of one size");
        let truth = Picture::from_fn(100, 100, |_, _| [1.0; 3]);
        let of_reference = relmse(&reference.picture, &truth).expect("of one size");
        let told = reference.noise.expect("known");
        assert!((told / of_reference - 1.0).abs() < 0.05, "{told} for {of_reference}");
        let measured = noisy(0.05);
        let error = relmse(&measured, &truth).expect("of one size");
        let told = reference.error_of(&measured).expect("of one size");
        assert!((told / error - 1.0).abs() < 0.1, "{told} for {error}");
        assert_eq!(reference.samples, Some(16));
        assert!(reference.mean_difference(&measured).abs() < 1e-3);
    }

    #[test]
    fn spreads_are_median_least_and_most() {
        assert_eq!(Times(vec![3.0, 1.0, 2.0]).spread(), [2.0, 1.0, 3.0]);
        assert_eq!(Times(vec![7.0]).spread(), [7.0; 3]);
    }
}
