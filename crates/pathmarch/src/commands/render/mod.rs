//! `pathmarch render`: renders a scene to a picture.

mod arguments;
mod denoising;

use super::progress_bar;
use crate::frames::{self, FrameRange};
use crate::picture::{Denoised, Rendered};
pub use arguments::Arguments;
use arguments::Layers;
use denoising::Samples;
use pathmarch_cli::{DONE, Failure, INTERRUPTED, catch_interrupts, print_report};
use pathmarch_render::film::Film;
use pathmarch_render::pathmarch_scene::{Animation, Moment, Scene};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{BackendInfo, Mode, RenderError, Renderer, Settings, kernel_wgsl};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let output = arguments.output()?;
    arguments.check_denoiser()?;
    let mut animation = Animation::load(&arguments.scene)?;
    let fps = arguments.render_settings(&animation.at(Moment::default())?).fps;
    if let Some(frames) = arguments.frames {
        return run_frames(arguments, frames, fps, &output, animation);
    }
    let moment = Moment::of_seconds(arguments.time.unwrap_or(0.0), fps);
    let scene = animation.at(moment)?;
    for warning in &scene.warnings {
        print_report(warning);
    }
    let settings = arguments.settings(&scene)?;
    if let Some(file) = &arguments.dump_wgsl {
        return dump_wgsl(&scene, &settings, file);
    }
    let interrupted = catch_interrupts()?;
    let renderer = Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let animation = Arc::new(Mutex::new(animation));
    let shutter = arguments.shutter(&scene, fps);
    let mut job = renderer.start_motion_blur(&animation, &scene, &settings, shutter).map_err(render_failure)?;
    print_settings(arguments, job.backend(), &settings);
    let started = Instant::now();
    // In units of 1/1000 sample, so that slow samples show progress.
    let bar = progress_bar(u64::from(settings.samples) * 1000);
    let stop = |done: f64| should_stop(arguments, &interrupted, started, done);
    let samples = Samples::render(&mut job, arguments.denoise, stop, |done| {
        bar.set_position((done * 1000.0) as u64);
        let rate = done / started.elapsed().as_secs_f64().max(1e-9);
        bar.set_message(format!("{}/{} samples, {rate:.2} samples/s", done as u32, settings.samples));
    })
    .map_err(render_failure)?;
    bar.finish_and_clear();
    let (film, seconds) = (samples.film(), started.elapsed().as_secs_f64());
    let denoised = samples.denoised(&animation, &scene, &settings, shutter)?;
    let filter_seconds = started.elapsed().as_secs_f64() - seconds;
    let denoising = denoised.as_ref().map_or(String::new(), |_| format!(", denoised in {filter_seconds:.1} s"));
    write(arguments, job.backend(), &scene, &settings, film, denoised, &output)?;
    if film.non_finite() > 0 {
        eprintln!("warning: {} non-finite samples were discarded", film.non_finite());
    }
    let cut_short = film.samples < settings.samples && interrupted.load(Ordering::SeqCst);
    eprintln!(
        "{}wrote {} after {} of {} samples in {seconds:.1} s ({:.2} samples/s){denoising}",
        if cut_short { "interrupted: " } else { "" },
        output.display(),
        film.samples,
        settings.samples,
        f64::from(film.samples) / seconds,
    );
    Ok(if cut_short { INTERRUPTED } else { DONE })
}

/// Writes the kernel of the picture, and renders nothing.
fn dump_wgsl(scene: &Scene, settings: &Settings, file: &Path) -> Result<u8, Failure> {
    let code = kernel_wgsl(scene, settings, false).map_err(render_failure)?;
    std::fs::write(file, &code)
        .map_err(|error| Failure::Other(format!("{}: cannot be written: {error}", file.display())))?;
    eprintln!("wrote {}: the kernel of a GPU, {} lines of WGSL", file.display(), code.lines().count());
    Ok(DONE)
}

