//! `pathmarch-measure bench`: time per sample and error after a given time, for each scene and backend.
//!
//! **Method.** Scenes are measured one after the other, so that only one is in memory. The backends take turns in each
//! round, so that drifting clock speeds affect all alike; the median is reported. Compilation is timed separately. Rays
//! and field evaluations are counted on the CPU, which follows the same paths as a GPU, in pictures of a fourth of the
//! width and height. Memory is that of a separate process ([`memory`]). Errors are measured against references with
//! known noise ([`crate::measure`]), with the bounces of the scene.
//!
//! With `--peers`, other renderers render the same scenes in the same run ([`beside`]).
//!
//! **Cost.** `1 + rounds * samples` samples per scene and backend, and one more for its memory; with `--error S` also
//! `S` seconds per backend, and four times as many once for the reference.

mod beside;
mod generated;
mod memory;
mod report;
mod scenes;

use crate::measure::{self, Budget, Interrupt, ReferenceStore};
use pathmarch_cli::{
    AppDirs, BackendArgument, DONE, FAILED, Failure, INTERRUPTED, catch_interrupts, check_directory, note,
    value_parsers,
};
use pathmarch_render::pathmarch_scene::{Scene, settings};
use pathmarch_render::{Renderer, Settings, ray_stats};
use report::{Entry, Quality, Results, Spread};
use scenes::NamedScene;
pub use scenes::built_in;
use std::path::PathBuf;
use std::time::Instant;

/// Minimum number of rounds, however long they take.
const MIN_ROUNDS: u32 = 3;
/// Render time of a reference, as a multiple of that of the measured picture.
const REFERENCE_TIME_FACTOR: f64 = 4.0;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scenes to measure [default: default]
    ///
    /// Scene files, directories, examples of the gallery by name, generated scenes (union-100, union-1000, union-10000,
    /// moving-10000, lights-64, lights-1000, lights-10000, foggy-lights-64, foggy-lights-1000), or sets of scenes:
    /// default: the thesis's, fractals, a repeated field, glass, a Cornell box, 64 lights, unions of 1,000 and 10,000
    /// shapes.
    /// thesis: all scenes after the figures of the thesis.
    /// quality: the scenes on which other renderers were timed, for --error.
    #[arg(verbatim_doc_comment)]
    scenes: Vec<PathBuf>,
    /// Size in pixels [default: 1280x720, with --peers 640x360]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// Scattering events after the first hit, for timing; --peers takes those of the scene
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = value_parsers::whole(settings::BOUNCES), allow_hyphen_values = true)]
    bounces: u32,
    /// Number of rounds [default: 7, with --peers 3]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, 1000)), allow_hyphen_values = true)]
    rounds: Option<u32>,
    /// Samples per round [default: 1; with --peers those of the peers, 64]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, 1000)), allow_hyphen_values = true)]
    samples: Option<u32>,
    /// Time limit of a scene, but at least three rounds; the CPU is skipped if one of its samples takes longer
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    limit: f64,
    /// Also measure the error: relMSE after this time, and time x relMSE, with the bounces of the scene
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    error: Option<f64>,
    /// Size of the pictures whose error is measured
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = value_parsers::size, allow_hyphen_values = true)]
    error_size: [u32; 2],
    /// Directory of references: your own NAME.exr for a scene, otherwise rendered ones [default: the user's cache]
    ///
    /// A reference takes four times the seconds of --error on the fastest backend, with other seeds than the measured
    /// picture. Its own noise is estimated from two halves, subtracted, and reported. The noise of your own file is
    /// unknown
    /// and taken as 0. Delete the files to render them again, for example after a change of light transport.
    #[arg(long, value_name = "DIR", requires = "error", verbatim_doc_comment)]
    references: Option<PathBuf>,
    /// Backends to measure [default: every adapter, and the CPU]
    #[arg(long, value_enum)]
    backend: Option<BackendArgument>,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Also write the results to this file, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Print ratios to the results of an earlier run, a file of --json
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Measure nothing; print the results in this file of --json
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scenes", "json", "error", "references"])]
    from: Option<PathBuf>,
    /// Render the scenes with Mitsuba and Cycles, too, where they are installed, and compare time x relMSE
    #[arg(long, conflicts_with_all = ["error", "references", "json", "compare", "from"])]
    peers: bool,
    /// Python with the modules mitsuba, bpy and moderngl, for --peers and --thesis-shader [default: python3]
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// Time frames of the thesis's program beside ours; the file is shaders/pathTracer.fs of Arukiap/Path-marcher
    #[arg(long, value_name = "FILE", conflicts_with_all = ["error", "references", "json", "compare", "from"])]
    thesis_shader: Option<PathBuf>,
    /// Print the memory that this process used for one sample
    #[arg(long, hide = true)]
    peak_memory: bool,
}

