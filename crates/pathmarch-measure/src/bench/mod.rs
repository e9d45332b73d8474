//! `pathmarch-measure bench`: what one sample of every pixel costs, and how far a picture is after a time, for each scene and backend.
//!
//! **How.** One scene at a time, so that others do not stand in memory; its backends take turns, round after round, and the
//! median is reported, so that a machine whose speed drifts treats both alike. Compilation is timed apart. Rays and
//! evaluations of the field are counted on the CPU, which follows the same paths as a GPU, in pictures of a fourth of the
//! size each way. Memory is that of a process of its own ([`memory`]). Errors are measured against references that know
//! their own noise ([`crate::measure`]); their pictures have the bounces that the scene asks for.
//!
//! **Cost.** A scene takes `1 + rounds * samples` samples on each backend, and one more for its memory; with `--error S`
//! `S` seconds on each backend, and four times as many once for its reference.

mod generated;
mod memory;
mod report;
mod scenes;

use crate::measure::{self, Effort, References, Watch};
use pathmarch_cli::{
    AppDirs, BackendArgument, DONE, FAILED, Failure, INTERRUPTED, check_directory, numbers, watch_interrupts,
};
use pathmarch_render::pathmarch_scene::{Scene, settings};
use pathmarch_render::{Renderer, Settings, census};
use report::{Entry, Quality, Results, Spread};
use scenes::Chosen;
pub use scenes::built_in;
use std::path::PathBuf;
use std::time::Instant;

/// Rounds that a median needs, however long they take.
const FEWEST_ROUNDS: u32 = 3;
/// Seconds for a reference, in those of what is measured against it.
const REFERENCE_EFFORT: f64 = 4.0;

#[derive(clap::Args)]
pub struct Arguments {
    /// What to measure [default: default]
    ///
    /// Scene files, folders of them, examples by their name in the gallery, scenes that are made on demand (union-100,
    /// union-1000, union-10000, lights-64), or sets of scenes:
    /// default: the thesis's, fractals, a repeated field, glass, a Cornell box, 64 lights, unions of 1,000 and 10,000 shapes.
    /// thesis: all after the figures of the thesis.
    /// quality: those on which other renderers were timed, for --error.
    #[arg(verbatim_doc_comment)]
    scenes: Vec<PathBuf>,
    /// Size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = numbers::size, allow_hyphen_values = true)]
    size: [u32; 2],
    /// Scattering events after the first hit, in what is timed
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = numbers::whole(settings::BOUNCES), allow_hyphen_values = true)]
    bounces: u32,
    /// Rounds to measure
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = numbers::whole((1, 1000)), allow_hyphen_values = true)]
    rounds: u32,
    /// Samples in a round
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = numbers::whole((1, 1000)), allow_hyphen_values = true)]
    samples: u32,
    /// End the rounds of a scene after so many seconds, with three at least; leave out the CPU where a sample takes longer
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = numbers::seconds, allow_hyphen_values = true)]
    limit: f64,
    /// Measure the error, too: relMSE after so many seconds, and seconds times relMSE, with the bounces of the scene
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    error: Option<f64>,
    /// Size of the pictures whose error is measured
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = numbers::size, allow_hyphen_values = true)]
    error_size: [u32; 2],
    /// Where references are kept: a file NAME.exr of your own for a scene, else they are made [default: the user's cache]
    ///
    /// A reference takes four times the seconds of --error on the faster backend, with other random numbers than what is
    /// measured. Its own noise is estimated from two halves, subtracted, and reported. That of a file of your own is not
    /// known and taken for 0. Delete the files to have them made again, as after a change of how light is computed.
    #[arg(long, value_name = "DIR", requires = "error", verbatim_doc_comment)]
    references: Option<PathBuf>,
    /// Which backends to measure [default: every adapter, and the CPU]
    #[arg(long, value_enum)]
    backend: Option<BackendArgument>,
    /// The GPU adapter whose name contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Write the figures to this file, too, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Print ratios to the figures of an earlier run, a file of --json
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Measure nothing: show the figures of this file of --json
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scenes", "json", "error", "references"])]
    from: Option<PathBuf>,
    /// Print the memory that this process took for one sample
    #[arg(long, hide = true)]
    peak_memory: bool,
}

