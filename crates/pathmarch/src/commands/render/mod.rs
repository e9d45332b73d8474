//! `pathmarch render`: renders scenes to pictures.

mod adaptive;
mod arguments;
mod checkpoint;
mod frame_denoiser;
mod frame_directory;
mod frames;
mod output;
mod progress;
mod samples;
mod still;

use super::counted;
use super::scene_source::SceneSource;
use crate::picture::{Denoised, Rendered};
use crate::video;
pub use arguments::Arguments;
use arguments::{Exposure, Layers};
use frame_directory::FrameDirectory;
use frames::Frames;
use output::Output;
use pathmarch_cli::{DONE, Failure, INTERRUPTED, catch_interrupts, note, print_report};
use pathmarch_render::exposure::{ExposureFault, exposure_fault, suitable_stops};
use pathmarch_render::film::Film;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::{Animation, Moment, Scene};
use pathmarch_render::{Backend, BackendInfo, Mode, RenderError, Renderer, Settings, kernel_wgsl};
use progress::Progress;
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use still::{Outcome, Task};

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    arguments.check()?;
    let outputs = arguments.outputs()?;
    let interrupted = catch_interrupts()?;
    let mut code = DONE;
    for (scene, output) in arguments.scenes.iter().zip(&outputs) {
        let one = Arguments { scenes: vec![scene.clone()], ..arguments.clone() };
        code = render(&one, output, &interrupted)?;
        if code == INTERRUPTED {
            break;
        }
    }
    Ok(code)
}

/// Renders one scene.
fn render(arguments: &Arguments, output: &Path, interrupted: &AtomicBool) -> Result<u8, Failure> {
    let source = SceneSource::of(&arguments.scenes[0])?;
    let mut animation = source.animation(arguments.allow_files)?;
    let fps = arguments.render_settings(&animation.at(Moment::default())?).fps;
    let progress = Progress::new(arguments.json, arguments.seconds);
    if let Some(range) = arguments.frames {
        let (renderer, animation) = (open_renderer(arguments, None)?, Arc::new(Mutex::new(animation)));
        let still_frames = video::is_video(output).then(|| FrameDirectory::of(output));
        let pattern = still_frames.as_ref().map_or(Ok(output), |frames| frames.create(arguments))?;
        let metered = metered(arguments, &renderer, &animation)?;
        let frames = Frames {
            arguments: metered.as_ref().unwrap_or(arguments),
            frames: range,
            fps,
            pattern,
            animation,
            renderer: &renderer,
            interrupted,
            progress: &progress,
        };
        let code = frames.run()?;
        return match still_frames {
            Some(frames) if code == DONE => frames.encode(output, range, fps).map(|()| code),
            _ => Ok(code),
        };
    }
    let scene = animation.at(Moment::of_seconds(arguments.time.unwrap_or(0.0), fps))?;
    for warning in &scene.warnings {
        print_report(warning);
    }
    let settings = arguments.settings(&scene)?;
    if let Some(file) = &arguments.dump_wgsl {
        return dump_wgsl(&scene, &settings, file);
    }
    still(arguments, (animation, &scene, fps), settings, &Output::of(output)?, (interrupted, &progress))
}

/// Arguments with the exposure of all frames, if it follows the picture: that of a small picture at the time 0. It is the same
/// for every part of an animation, and does not flicker.
fn metered(
    arguments: &Arguments,
    renderer: &Renderer,
    animation: &Arc<Mutex<Animation>>,
) -> Result<Option<Arguments>, Failure> {
    let scene = animation.lock().unwrap_or_else(PoisonError::into_inner).at(Moment::default())?;
    let settings = arguments.settings(&scene)?;
    if !arguments.has_auto_exposure(&scene, &settings) {
        return Ok(None);
    }
    let stops = renderer.meter(&scene, &settings).map_err(render_failure)?;
    note!("exposure {stops} EV in all frames, that of the first moment");
    Ok(Some(Arguments { exposure: Some(Exposure::Stops(stops)), ..arguments.clone() }))
}

