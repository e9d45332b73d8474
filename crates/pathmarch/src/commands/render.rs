//! `pathmarch render`: renders a scene to a picture.

use super::{listed, progress_bar};
use crate::frames::{self, FrameRange};
use crate::picture::{RenderTask, Rendered};
use pathmarch_cli::{
    BackendArgument, DONE, Failure, INTERRUPTED, catch_interrupts, check_directory, print_report, value_parsers,
};
use pathmarch_render::aov::Layer;
use pathmarch_render::film::Film;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::{Animation, Caustics, Moment, Sampler, Scene, limits};
use pathmarch_render::tonemap::{Display, Tonemap};
use pathmarch_render::{MAX_SPLITTING, Mode, MotionError, RenderError, Renderer, Settings, Shutter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Picture to write: .png, .jpg or .exr [default: name of the scene with .png, in the current directory]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// Quantity to render [default: path]
    ///
    /// path: path-traced light.
    /// preview: noise-free preview: direct light, soft shadows, ambient occlusion, one reflection.
    /// albedo: base colour of the material; for a light source, its radiance clipped to 1.
    /// normal: world-space normal: red x, green y, blue z, from -1 to 1.
    /// depth: distance along the camera's axis: white near, grey at the target, black far.
    /// object-id, material-id: one colour for each object, or for each material.
    /// steps: field evaluations of the camera ray: blue few, red 256; black none.
    /// violations: places where the field exceeds its Lipschitz constant: grey none, green to red more.
    /// variance: relative standard error of the path-traced pixel: blue 0.1 %, green 3 %, red 100 %.
    /// RenderTask and tone mapping affect only path and preview.
    #[arg(long, value_name = "NAME", value_parser = named_value(Mode::ALL, Mode::name), verbatim_doc_comment)]
    mode: Option<Mode>,
    /// Samples per pixel [default: the scene's; 16 in modes that trace no paths]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole(limits::SAMPLES), allow_hyphen_values = true)]
    samples: Option<u32>,
    /// Stop after this many seconds, at most 86400, but not before the first sample is done
    #[arg(long, value_name = "N", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    seconds: Option<f64>,
    /// Index of the first sample; sample ranges rendered separately add up to the whole
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, 2_000_000_000)), allow_hyphen_values = true)]
    first_sample: u32,
    /// Scattering events after the first hit; 0 renders emitted and direct light only [default: the scene's]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole(limits::BOUNCES), allow_hyphen_values = true)]
    bounces: Option<u32>,
    /// Random seed; pictures with different seeds have independent noise
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, u32::MAX)), allow_hyphen_values = true)]
    seed: u32,
    /// Camera of the scene, by name [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Tone mapping of PNG and JPEG: agx, neutral or srgb [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = named_value(Tonemap::ALL, Tonemap::name))]
    tonemap: Option<Tonemap>,
    /// Sampler: sobol, or independent for comparison [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = named_value(Sampler::ALL, Sampler::name))]
    sampler: Option<Sampler>,
    /// Caustics through clear glass: traced, or fast (noise-free but biased) [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = named_value(Caustics::ALL, Caustics::name))]
    caustics: Option<Caustics>,
    /// Clamp the radiance of indirect light to this: fewer fireflies, but darker [default: the scene's]
    #[arg(long, value_name = "RADIANCE", value_parser = value_parsers::number(limits::CLAMP), allow_hyphen_values = true)]
    clamp: Option<f32>,
    /// Paths per camera ray, 1 to 8 [default: chosen for the fastest convergence]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, MAX_SPLITTING)), allow_hyphen_values = true)]
    splitting: Option<u32>,
    /// Hit distance of a ray, in pixels: smaller shows finer detail and needs more steps [default: the scene's]
    #[arg(long, value_name = "PIXELS", value_parser = value_parsers::number(limits::DETAIL), allow_hyphen_values = true)]
    detail: Option<f32>,
    /// RenderTask of PNG and JPEG in stops, -100 to 100 [default: the camera's]
    #[arg(long, value_name = "EV", value_parser = value_parsers::number(limits::EXPOSURE), allow_hyphen_values = true)]
    exposure: Option<f32>,
    /// Write noise-free layers beside R, G and B; .exr only [default: all; or a list such as albedo,normal]
    ///
    /// albedo.R .G .B: base colour, or a light source's radiance clipped to 1; pixel mean.
    /// normal.X .Y .Z: world-space normal facing the camera; normalised pixel mean.
    /// depth.Z: metres along the camera's axis; infinite for the background.
    /// position.X .Y .Z: world-space position, metres.
    /// objectId.X, materialId.X: integers from 1 in scene order, 0 for the background.
    /// sampleCount.X: integer, number of samples of the pixel.
    /// Depth, position and ids are those at the pixel's centre.
    #[arg(long, value_name = "LAYERS", num_args = 0..=1, default_missing_value = "all", value_parser = parse_layers, verbatim_doc_comment)]
    aov: Option<Layers>,
    /// FrameRange of an animation: one (7), a range (1-120), or every second frame (1-120x2)
    ///
    /// Formulas of the scene read the frame number as frame, and frame/fps as t. In the file name, # stands for the
    /// digits
    /// of the frame number: -o out/frame-####.png. FrameRange already written are kept if the program is interrupted.
    #[arg(long, value_name = "RANGE", value_parser = frames::parse, allow_hyphen_values = true, verbatim_doc_comment)]
    frames: Option<FrameRange>,
    /// Skip frames whose file exists, to continue after an interruption
    #[arg(long, requires = "frames")]
    skip_existing: bool,
    /// FrameRange per second [default: the scene's]
    #[arg(long, value_name = "N", value_parser = value_parsers::number(limits::FPS), allow_hyphen_values = true)]
    fps: Option<f32>,
    /// Time of the picture: seconds since frame 0
    #[arg(long, value_name = "SECONDS", conflicts_with = "frames", value_parser = parse_time, allow_hyphen_values = true)]
    time: Option<f64>,
    /// Fraction of the frame time that the shutter is open, 0 to 1: motion blur [default: the scene's]
    #[arg(long, value_name = "PART", value_parser = value_parsers::number(limits::SHUTTER), allow_hyphen_values = true)]
    shutter: Option<f32>,
    /// Render backend
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Parser for a setting with a fixed set of names.
fn named_value<T: Copy, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        all.into_iter().find(|one| name(*one) == text).ok_or_else(|| {
            let names: Vec<_> = all.iter().map(|one| name(*one)).collect();
            format!("expected one of {}", names.join(", "))
        })
    }
}

