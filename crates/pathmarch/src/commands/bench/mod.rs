//! `pathmarch bench`: what one sample of every pixel costs, for each scene and backend.
//!
//! Scenes and backends are measured in turn, round after round, and the median is reported, so that a machine whose
//! speed drifts treats all alike. Compilation is timed apart. Rays and evaluations of the field are counted on the CPU, which
//! follows the same paths as a GPU, in pictures of a fourth of the size each way.

mod generated;

use super::{BackendArgument, parse_size};
use crate::exit::{DONE, Failure};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Census, Job, MAX_BOUNCES, Renderer, Settings, adapters, census};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene files, or scenes that are made on demand: union-100, union-1000, union-10000, lights-64
    /// [default: all of scenes/thesis]
    #[arg(verbatim_doc_comment)]
    scenes: Vec<PathBuf>,
    /// Size in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Scattering events after the first hit
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_BOUNCES)))]
    bounces: u32,
    /// Rounds to measure
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Samples in a round
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1000))]
    samples: u32,
    /// Which backends to measure [default: every adapter, and the CPU]
    #[arg(long, value_enum)]
    backend: Option<BackendArgument>,
    /// Write the figures to this file, too, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Arguments {
    /// The size of the pictures whose rays are counted.
    fn counted_size(&self) -> [u32; 2] {
        self.size.map(|side| side.div_ceil(4))
    }
}

struct Entry {
    scene: String,
    backend: String,
    compile_ms: f64,
    census: Census,
    job: Job,
    times_ms: Vec<f64>,
}

impl Entry {
    /// Median, least and most.
    fn spread(&self) -> [f64; 3] {
        let mut times = self.times_ms.clone();
        times.sort_by(f64::total_cmp);
        [times[times.len() / 2], times[0], times[times.len() - 1]]
    }
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let mut paths = arguments.scenes.clone();
    if paths.is_empty() {
        paths = thesis_scenes()?;
    }
    let mut renderers = vec![];
    if arguments.backend != Some(BackendArgument::Cpu) {
        for adapter in adapters().iter().filter(|adapter| adapter.unusable.is_none()) {
            renderers.push(Renderer::open(Backend::Gpu, Some(&adapter.name)).map_err(Failure::other)?);
        }
    }
    if arguments.backend != Some(BackendArgument::Gpu) {
        renderers.push(Renderer::open(Backend::Cpu, None).map_err(Failure::other)?);
    }
    if renderers.is_empty() {
        return Err(Failure::Usage("no GPU adapter is usable; `pathmarch devices` says why".to_owned()));
    }

    let mut entries = Vec::new();
    for path in &paths {
        let (name, scene) = scene(path)?;
        // One sample to warm up.
        let samples = 1 + arguments.rounds * arguments.samples;
        let settings = Settings { size: arguments.size, bounces: arguments.bounces, samples, ..Settings::of(&scene) };
        let small = Settings { size: arguments.counted_size(), ..settings.clone() };
        let census = census(&scene, &small).map_err(Failure::other)?;
        for renderer in &mut renderers {
            let backend = format!("{} ({})", renderer.backend_name(), renderer.adapter_name());
            let mut job = match renderer.start(&scene, &settings) {
                Ok(job) => job,
                Err(error) => {
                    eprintln!("{name}: not on {backend}: {error}");
                    continue;
                }
            };
            until(&mut job, 1)?;
            let compile_ms = job.compile_time().as_secs_f64() * 1e3;
            entries.push(Entry { scene: name.clone(), backend, compile_ms, census, job, times_ms: Vec::new() });
        }
    }
    for round in 0..arguments.rounds {
        for entry in &mut entries {
            let started = Instant::now();
            until(&mut entry.job, 1 + (round + 1) * arguments.samples)?;
            entry.times_ms.push(started.elapsed().as_secs_f64() * 1e3 / f64::from(arguments.samples));
        }
    }
    print(arguments, &entries);
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(&json(arguments, &entries)).expect("numbers and strings");
        std::fs::write(path, text + "\n").map_err(|error| Failure::Other(format!("{}: {error}", path.display())))?;
    }
    Ok(DONE)
}

fn print(arguments: &Arguments, entries: &[Entry]) {
    let [width, height] = arguments.size;
    println!(
        "{width}x{height}, {} bounces, {} rounds of {} samples",
        arguments.bounces, arguments.rounds, arguments.samples
    );
    println!(
        "{:<24} {:>10} {:>10} {:>10} {:>11} {:>11} {:>10}  backend",
        "scene", "ms/sample", "min", "max", "compile ms", "rays/pixel", "evals/ray"
    );
    for entry in entries {
        let [median, least, most] = entry.spread();
        println!(
            "{:<24} {median:>10.1} {least:>10.1} {most:>10.1} {:>11.1} {:>11.2} {:>10.2}  {}",
            entry.scene,
            entry.compile_ms,
            rays_per_pixel(arguments, entry),
            entry.census.evaluations_per_ray(),
            entry.backend
        );
    }
}

/// Rays of one sample.
fn rays_per_pixel(arguments: &Arguments, entry: &Entry) -> f64 {
    let pixels: u32 = arguments.counted_size().iter().product();
    entry.census.rays as f64 / f64::from(pixels)
}

fn json(arguments: &Arguments, entries: &[Entry]) -> serde_json::Value {
    let entries: Vec<_> = entries
        .iter()
        .map(|entry| {
            let [median, least, most] = entry.spread();
            serde_json::json!({
                "scene": entry.scene,
                "backend": entry.backend,
                "ms_per_sample": { "median": median, "min": least, "max": most },
                "compile_ms": entry.compile_ms,
                "rays_per_pixel": rays_per_pixel(arguments, entry),
                "evaluations_per_ray": entry.census.evaluations_per_ray(),
            })
        })
        .collect();
    serde_json::json!({
        "version": env!("CARGO_PKG_VERSION"),
        "size": arguments.size,
        "bounces": arguments.bounces,
        "rounds": arguments.rounds,
        "samples": arguments.samples,
        "entries": entries,
    })
}

/// A scene that is made on demand, or one of a file.
fn scene(path: &Path) -> Result<(String, Scene), Failure> {
    if let Some(made) = generated::ALL.iter().find(|made| Path::new(made.name) == path) {
        return Ok((made.name.to_owned(), Scene::parse(made.name, &made.text())?));
    }
    Ok((path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), Scene::load(path)?))
}

/// Renders until this many samples are done, the GPU's work included.
fn until(job: &mut Job, samples: u32) -> Result<(), Failure> {
    while job.samples_done() < f64::from(samples) {
        job.advance(samples).map_err(Failure::other)?;
    }
    job.wait().map_err(Failure::other)
}

fn thesis_scenes() -> Result<Vec<PathBuf>, Failure> {
    let directory = PathBuf::from("scenes/thesis");
    let files = std::fs::read_dir(&directory).map_err(|error| {
        Failure::Usage(format!("{}: {error}; run in the project's directory, or name scenes", directory.display()))
    })?;
    let mut paths: Vec<_> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "kdl"));
    paths.sort();
    Ok(paths)
}