impl Arguments {
    fn size(&self) -> [u32; 2] {
        self.size.unwrap_or(if self.peers { [640, 360] } else { [1280, 720] })
    }
    fn rounds(&self) -> u32 {
        self.rounds.unwrap_or(if self.peers { 3 } else { 7 })
    }
    fn samples(&self) -> u32 {
        self.samples.unwrap_or(if self.peers { 64 } else { 1 })
    }
    /// Settings of the timed pictures.
    fn settings(&self, scene: &Scene, samples: u32) -> Settings {
        Settings { size: self.size(), bounces: self.bounces, samples, ..Settings::of(scene) }
    }
    /// Size of the pictures whose rays are counted.
    fn ray_count_size(&self) -> [u32; 2] {
        self.size().map(|side| side.div_ceil(4))
    }
    /// Directory of references, and render time of missing ones.
    fn reference_store(&self) -> Result<Option<ReferenceStore>, Failure> {
        let Some(seconds) = self.error else { return Ok(None) };
        let folder = match &self.references {
            Some(folder) => folder.clone(),
            None => {
                let no_home = "there is no home directory for references; use --references DIR";
                AppDirs::of_user().ok_or_else(|| Failure::Usage(no_home.to_owned()))?.references
            }
        };
        ReferenceStore::new(folder, REFERENCE_TIME_FACTOR * seconds).map(Some)
    }
    /// Header of the results.
    fn results(&self) -> Results {
        Results {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            size: self.size(),
            bounces: self.bounces,
            rounds: self.rounds(),
            samples: self.samples(),
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
    let interrupt = Interrupt(catch_interrupts()?);
    if arguments.peak_memory {
        return memory::report(arguments, &interrupt);
    }
    if let Some(path) = &arguments.json {
        check_directory(path)?;
    }
    let references = arguments.reference_store()?;
    let all = scenes::chosen(&arguments.scenes)?;
    let renderers = measure::renderers(arguments.backend.map(Into::into), arguments.adapter.as_deref())?;
    if arguments.peers || arguments.thesis_shader.is_some() {
        return beside::run(arguments, &all, &renderers, &interrupt);
    }
    let mut results = arguments.results();
    results.print_head();
    let mut interrupted = false;
    for (index, chosen) in all.iter().enumerate() {
        let bench =
            SceneBench { arguments, chosen, interrupt: &interrupt, place: format!("{}/{}", index + 1, all.len()) };
        match bench.measure(&renderers, references.as_ref()) {
            Ok(entries) => {
                entries.iter().for_each(Entry::print);
                results.entries.extend(entries);
            }
            Err(Failure::Interrupted) => {
                interrupted = true;
                break;
            }
            Err(failure) => {
                note!("{}: skipped", chosen.name);
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
            note!("interrupted: results are those of the scenes before");
            INTERRUPTED
        }
        (false, true) => FAILED,
        (false, false) => DONE,
    })
}

/// A scene with its measurement settings.
struct SceneBench<'a> {
    arguments: &'a Arguments,
    chosen: &'a NamedScene,
    interrupt: &'a Interrupt,
    /// Position in the list of scenes, such as "2/5".
    place: String,
}

impl SceneBench<'_> {
    fn log(&self, what: &str) {
        note!("[{}] {}: {what}", self.place, self.chosen.name);
    }

    /// Ratio of the pixels timed to the pixels counted.
    fn enlarged(&self) -> f64 {
        let pixels = |size: [u32; 2]| size.map(f64::from).iter().product::<f64>();
        pixels(self.arguments.size()) / pixels(self.arguments.ray_count_size())
    }