/// Largest time of an animation, seconds.
const MAX_TIME: f64 = 1e9;

fn parse_time(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse().ok().filter(|seconds: &f64| (0.0..=MAX_TIME).contains(seconds));
    seconds.ok_or_else(|| format!("must be a number of seconds from 0 to {MAX_TIME}"))
}

/// Layers of `--aov`.
#[derive(Clone)]
struct Layers(Vec<Layer>);

fn parse_layers(text: &str) -> Result<Layers, String> {
    if text == "all" {
        return Ok(Layers(Layer::ALL.to_vec()));
    }
    let mut layers = Vec::new();
    for name in text.split(',') {
        let layer = Layer::from_name(name.trim()).ok_or_else(|| {
            let names = Layer::ALL.map(Layer::name).join(", ");
            format!("unknown layer \"{name}\"; expected {names} or all; the scene comes before --aov")
        })?;
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    }
    Ok(Layers(layers))
}

impl Arguments {
    fn settings(&self, scene: &Scene) -> Result<Settings, Failure> {
        let defaults = Settings::of(scene);
        let mode = self.mode.unwrap_or_default();
        let camera = match &self.camera {
            None => 0,
            Some(name) => scene.cameras.iter().position(|camera| camera.name == *name).ok_or_else(|| {
                let names = listed(scene.cameras.iter().map(|camera| camera.name.as_str()));
                Failure::Usage(format!("the scene has no camera \"{name}\"; it has {names}"))
            })?,
        };
        Ok(Settings {
            size: self.size.unwrap_or(defaults.size),
            samples: self.samples.unwrap_or(mode.samples(defaults.samples)),
            first_sample: self.first_sample,
            bounces: self.bounces.unwrap_or(defaults.bounces),
            seed: self.seed,
            sampler: self.sampler.unwrap_or(defaults.sampler),
            caustics: self.caustics.unwrap_or(defaults.caustics),
            clamp: self.clamp.or(defaults.clamp),
            detail: self.detail.unwrap_or(defaults.detail),
            light_search: defaults.light_search,
            camera,
            viewpoint: None,
            mode,
            splitting: self.splitting,
        })
    }