/// Renders frames one after the other; a frame is written once it is complete.
fn run_frames(
    arguments: &Arguments,
    frames: FrameRange,
    fps: f32,
    pattern: &Path,
    animation: Animation,
) -> Result<u8, Failure> {
    let all: Vec<u32> = frames.numbers().collect();
    let there = |frame: &u32| arguments.skip_existing && frames::file(pattern, *frame).exists();
    let left: Vec<u32> = all.iter().copied().filter(|frame| !there(frame)).collect();
    let skipped = all.len() - left.len();
    let Some(&first) = left.first() else {
        eprintln!("all {} frames exist already", all.len());
        return Ok(DONE);
    };
    let interrupted = catch_interrupts()?;
    let renderer = Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let animation = Arc::new(Mutex::new(animation));
    let began = Instant::now();
    let bar = progress_bar(left.len() as u64 * 1000);
    let mut non_finite = 0;
    let mut warned: Vec<String> = Vec::new();
    for (index, &frame) in left.iter().enumerate() {
        let moment = Moment::of_frame(frame, fps);
        let scene = animation.lock().unwrap_or_else(PoisonError::into_inner).at(moment);
        let scene = scene.map_err(|error| in_frame(frame, error.into()))?;
        for warning in scene.warnings.iter().filter(|warning| !warned.contains(&warning.message)) {
            bar.suspend(|| print_report(warning));
        }
        warned.extend(scene.warnings.iter().map(|warning| warning.message.clone()));
        let settings = arguments.settings(&scene)?;
        let shutter = arguments.shutter(&scene, fps);
        let job = renderer.start_motion_blur(&animation, &scene, &settings, shutter);
        let mut job = job.map_err(|error| in_frame(frame, render_failure(error)))?;
        if frame == first {
            print_settings(arguments, job.backend(), &settings);
        }
        let started = Instant::now();
        let stop = |done: f64| should_stop(arguments, &interrupted, started, done);
        let samples = Samples::render(&mut job, arguments.denoise, stop, |done| {
            let share = done / f64::from(settings.samples);
            bar.set_position(((index as f64 + share) * 1000.0) as u64);
            let (number, count) = (index + 1, left.len());
            bar.set_message(format!("frame {frame} ({number}/{count}), {}/{} samples", done as u32, settings.samples));
        });
        let samples = samples.map_err(|error| in_frame(frame, render_failure(error)))?;
        // An incomplete frame is not written: its file would count as done.
        if interrupted.load(Ordering::SeqCst) {
            bar.finish_and_clear();
            let (wrote, more) = (frame_count(index), left.len() - index);
            eprintln!("interrupted: wrote {wrote}, {more} left; continue with --skip-existing");
            return Ok(INTERRUPTED);
        }
        let output = frames::file(pattern, frame);
        let denoised = samples.denoised(&animation, &scene, &settings, shutter);
        let wrote = denoised
            .and_then(|denoised| write(arguments, job.backend(), &scene, &settings, samples.film(), denoised, &output));
        wrote.map_err(|failure| in_frame(frame, failure))?;
        non_finite += samples.film().non_finite();
    }
    bar.finish_and_clear();
    if non_finite > 0 {
        eprintln!("warning: {non_finite} non-finite samples were discarded");
    }
    let there = if skipped > 0 { format!(", {skipped} existed already") } else { String::new() };
    let (wrote, seconds) = (frame_count(left.len()), began.elapsed().as_secs_f64());
    eprintln!("wrote {wrote} to {} in {seconds:.1} s{there}", pattern.display());
    Ok(DONE)
}

fn frame_count(frames: usize) -> String {
    if frames == 1 { "1 frame".to_owned() } else { format!("{frames} frames") }
}

/// Adds the frame number to a failure.
fn in_frame(frame: u32, failure: Failure) -> Failure {
    match failure {
        Failure::Scene(error) => {
            eprintln!("frame {frame} cannot be rendered; frames written before it are kept");
            Failure::Scene(error)
        }
        Failure::Interrupted => Failure::Interrupted,
        Failure::Usage(message) => Failure::Usage(format!("frame {frame}: {message}")),
        Failure::Other(message) => Failure::Other(format!("frame {frame}: {message}")),
    }
}

/// Returns true if a picture has to stop early.
fn should_stop(arguments: &Arguments, interrupted: &AtomicBool, started: Instant, done: f64) -> bool {
    let late = arguments.seconds.is_some_and(|seconds| started.elapsed().as_secs_f64() >= seconds);
    interrupted.load(Ordering::SeqCst) || late && done >= 1.0
}

fn print_settings(arguments: &Arguments, backend: &BackendInfo, settings: &Settings) {
    if let Some(notice) = &backend.notice {
        eprintln!("note: {notice}; rendering on the CPU");
    }
    let [width, height] = settings.size;
    eprintln!(
        "{}: {width}x{height}, {}, on {} ({})",
        arguments.scene.display(),
        described(settings),
        backend.name,
        backend.adapter,
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
    output: &Path,
) -> Result<(), Failure> {
    let display = settings.mode.display(Display {
        tonemap: arguments.render_settings(scene).tonemap,
        exposure_stops: arguments.exposure.unwrap_or(settings.camera_of(scene).exposure),
    });
    let rendered = Rendered { scene, settings, film, backend, denoised };
    let layers = arguments.aov.as_ref().map_or(&[][..], |Layers(layers)| layers);
    rendered.write(output, &display, layers).map_err(Failure::Other)
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
    let Settings { samples, bounces, mode, .. } = settings;
    match mode {
        Mode::Path => format!("{samples} samples, {bounces} bounces"),
        Mode::Variance => format!("mode {}, {samples} samples, {bounces} bounces", mode.name()),
        _ => format!("mode {}, {samples} samples", mode.name()),
    }
}