/// Renders one picture.
fn still(
    arguments: &Arguments,
    (animation, scene, fps): (Animation, &Scene, f32),
    settings: Settings,
    output: &Output,
    (interrupted, progress): (&AtomicBool, &Progress),
) -> Result<u8, Failure> {
    let engine = still::engine_of_checkpoint(arguments, output);
    let renderer = open_renderer(arguments, engine.as_deref())?;
    let task = Task {
        arguments,
        renderer: &renderer,
        animation: &Arc::new(Mutex::new(animation)),
        scene,
        settings,
        shutter: arguments.shutter(scene, fps),
        output,
        interrupted,
        progress,
        place: (0, 1, None),
        turn: None,
        says_settings: true,
    };
    let outcome = task.run()?;
    progress.finish();
    report(&outcome, output, progress);
    if outcome.written && task.settings.mode == Mode::Path && matches!(output, Output::Picture(_) | Output::Standard) {
        let stops = arguments.display(scene, &task.settings, Some(&outcome.film)).exposure_stops;
        if arguments.has_auto_exposure(scene, &task.settings) {
            note!("exposure {stops} EV");
        } else {
            report_exposure(&outcome.film, stops);
        }
    }
    Ok(if outcome.interrupted { INTERRUPTED } else { DONE })
}

/// Opens the backend of the arguments; `engine` is that of a checkpoint, which decides if the arguments do not.
fn open_renderer(arguments: &Arguments, engine: Option<&str>) -> Result<Renderer, Failure> {
    let backend = match (Backend::from(arguments.backend), engine) {
        (Backend::Auto, Some(engine)) if engine.starts_with("CPU") => Backend::Cpu,
        (Backend::Auto, Some(_)) => Backend::Gpu,
        (backend, _) => backend,
    };
    let adapter = engine.and_then(|engine| engine.split_once(": ")).filter(|(name, _)| !name.starts_with("CPU"));
    let adapter =
        arguments.adapter.as_deref().or(adapter.map(|(_, adapter)| adapter)).filter(|_| backend != Backend::Cpu);
    Renderer::open(backend, adapter).map_err(Failure::other)
}

/// Says what was rendered.
fn report(outcome: &Outcome, output: &Output, progress: &Progress) {
    let Outcome { film, of, seconds, adaptive, .. } = outcome;
    if film.non_finite() > 0 {
        note!("warning: {} non-finite samples were discarded", film.non_finite());
    }
    let denoising = outcome.denoising.map_or_else(String::new, |seconds| format!(", denoised in {seconds:.1} s"));
    let resume = outcome.checkpoint.as_ref().map_or_else(String::new, |_| "; continue with --resume".to_owned());
    let samples = match adaptive {
        Some(adaptive) => format!("{} in {seconds:.1} s", adaptive.samples),
        None => {
            let rate = f64::from(outcome.rendered) / seconds;
            format!("{} of {} in {seconds:.1} s ({rate:.2} samples/s)", film.samples, counted(*of as usize, "sample"))
        }
    };
    note!(
        "{}{} {} after {samples}{denoising}{resume}",
        if outcome.interrupted { "interrupted: " } else { "" },
        if outcome.written { "wrote" } else { "did not write" },
        output.name(),
    );
    if let Some(adaptive) = adaptive {
        note!("{}", adaptive.error);
    }
    progress.event(
        if outcome.interrupted { "interrupted" } else { "done" },
        [
            ("output", json!(output.name())),
            ("written", json!(outcome.written)),
            ("samples", json!(film.samples)),
            ("of", json!(of)),
            ("seconds", json!(seconds)),
            ("rejected", json!(film.non_finite())),
            ("relative_error", json!(adaptive.as_ref().map(|adaptive| adaptive.worst))),
            ("checkpoint", json!(outcome.checkpoint)),
        ],
    );
}