    fn shutter(&self, scene: &Scene, fps: f32) -> Shutter {
        Shutter::open_for(scene, self.shutter.unwrap_or(scene.render.shutter), fps)
    }

    fn output(&self) -> Result<PathBuf, Failure> {
        let output = match &self.output {
            Some(output) => output.clone(),
            None => {
                let stem = self.scene.file_stem().unwrap_or_default().to_string_lossy();
                let digits = if self.frames.is_some() { "-####" } else { "" };
                PathBuf::from(format!("{stem}{digits}.png"))
            }
        };
        if let Some(frames) = self.frames {
            frames::check_pattern(&output, frames).map_err(Failure::Usage)?;
        }
        let format = ImageFormat::from_path(&output).map_err(|error| Failure::Usage(error.to_string()))?;
        if self.aov.is_some() && format != ImageFormat::Exr {
            return Err(Failure::Usage(format!(
                "--aov: {} cannot store layers, only OpenEXR can; use -o {}",
                output.display(),
                output.with_extension("exr").display()
            )));
        }
        check_directory(&output)?;
        Ok(output)
    }
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let output = arguments.output()?;
    let mut animation = Animation::load(&arguments.scene)?;
    let fps = match arguments.fps {
        Some(fps) => fps,
        None => animation.at(Moment::default())?.render.fps,
    };
    if let Some(frames) = arguments.frames {
        return run_frames(arguments, frames, fps, &output, &mut animation);
    }
    let moment = Moment::of_seconds(arguments.time.unwrap_or(0.0), fps);
    let scene = animation.at(moment)?;
    for warning in &scene.warnings {
        print_report(warning);
    }
    let settings = arguments.settings(&scene)?;
    let interrupted = catch_interrupts()?;
    let mut renderer =
        Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let mut task =
        RenderTask::start(&mut renderer, &scene, &settings, arguments.shutter(&scene, fps)).map_err(render_failure)?;
    print_settings(arguments, &renderer, &settings);
    let started = Instant::now();
    // In units of 1/1000 sample, so that slow samples show progress.
    let bar = progress_bar(u64::from(settings.samples) * 1000);
    let stop = |done: f64| should_stop(arguments, &interrupted, started, done);
    task.accumulate(&mut renderer, &mut animation, settings.samples, stop, |done| {
        bar.set_position((done * 1000.0) as u64);
        let rate = done / started.elapsed().as_secs_f64().max(1e-9);
        bar.set_message(format!("{}/{} samples, {rate:.2} samples/s", done as u32, settings.samples));
    })
    .map_err(motion_failure)?;
    bar.finish_and_clear();
    let film = task.film().map_err(motion_failure)?;
    let seconds = started.elapsed().as_secs_f64();
    write(arguments, &renderer, &scene, &settings, &film, &output)?;
    if film.non_finite() > 0 {
        eprintln!("warning: {} non-finite samples were discarded", film.non_finite());
    }
    let cut_short = film.samples < settings.samples && interrupted.load(Ordering::SeqCst);
    eprintln!(
        "{}wrote {} after {} of {} samples in {seconds:.1} s ({:.2} samples/s)",
        if cut_short { "interrupted: " } else { "" },
        output.display(),
        film.samples,
        settings.samples,
        f64::from(film.samples) / seconds,
    );
    Ok(if cut_short { INTERRUPTED } else { DONE })
}

