//! `pathmarch bench`: milliseconds for one sample of every pixel, for each scene and backend.
//!
//! Scenes and backends are measured in turn, round after round, and the median is reported, so that a machine whose
//! speed drifts treats all alike. Compilation is timed apart.

use super::parse_size;
use crate::exit::{DONE, Failure};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Job, MAX_BOUNCES, Renderer, Settings, adapters};
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Arguments {
    /// The scene files [default: all of scenes/thesis]
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
}

struct Entry {
    scene: String,
    backend: String,
    compile_ms: f64,
    job: Job,
    times_ms: Vec<f64>,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let mut paths = arguments.scenes.clone();
    if paths.is_empty() {
        paths = thesis_scenes()?;
    }
    let mut renderers = vec![];
    for adapter in adapters().iter().filter(|adapter| adapter.unusable.is_none()) {
        renderers.push(Renderer::open(Backend::Gpu, Some(&adapter.name)).map_err(Failure::other)?);
    }
    renderers.push(Renderer::open(Backend::Cpu, None).map_err(Failure::other)?);

    let mut entries = Vec::new();
    for path in &paths {
        let scene = Scene::load(path)?;
        // One sample to warm up.
        let samples = 1 + arguments.rounds * arguments.samples;
        let settings = Settings { size: arguments.size, bounces: arguments.bounces, samples, ..Settings::of(&scene) };
        for renderer in &mut renderers {
            let mut job = renderer.start(&scene, &settings).map_err(Failure::other)?;
            until(&mut job, 1)?;
            entries.push(Entry {
                scene: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
                backend: format!("{} ({})", renderer.backend_name(), renderer.adapter_name()),
                compile_ms: job.compile_time().as_secs_f64() * 1e3,
                job,
                times_ms: Vec::new(),
            });
        }
    }
    for round in 0..arguments.rounds {
        for entry in &mut entries {
            let started = Instant::now();
            until(&mut entry.job, 1 + (round + 1) * arguments.samples)?;
            entry.times_ms.push(started.elapsed().as_secs_f64() * 1e3 / f64::from(arguments.samples));
        }
    }
    let [width, height] = arguments.size;
    println!(
        "{width}x{height}, {} bounces, {} rounds of {} samples",
        arguments.bounces, arguments.rounds, arguments.samples
    );
    println!("{:<24} {:>10} {:>10} {:>10} {:>11}  backend", "scene", "ms/sample", "min", "max", "compile ms");
    for entry in &mut entries {
        entry.times_ms.sort_by(f64::total_cmp);
        let times = &entry.times_ms;
        println!(
            "{:<24} {:>10.1} {:>10.1} {:>10.1} {:>11.1}  {}",
            entry.scene,
            times[times.len() / 2],
            times[0],
            times[times.len() - 1],
            entry.compile_ms,
            entry.backend
        );
    }
    Ok(DONE)
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