impl Arguments {
    /// What is timed.
    fn settings(&self, scene: &Scene, samples: u32) -> Settings {
        Settings { size: self.size, bounces: self.bounces, samples, ..Settings::of(scene) }
    }
    /// The size of the pictures whose rays are counted.
    fn counted_size(&self) -> [u32; 2] {
        self.size.map(|side| side.div_ceil(4))
    }
    /// Where references are, and how long to work on those that are not.
    fn kept_references(&self) -> Result<Option<References>, Failure> {
        let Some(seconds) = self.error else { return Ok(None) };
        let folder = match &self.references {
            Some(folder) if folder.is_dir() => folder.clone(),
            Some(folder) => {
                return Err(Failure::Usage(format!("there is no directory {}; make it first", folder.display())));
            }
            None => {
                let dirs = AppDirs::of_user().ok_or_else(|| {
                    Failure::Usage("there is no home directory to keep references in; give --references DIR".to_owned())
                })?;
                let failed = |error| Failure::Other(format!("{}: {error}", dirs.references.display()));
                std::fs::create_dir_all(&dirs.references).map_err(failed)?;
                dirs.references
            }
        };
        Ok(Some(References::new(folder, REFERENCE_EFFORT * seconds)))
    }
    /// What is said of all figures.
    fn results(&self) -> Results {
        Results {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            size: self.size,
            bounces: self.bounces,
            rounds: self.rounds,
            samples: self.samples,
            error_size: self.error.map(|_| self.error_size),
            entries: Vec::new(),
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let before = arguments.compare.as_deref().map(Results::load).transpose()?;
    if let Some(path) = &arguments.from {
        let results = Results::load(path)?;
        results.print_head();
        results.entries.iter().for_each(Entry::print);
        if let Some(before) = before {
            results.print_ratios(&before);
        }
        return Ok(DONE);
    }
    let watch = Watch(watch_interrupts()?);
    if arguments.peak_memory {
        return memory::report(arguments, &watch);
    }
    if let Some(path) = &arguments.json {
        check_directory(path)?;
    }
    let references = arguments.kept_references()?;
    let all = scenes::chosen(&arguments.scenes)?;
    let mut renderers = measure::renderers(arguments.backend.map(Into::into), arguments.adapter.as_deref())?;
    let mut results = arguments.results();
    results.print_head();
    let mut interrupted = false;
    for (index, chosen) in all.iter().enumerate() {
        let stage = Stage { arguments, chosen, watch: &watch, place: format!("{}/{}", index + 1, all.len()) };
        match stage.measure(&mut renderers, references.as_ref()) {
            Ok(entries) => {
                entries.iter().for_each(Entry::print);
                results.entries.extend(entries);
            }
            Err(Failure::Interrupted) => {
                interrupted = true;
                break;
            }
            Err(failure) => {
                eprintln!("{}: skipped", chosen.name);
                failure.print();
            }
        }
    }
    if let Some(path) = &arguments.json {
        results.save(path)?;
    }
    if let Some(before) = before {
        results.print_ratios(&before);
    }
    Ok(match (interrupted, results.entries.is_empty()) {
        (true, _) => {
            eprintln!("interrupted: the figures are those of the scenes before");
            INTERRUPTED
        }
        (false, true) => FAILED,
        (false, false) => DONE,
    })
}

/// A scene and how it is measured.
struct Stage<'a> {
    arguments: &'a Arguments,
    chosen: &'a Chosen,
    watch: &'a Watch,
    /// Which of how many.
    place: String,
}

impl Stage<'_> {
    fn say(&self, what: &str) {
        eprintln!("[{}] {}: {what}", self.place, self.chosen.name);
    }

    /// Pixels of what is timed for each of what is counted.
    fn enlarged(&self) -> f64 {
        let pixels = |size: [u32; 2]| size.map(f64::from).iter().product::<f64>();
        pixels(self.arguments.size) / pixels(self.arguments.counted_size())
    }