/// Renders frames one after the other; a frame is written once it is complete.
fn run_frames(
    arguments: &Arguments,
    frames: FrameRange,
    fps: f32,
    pattern: &Path,
    animation: &mut Animation,
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
    let mut renderer =
        Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let began = Instant::now();
    let bar = progress_bar(left.len() as u64 * 1000);
    let mut non_finite = 0;
    let mut warned: Vec<String> = Vec::new();
    for (index, &frame) in left.iter().enumerate() {
        let scene = animation.at(Moment::of_frame(frame, fps)).map_err(|error| in_frame(frame, error.into()))?;
        for warning in scene.warnings.iter().filter(|warning| !warned.contains(&warning.message)) {
            bar.suspend(|| print_report(warning));
        }
        warned.extend(scene.warnings.iter().map(|warning| warning.message.clone()));
        let settings = arguments.settings(&scene)?;
        let task = RenderTask::start(&mut renderer, &scene, &settings, arguments.shutter(&scene, fps));
        let mut task = task.map_err(|error| in_frame(frame, render_failure(error)))?;
        if frame == first {
            print_settings(arguments, &renderer, &settings);
        }
        let started = Instant::now();
        let stop = |done: f64| should_stop(arguments, &interrupted, started, done);
        let result = task.accumulate(&mut renderer, animation, settings.samples, stop, |done| {
            let share = done / f64::from(settings.samples);
            bar.set_position(((index as f64 + share) * 1000.0) as u64);
            let (number, count) = (index + 1, left.len());
            bar.set_message(format!("frame {frame} ({number}/{count}), {}/{} samples", done as u32, settings.samples));
        });
        result.map_err(|error| in_frame(frame, motion_failure(error)))?;
        // An incomplete frame is not written: its file would count as done.
        if interrupted.load(Ordering::SeqCst) {
            bar.finish_and_clear();
            let (wrote, more) = (frame_count(index), left.len() - index);
            eprintln!("interrupted: wrote {wrote}, {more} left; continue with --skip-existing");
            return Ok(INTERRUPTED);
        }
        let film = task.film().map_err(|error| in_frame(frame, motion_failure(error)))?;
        let output = frames::file(pattern, frame);
        let wrote = write(arguments, &renderer, &scene, &settings, &film, &output);
        wrote.map_err(|failure| in_frame(frame, failure))?;
        non_finite += film.non_finite();
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

fn print_settings(arguments: &Arguments, renderer: &Renderer, settings: &Settings) {
    if let Some(notice) = renderer.notice() {
        eprintln!("note: {notice}; rendering on the CPU");
    }
    let [width, height] = settings.size;
    eprintln!(
        "{}: {width}x{height}, {}, on {} ({})",
        arguments.scene.display(),
        described(settings),
        renderer.backend_name(),
        renderer.adapter_name(),
    );
}

/// Writes a film as a picture.
fn write(
    arguments: &Arguments,
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    film: &Film,
    output: &Path,
) -> Result<(), Failure> {
    let display = settings.mode.display(Display {
        tonemap: arguments.tonemap.unwrap_or(scene.render.tonemap),
        exposure_stops: arguments.exposure.unwrap_or(settings.camera_of(scene).exposure),
    });
    let (backend, adapter) = (renderer.backend_name(), renderer.adapter_name());
    let rendered = Rendered { scene, settings, film, backend, adapter };
    let layers = arguments.aov.as_ref().map_or(&[][..], |Layers(layers)| layers);
    rendered.write(output, &display, layers).map_err(Failure::Other)
}

fn render_failure(error: RenderError) -> Failure {
    match error {
        RenderError::Settings(message) => Failure::Usage(message),
        other => Failure::other(other),
    }
}

fn motion_failure(error: MotionError) -> Failure {
    match error {
        MotionError::Scene(error) => error.into(),
        MotionError::Render(error) => render_failure(error),
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