/// Says that a picture is far too bright or too dark, and which exposure would suit it.
fn report_exposure(film: &Film, stops: f32) {
    let (Some(fault), Some(suitable)) = (exposure_fault(film, stops), suitable_stops(film)) else { return };
    let what = match fault {
        ExposureFault::Over(share) => format!("{:.0} % of the picture is overexposed", 100.0 * share),
        ExposureFault::Under => "the picture is almost black".to_owned(),
    };
    note!("note: {what}; `exposure {suitable}` in the camera, or --exposure auto, would suit it");
}

/// Writes the kernel of the picture, and renders nothing.
fn dump_wgsl(scene: &Scene, settings: &Settings, file: &Path) -> Result<u8, Failure> {
    let code = kernel_wgsl(scene, settings, false).map_err(render_failure)?;
    std::fs::write(file, &code)
        .map_err(|error| Failure::Other(format!("{}: cannot be written: {error}", file.display())))?;
    note!("wrote {}: the kernel of a GPU, {} lines of WGSL", file.display(), code.lines().count());
    Ok(DONE)
}

fn print_settings(arguments: &Arguments, backend: &BackendInfo, settings: &Settings, progress: &Progress) {
    let [width, height] = settings.size;
    progress.suspend(|| {
        if let Some(notice) = &backend.notice {
            note!("note: {notice}; rendering on the CPU");
        }
        note!(
            "{}: {width}x{height}, {}, on {} ({})",
            arguments.scene_name(),
            described(settings),
            backend.name,
            backend.adapter,
        );
    });
    progress.event(
        "start",
        [
            ("scene", json!(arguments.scene_name())),
            ("size", json!(settings.size)),
            ("samples", json!(settings.samples)),
            ("backend", json!(backend.name)),
            ("adapter", json!(backend.adapter)),
        ],
    );
}

/// Writes a film, or its denoised picture.
fn write(
    arguments: &Arguments,
    backend: &BackendInfo,
    scene: &Scene,
    settings: &Settings,
    film: &Film,
    denoised: Option<Denoised>,
    output: &Output,
) -> Result<(), Failure> {
    let display = settings.mode.display(arguments.display(scene, settings, Some(film)));
    let rendered = Rendered { scene, settings, film, backend, denoised };
    let layers = arguments.aov.as_ref().map_or(&[][..], |Layers(layers)| layers);
    let Some(file) = output.file() else {
        let bytes = rendered.encode(Path::new("standard output"), ImageFormat::Png, &display, layers);
        let mut out = std::io::stdout().lock();
        return out.write_all(&bytes.map_err(Failure::Other)?).and_then(|()| out.flush()).map_err(Failure::other);
    };
    rendered.write(file, &display, layers).map_err(Failure::Other)
}

fn render_failure(error: RenderError) -> Failure {
    match error {
        RenderError::Settings(message) => Failure::Usage(message),
        RenderError::Scene(error) => error.into(),
        other => Failure::other(other),
    }
}

/// Description of the render settings.
fn described(settings: &Settings) -> String {
    let Settings { samples, first_sample, bounces, mode, .. } = settings;
    let samples = match settings.whole_samples {
        Some(whole) => format!("samples {first_sample}..{} of {whole}", first_sample + samples),
        None => counted(*samples as usize, "sample"),
    };
    let samples = settings.crop.map_or(samples.clone(), |crop| format!("pixels {crop}, {samples}"));
    match mode {
        Mode::Path => format!("{samples}, {}", counted(*bounces as usize, "bounce")),
        Mode::Variance => format!("mode {}, {samples}, {}", mode.name(), counted(*bounces as usize, "bounce")),
        _ => format!("mode {}, {samples}", mode.name()),
    }
}

/// Default name of the output of a scene.
fn default_output(scene: &Path, frames: bool) -> PathBuf {
    let stem =
        if scene == Path::new("-") { "stdin".into() } else { scene.file_stem().unwrap_or_default().to_string_lossy() };
    PathBuf::from(format!("{stem}{}.png", if frames { "-####" } else { "" }))
}
