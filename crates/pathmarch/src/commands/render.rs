//! `pathmarch render`: a scene to a picture.

use super::{listed, progress_bar};
use crate::frames::{self, Frames};
use crate::picture::{Exposure, Rendered};
use pathmarch_cli::{
    BackendArgument, DONE, Failure, INTERRUPTED, check_directory, numbers, print_report, watch_interrupts,
};
use pathmarch_render::aov::Layer;
use pathmarch_render::film::Film;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::{Animation, Caustics, Moment, Sampler, Scene, settings};
use pathmarch_render::tonemap::{Display, Tonemap};
use pathmarch_render::{MAX_SPLITTING, Mode, MotionError, RenderError, Renderer, Settings, Shutter};
use std::path::{Path, PathBuf};
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
    #[arg(long, value_name = "WxH", value_parser = numbers::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// What the picture shows [default: path]
    ///
    /// path: light as it is.
    /// preview: a quick look without noise: direct light, soft shadows, ambient occlusion, one reflection.
    /// albedo: the colour of the material; of a lamp, its radiance clipped to 1.
    /// normal: where the surface faces in the world: red x, green y, blue z, from -1 to 1.
    /// depth: distance along the camera's axis: white near, grey at the target, black far away.
    /// object-id, material-id: a colour for each object, or for each material.
    /// steps: evaluations of the field by the camera's ray: blue few, red 256; black where none.
    /// violations: where the field changes faster than its Lipschitz constant allows: grey not, green to red where it does.
    /// variance: relative standard error of the path-traced pixel: blue 0.1 %, green 3 %, red 100 %.
    /// Exposure and tone curve act on path and preview only.
    #[arg(long, value_name = "NAME", value_parser = one_of(Mode::ALL, Mode::name), verbatim_doc_comment)]
    mode: Option<Mode>,
    /// Samples for each pixel [default: the scene's; 16 in modes that trace no paths]
    #[arg(long, value_name = "N", value_parser = numbers::whole(settings::SAMPLES), allow_hyphen_values = true)]
    samples: Option<u32>,
    /// Stop after this many seconds, at most 86400, whatever is done by then; at least one sample is
    #[arg(long, value_name = "N", value_parser = numbers::seconds, allow_hyphen_values = true)]
    seconds: Option<f64>,
    /// Index of the first sample; ranges rendered apart add up to the whole
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = numbers::whole((0, 2_000_000_000)), allow_hyphen_values = true)]
    first_sample: u32,
    /// Scattering events after the first hit; 0 is emitted and direct light only [default: the scene's]
    #[arg(long, value_name = "N", value_parser = numbers::whole(settings::BOUNCES), allow_hyphen_values = true)]
    bounces: Option<u32>,
    /// Pictures of different seeds have independent noise
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = numbers::whole((0, u32::MAX)), allow_hyphen_values = true)]
    seed: u32,
    /// Which of the scene's cameras [default: the first]
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// How PNG and JPEG show radiance: agx, neutral or srgb [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = one_of(Tonemap::ALL, Tonemap::name))]
    tonemap: Option<Tonemap>,
    /// Random numbers: sobol, or independent to compare with [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = one_of(Sampler::ALL, Sampler::name))]
    sampler: Option<Sampler>,
    /// Light through clear glass: traced, or fast, which is free of noise and biased [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = one_of(Caustics::ALL, Caustics::name))]
    caustics: Option<Caustics>,
    /// Largest radiance of a contribution of light that bounced, against fireflies; darkens [default: the scene's]
    #[arg(long, value_name = "RADIANCE", value_parser = numbers::number(settings::CLAMP), allow_hyphen_values = true)]
    clamp: Option<f32>,
    /// Paths that share a ray of the camera, 1 to 8 [default: what makes the picture converge soonest]
    #[arg(long, value_name = "N", value_parser = numbers::whole((1, MAX_SPLITTING)), allow_hyphen_values = true)]
    splitting: Option<u32>,
    /// How near to a surface a ray ends, in pixels as seen: smaller shows finer detail, and costs steps [default: the scene's]
    #[arg(long, value_name = "PIXELS", value_parser = numbers::number(settings::DETAIL), allow_hyphen_values = true)]
    detail: Option<f32>,
    /// Stops of exposure for PNG and JPEG, -100 to 100 [default: the camera's]
    #[arg(long, value_name = "EV", value_parser = numbers::number(settings::EXPOSURE), allow_hyphen_values = true)]
    exposure: Option<f32>,
    /// Write layers beside R, G and B, without noise; .exr only [default: all; or a list, such as albedo,normal]
    ///
    /// albedo.R .G .B: the material's colour, or a lamp's radiance clipped to 1; mean over the pixel.
    /// normal.X .Y .Z: in the world, towards the camera; mean over the pixel, of length one.
    /// depth.Z: metres along the camera's view axis; infinite where nothing is.
    /// position.X .Y .Z: in the world, metres.
    /// objectId.X, materialId.X: integers, 1 for the first in the scene, 0 where nothing is.
    /// sampleCount.X: integer, the samples in the pixel's mean.
    /// Depth, position and the ids are those at the pixel's centre.
    #[arg(long, value_name = "LAYERS", num_args = 0..=1, default_missing_value = "all", value_parser = parse_layers, verbatim_doc_comment)]
    aov: Option<Layers>,
    /// Frames of an animation: one, a range such as 1-120, or every second of it, 1-120x2
    ///
    /// Formulas of the scene know the number as frame, and frame/fps as t. The name of the file has # where the digits of
    /// the number go: -o out/frame-####.png. Frames that are written stay when the program is interrupted.
    #[arg(long, value_name = "RANGE", value_parser = frames::parse, allow_hyphen_values = true, verbatim_doc_comment)]
    frames: Option<Frames>,
    /// Leave out frames whose file is there, to go on after an interrupt
    #[arg(long, requires = "frames")]
    skip_existing: bool,
    /// Frames in a second [default: the scene's]
    #[arg(long, value_name = "N", value_parser = numbers::number(settings::FPS), allow_hyphen_values = true)]
    fps: Option<f32>,
    /// The moment of the picture: seconds since frame 0
    #[arg(long, value_name = "SECONDS", conflicts_with = "frames", value_parser = parse_moment, allow_hyphen_values = true)]
    time: Option<f64>,
    /// For which part of a frame's time the shutter is open, 0 to 1: motion blur [default: the scene's]
    #[arg(long, value_name = "PART", value_parser = numbers::number(settings::SHUTTER), allow_hyphen_values = true)]
    shutter: Option<f32>,
    /// What to render on
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
    /// The GPU adapter whose name contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// One of a setting's names.