    /// Measures the scene on every backend that can render it.
    fn measure(&self, renderers: &[Renderer], references: Option<&ReferenceStore>) -> Result<Vec<Entry>, Failure> {
        let Self { arguments, chosen: NamedScene { scene, .. }, interrupt, .. } = *self;
        interrupt.check()?;
        self.log("counting rays");
        let settings = arguments.settings(scene, 1 + arguments.rounds() * arguments.samples());
        let counted = Settings { size: arguments.ray_count_size(), ..settings.clone() };
        // Build the index now, as it is not part of a sample; it would be built at first use.
        scene.field.build_shape_grids();
        let began = Instant::now();
        let ray_stats = ray_stats(scene, &counted).map_err(Failure::other)?;
        // Estimated time of a CPU sample at full size, seconds.
        let cpu_seconds = began.elapsed().as_secs_f64() * self.enlarged();
        let pixels = f64::from(arguments.ray_count_size().iter().product::<u32>());

        let (mut able, mut jobs) = (Vec::new(), Vec::new());
        for renderer in renderers {
            interrupt.check()?;
            if renderer.backend().name == "CPU" && cpu_seconds > arguments.limit {
                let message = format!("one sample takes about {cpu_seconds:.0} s, above --limit");
                self.log(&format!("not on {}: {message}; choose a smaller --size", measure::backend_label(renderer)));
                continue;
            }
            match measure::start(renderer, scene, &settings) {
                Ok(job) => {
                    able.push(renderer);
                    jobs.push(job);
                }
                Err(failure) => {
                    self.log(&format!("not on {}", measure::backend_label(renderer)));
                    failure.print();
                }
            }
        }
        let compile_ms: Vec<_> = jobs.iter().map(|job| job.compile_time().as_secs_f64() * 1e3).collect();
        for job in &mut jobs {
            job.measure_gpu_time().map_err(Failure::other)?;
        }
        let (rounds, samples) = (arguments.rounds(), arguments.samples());
        self.log(&format!("{rounds} rounds of {samples} samples"));
        let times = measure::time_interleaved(&mut jobs, MIN_ROUNDS..=rounds, samples, arguments.limit, interrupt)?;
        let mut entries = Vec::new();
        for (((renderer, job), times), compile_ms) in able.iter().zip(&mut jobs).zip(&times).zip(compile_ms) {
            let [median, min, max] = times.spread();
            let gpu = job.gpu_time().map_err(Failure::other)?;
            entries.push(Entry {
                scene: self.chosen.name.clone(),
                backend: measure::backend_label(renderer),
                rounds: Some(times.rounds()),
                ms_per_sample: Spread { median, min, max },
                gpu_ms_per_sample: gpu.map(|time| time.as_secs_f64() * 1e3 / job.samples_done()),
                compile_ms,
                rays_per_pixel: ray_stats.rays as f64 / pixels,
                evaluations_per_ray: ray_stats.evaluations_per_ray(),
                evaluations_per_pixel: Some(ray_stats.evaluations as f64 / pixels),
                steps_per_marched_ray: Some(ray_stats.evaluations as f64 / ray_stats.sphere_traced_rays.max(1) as f64),
                peak_mib: None,
                quality: None,
            });
        }
        // Free these pictures before measuring the memory of others.
        drop(jobs);
        for (entry, renderer) in entries.iter_mut().zip(&able) {
            interrupt.check()?;
            self.log("memory");
            entry.peak_mib = memory::of_scene(arguments, &self.chosen.argument, renderer);
        }
        if let Some(references) = references {
            self.measure_errors(&able, &mut entries, references)?;
        }
        Ok(entries)
    }

    /// Measures the error of every backend, against a reference that the fastest one renders.
    fn measure_errors(
        &self,
        renderers: &[&Renderer],
        entries: &mut [Entry],
        references: &ReferenceStore,
    ) -> Result<(), Failure> {
        let Self { arguments, chosen: NamedScene { name, scene, .. }, interrupt, .. } = *self;
        let settings = Settings { size: arguments.error_size, ..Settings::of(scene) };
        let median = |index: &usize| entries[*index].ms_per_sample.median;
        let fastest = (0..entries.len()).min_by(|a, b| median(a).total_cmp(&median(b)));
        let (Some(fastest), Some(seconds)) = (fastest, arguments.error) else { return Ok(()) };
        self.log("reference");
        let reference = references.get(name, scene, &settings, renderers[fastest], interrupt)?;
        for (renderer, entry) in renderers.iter().zip(entries) {
            self.log(&format!("error after {seconds} s"));
            let taken = measure::render_for(renderer, scene, &settings, Budget::Seconds(seconds), interrupt)?;
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
