//! `pathmarch render`: a scene to a picture.

use super::{BackendArgument, parse_size};
use crate::exit::{DONE, Failure, INTERRUPTED};
use indicatif::{ProgressBar, ProgressStyle};
use pathmarch_render::image::{self, ImageFormat, Provenance};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::{Display, Tonemap};
use pathmarch_render::{Job, MAX_BOUNCES, RenderError, Renderer, Settings, scene_hash};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Arguments {
    /// The scene file
    scene: PathBuf,
    /// The picture to write: .png, .jpg or .exr [default: the scene's name, .png, in this directory]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Samples for each pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: Option<u32>,
    /// Index of the first sample; ranges rendered apart add up to the whole
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=2_000_000_000))]
    first_sample: u32,
    /// Scattering events after the first hit; 0 is emitted and direct light only [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_BOUNCES)))]
    bounces: Option<u32>,
    /// Pictures of different seeds have independent noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Which of the scene's cameras [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// How PNG and JPEG show radiance: agx, neutral or srgb [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = parse_tonemap)]
    tonemap: Option<Tonemap>,
    /// Stops of exposure for PNG and JPEG [default: the camera's]
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// What to render on
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
    /// The GPU adapter whose name contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

fn parse_tonemap(text: &str) -> Result<Tonemap, String> {
    Tonemap::from_name(text).ok_or_else(|| {
        let names: Vec<_> = Tonemap::ALL.iter().map(|tonemap| tonemap.name()).collect();
        format!("expected one of {}", names.join(", "))
    })
}

impl Arguments {
    fn settings(&self, scene: &Scene) -> Result<Settings, Failure> {
        let defaults = Settings::of(scene);
        let camera = match &self.camera {
            None => 0,
            Some(name) => scene.cameras.iter().position(|camera| camera.name == *name).ok_or_else(|| {
                let names: Vec<_> = scene.cameras.iter().map(|camera| format!("\"{}\"", camera.name)).collect();
                Failure::Usage(format!("the scene has no camera \"{name}\"; it has {}", names.join(", ")))
            })?,
        };
        Ok(Settings {
            size: self.size.unwrap_or(defaults.size),
            samples: self.samples.unwrap_or(defaults.samples),
            first_sample: self.first_sample,
            bounces: self.bounces.unwrap_or(defaults.bounces),
            seed: self.seed,
            sampler: defaults.sampler,
            camera,
        })
    }

    fn output(&self) -> Result<PathBuf, Failure> {
        let output = match &self.output {
            Some(output) => output.clone(),
            None => PathBuf::from(self.scene.file_stem().unwrap_or_default()).with_extension("png"),
        };
        ImageFormat::from_path(&output).map_err(|error| Failure::Usage(error.to_string()))?;
        // Better now than after an hour of rendering.
        let directory = output.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !directory.is_dir() {
            return Err(Failure::Other(format!("there is no directory {}; make it first", directory.display())));
        }
        Ok(output)
    }
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let output = arguments.output()?;
    let scene = Scene::load(&arguments.scene)?;
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    let settings = arguments.settings(&scene)?;
    let interrupted = watch_interrupts()?;
    let mut renderer =
        Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let mut job = renderer.start(&scene, &settings).map_err(|error| match error {
        RenderError::Settings(message) => Failure::Usage(message),
        other => Failure::other(other),
    })?;
    if let Some(notice) = renderer.notice() {
        eprintln!("note: {notice}; rendering on the CPU");
    }
    let [width, height] = settings.size;
    eprintln!(
        "{}: {width}x{height}, {} samples, {} bounces, on {} ({})",
        arguments.scene.display(),
        settings.samples,
        settings.bounces,
        renderer.backend_name(),
        renderer.adapter_name(),
    );
    let started = Instant::now();
    accumulate(&mut job, &settings, &interrupted).map_err(Failure::other)?;
    let film = job.film().map_err(Failure::other)?;
    let seconds = started.elapsed().as_secs_f64();

    let camera = &scene.cameras[settings.camera];
    let display = Display {
        tonemap: arguments.tonemap.unwrap_or(scene.render.tonemap),
        exposure_stops: arguments.exposure.unwrap_or(camera.exposure),
    };
    let provenance = Provenance {
        scene_hash: scene_hash(&scene),
        samples: film.samples,
        first_sample: settings.first_sample,
        seed: settings.seed,
        bounces: settings.bounces,
        adapter: renderer.adapter_name(),
        backend: renderer.backend_name(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    image::save(&output, &film.mean(), &display, &provenance).map_err(Failure::other)?;
    if film.non_finite > 0 {
        eprintln!("warning: {} samples were not finite and were left out", film.non_finite);
    }
    let complete = film.samples == settings.samples;
    eprintln!(
        "{}wrote {} after {} of {} samples in {seconds:.1} s ({:.2} samples/s)",
        if complete { "" } else { "interrupted: " },
        output.display(),
        film.samples,
        settings.samples,
        f64::from(film.samples) / seconds,
    );
    Ok(if complete { DONE } else { INTERRUPTED })
}

/// A flag that Ctrl-C raises; a second Ctrl-C ends the program at once.
fn watch_interrupts() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .map_err(Failure::other)?;
    Ok(flag)
}

/// Renders until all samples are done or an interrupt comes, and shows how far it is.
fn accumulate(job: &mut Job, settings: &Settings, interrupted: &AtomicBool) -> Result<(), RenderError> {
    // Thousandths of a sample, so that a sample that takes long is seen to move.
    let total = u64::from(settings.samples) * 1000;
    let bar = ProgressBar::new(total);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}, {eta} left") {
        bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
    }
    let started = Instant::now();
    while job.samples_done() < f64::from(settings.samples) && !interrupted.load(Ordering::SeqCst) {
        job.advance(settings.samples)?;
        let done = job.samples_done();
        bar.set_position((done * 1000.0) as u64);
        let rate = done / started.elapsed().as_secs_f64().max(1e-9);
        bar.set_message(format!("{}/{} samples, {rate:.2} samples/s", done as u32, settings.samples));
    }
    bar.finish_and_clear();
    Ok(())
}