fn one_of<T: Copy, const N: usize>(
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

/// The last moment of an animation, seconds.
const LAST_MOMENT: f64 = 1e9;

fn parse_moment(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse().ok().filter(|seconds: &f64| (0.0..=LAST_MOMENT).contains(seconds));
    seconds.ok_or_else(|| format!("must be a number of seconds from 0 to {LAST_MOMENT}"))
}

/// `--aov`
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
            format!("there is no layer \"{name}\"; there are {names}, and all; the scene comes before --aov")
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
                "--aov: {} cannot hold layers, only OpenEXR can; write to -o {}",
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
    let interrupted = watch_interrupts()?;
    let mut renderer =
        Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let mut exposure =
        Exposure::start(&mut renderer, &scene, &settings, arguments.shutter(&scene, fps)).map_err(of_renderer)?;
    tell_what_is_rendered(arguments, &renderer, &settings);
    let started = Instant::now();
    // Thousandths of a sample, so that a sample that takes long is seen to move.
    let bar = progress_bar(u64::from(settings.samples) * 1000);
    let over = |done: f64| is_over(arguments, &interrupted, started, done);
    exposure
        .accumulate(&mut renderer, &mut animation, settings.samples, over, |done| {
            bar.set_position((done * 1000.0) as u64);
            let rate = done / started.elapsed().as_secs_f64().max(1e-9);
            bar.set_message(format!("{}/{} samples, {rate:.2} samples/s", done as u32, settings.samples));
        })
        .map_err(of_motion)?;
    bar.finish_and_clear();
    let film = exposure.film().map_err(of_motion)?;
    let seconds = started.elapsed().as_secs_f64();
    write(arguments, &renderer, &scene, &settings, &film, &output)?;
    if film.non_finite() > 0 {
        eprintln!("warning: {} samples were not finite and were left out", film.non_finite());
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

/// Renders frames one after the other. Each is written once it is whole.
fn run_frames(
    arguments: &Arguments,
    frames: Frames,
    fps: f32,
    pattern: &Path,
    animation: &mut Animation,
) -> Result<u8, Failure> {
    let all: Vec<u32> = frames.numbers().collect();
    let there = |frame: &u32| arguments.skip_existing && frames::file(pattern, *frame).exists();
    let left: Vec<u32> = all.iter().copied().filter(|frame| !there(frame)).collect();
    let skipped = all.len() - left.len();
    let Some(&first) = left.first() else {
        eprintln!("all {} frames are there already", all.len());
        return Ok(DONE);
    };
    let interrupted = watch_interrupts()?;
    let mut renderer =
        Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let began = Instant::now();
    let bar = progress_bar(left.len() as u64 * 1000);
    let mut left_out = 0;
    let mut warned: Vec<String> = Vec::new();
    for (index, &frame) in left.iter().enumerate() {
        let scene = animation.at(Moment::of_frame(frame, fps)).map_err(|error| in_frame(frame, error.into()))?;
        for warning in scene.warnings.iter().filter(|warning| !warned.contains(&warning.message)) {
            bar.suspend(|| print_report(warning));
        }
        warned.extend(scene.warnings.iter().map(|warning| warning.message.clone()));
        let settings = arguments.settings(&scene)?;
        let exposure = Exposure::start(&mut renderer, &scene, &settings, arguments.shutter(&scene, fps));
        let mut exposure = exposure.map_err(|error| in_frame(frame, of_renderer(error)))?;
        if frame == first {
            tell_what_is_rendered(arguments, &renderer, &settings);
        }
        let started = Instant::now();
        let over = |done: f64| is_over(arguments, &interrupted, started, done);
        let told = exposure.accumulate(&mut renderer, animation, settings.samples, over, |done| {
            let share = done / f64::from(settings.samples);
            bar.set_position(((index as f64 + share) * 1000.0) as u64);
            let (number, count) = (index + 1, left.len());
            bar.set_message(format!("frame {frame} ({number}/{count}), {}/{} samples", done as u32, settings.samples));
        });
        told.map_err(|error| in_frame(frame, of_motion(error)))?;
        // What is half done is not written: its file would be taken for the frame.
        if interrupted.load(Ordering::SeqCst) {
            bar.finish_and_clear();
            let (wrote, more) = (counted(index), left.len() - index);
            eprintln!("interrupted: wrote {wrote}, {more} are left; go on with --skip-existing");
            return Ok(INTERRUPTED);
        }
        let film = exposure.film().map_err(|error| in_frame(frame, of_motion(error)))?;
        let output = frames::file(pattern, frame);
        let wrote = write(arguments, &renderer, &scene, &settings, &film, &output);
        wrote.map_err(|failure| in_frame(frame, failure))?;
        left_out += film.non_finite();
    }
    bar.finish_and_clear();
    if left_out > 0 {
        eprintln!("warning: {left_out} samples were not finite and were left out");
    }
    let there = if skipped > 0 { format!(", {skipped} were there") } else { String::new() };
    let (wrote, seconds) = (counted(left.len()), began.elapsed().as_secs_f64());
    eprintln!("wrote {wrote} to {} in {seconds:.1} s{there}", pattern.display());
    Ok(DONE)
}

fn counted(frames: usize) -> String {
    if frames == 1 { "1 frame".to_owned() } else { format!("{frames} frames") }
}

/// A failure that says in which frame.
fn in_frame(frame: u32, failure: Failure) -> Failure {
    match failure {
        Failure::Scene(error) => {
            eprintln!("frame {frame} cannot be rendered; what was written before it stays");
            Failure::Scene(error)
        }
        Failure::Interrupted => Failure::Interrupted,
        Failure::Usage(message) => Failure::Usage(format!("frame {frame}: {message}")),
        Failure::Other(message) => Failure::Other(format!("frame {frame}: {message}")),
    }
}

/// Whether a picture has to end as it is.
fn is_over(arguments: &Arguments, interrupted: &AtomicBool, started: Instant, done: f64) -> bool {
    let late = arguments.seconds.is_some_and(|seconds| started.elapsed().as_secs_f64() >= seconds);
    interrupted.load(Ordering::SeqCst) || late && done >= 1.0
}

fn tell_what_is_rendered(arguments: &Arguments, renderer: &Renderer, settings: &Settings) {
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

fn of_renderer(error: RenderError) -> Failure {
    match error {
        RenderError::Settings(message) => Failure::Usage(message),
        other => Failure::other(other),
    }
}

fn of_motion(error: MotionError) -> Failure {
    match error {
        MotionError::Scene(error) => error.into(),
        MotionError::Render(error) => of_renderer(error),
    }
}

/// What is rendered, in words.
fn described(settings: &Settings) -> String {
    let Settings { samples, bounces, mode, .. } = settings;
    match mode {
        Mode::Path => format!("{samples} samples, {bounces} bounces"),
        Mode::Variance => format!("mode {}, {samples} samples, {bounces} bounces", mode.name()),
        _ => format!("mode {}, {samples} samples", mode.name()),
    }
}