    /// The figures of every backend that can render the scene.
    fn measure(&self, renderers: &mut [Renderer], references: Option<&References>) -> Result<Vec<Entry>, Failure> {
        let Self { arguments, chosen: Chosen { scene, .. }, watch, .. } = *self;
        watch.check()?;
        self.say("counting rays");
        let settings = arguments.settings(scene, 1 + arguments.rounds * arguments.samples);
        let counted = Settings { size: arguments.counted_size(), ..settings.clone() };
        // Else it is built at the first look at the field; it is no part of a sample.
        scene.field.index();
        let began = Instant::now();
        let census = census(scene, &counted).map_err(Failure::other)?;
        // The CPU renders it in about as long as a sample of so many pixels takes.
        let cpu_seconds = began.elapsed().as_secs_f64() * self.enlarged();
        let pixels = f64::from(arguments.counted_size().iter().product::<u32>());

        let (mut able, mut jobs) = (Vec::new(), Vec::new());
        for renderer in renderers {
            watch.check()?;
            if renderer.backend_name() == "CPU" && cpu_seconds > arguments.limit {
                let told = format!("a sample takes about {cpu_seconds:.0} s, above --limit");
                self.say(&format!("not on {}: {told}; choose a smaller --size", measure::described(renderer)));
                continue;
            }
            match measure::start(renderer, scene, &settings) {
                Ok(job) => {
                    able.push(renderer);
                    jobs.push(job);
                }
                Err(failure) => {
                    self.say(&format!("not on {}", measure::described(renderer)));
                    failure.print();
                }
            }
        }
        let compile_ms: Vec<_> = jobs.iter().map(|job| job.compile_time().as_secs_f64() * 1e3).collect();
        for job in &mut jobs {
            job.measure_gpu_time().map_err(Failure::other)?;
        }
        let (rounds, samples) = (arguments.rounds, arguments.samples);
        self.say(&format!("{rounds} rounds of {samples} samples"));
        let times = measure::time_in_turn(&mut jobs, FEWEST_ROUNDS..=rounds, samples, arguments.limit, watch)?;
        let mut entries = Vec::new();
        for (((renderer, job), times), compile_ms) in able.iter().zip(&mut jobs).zip(&times).zip(compile_ms) {
            let [median, min, max] = times.spread();
            let gpu = job.gpu_time().map_err(Failure::other)?;
            entries.push(Entry {
                scene: self.chosen.name.clone(),
                backend: measure::described(renderer),
                rounds: Some(times.rounds()),
                ms_per_sample: Spread { median, min, max },
                gpu_ms_per_sample: gpu.map(|time| time.as_secs_f64() * 1e3 / job.samples_done()),
                compile_ms,
                rays_per_pixel: census.rays as f64 / pixels,
                evaluations_per_ray: census.evaluations_per_ray(),
                evaluations_per_pixel: Some(census.evaluations as f64 / pixels),
                steps_per_marched_ray: Some(census.evaluations as f64 / census.marched_rays.max(1) as f64),
                peak_mib: None,
                quality: None,
            });
        }
        // Their pictures need not stand in memory while others are measured.
        drop(jobs);
        for (entry, renderer) in entries.iter_mut().zip(&able) {
            watch.check()?;
            self.say("memory");
            entry.peak_mib = memory::of_scene(arguments, &self.chosen.argument, renderer);
        }
        if let Some(references) = references {
            self.measure_errors(&mut able, &mut entries, references)?;
        }
        Ok(entries)
    }

    /// The errors of every backend, against the reference that the fastest renders.
    fn measure_errors(
        &self,
        renderers: &mut [&mut Renderer],
        entries: &mut [Entry],
        references: &References,
    ) -> Result<(), Failure> {
        let Self { arguments, chosen: Chosen { name, scene, .. }, watch, .. } = *self;
        let settings = Settings { size: arguments.error_size, ..Settings::of(scene) };
        let median = |index: &usize| entries[*index].ms_per_sample.median;
        let fastest = (0..entries.len()).min_by(|a, b| median(a).total_cmp(&median(b)));
        let (Some(fastest), Some(seconds)) = (fastest, arguments.error) else { return Ok(()) };
        self.say("reference");
        let reference = references.get(name, scene, &settings, renderers[fastest], watch)?;
        for (renderer, entry) in renderers.iter_mut().zip(entries) {
            self.say(&format!("error after {seconds} s"));
            let taken = measure::take(renderer, scene, &settings, Effort::Seconds(seconds), watch)?;
            let error = reference.error_of(&taken.picture)?;
            let relmse = Some(error).filter(|error| *error > 0.1 * reference.noise.unwrap_or(0.0));
            entry.quality = Some(Quality {
                seconds: taken.seconds,
                samples: taken.samples,
                bounces: settings.bounces,
                relmse,
                seconds_relmse: relmse.map(|relmse| relmse * taken.seconds),
                reference_relmse: reference.noise,
                reference_samples: reference.samples,
                mean_difference: reference.mean_difference(&taken.picture),
            });
        }
        Ok(())
    }
}
