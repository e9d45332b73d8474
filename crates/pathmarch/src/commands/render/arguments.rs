//! Arguments of `pathmarch render`, and the settings they stand for.

use super::default_output;
use super::output::Output;
use crate::commands::listed;
use crate::film_notes::is_film;
use crate::frames::{self, FrameRange};
use crate::video;
use pathmarch_cli::{BackendArgument, Failure, RenderOptions, value_parsers};
use pathmarch_render::aov::Layer;
use pathmarch_render::denoise::Denoiser;
use pathmarch_render::exposure::camera_stops;
use pathmarch_render::film::Film;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::parts::Rect;
use pathmarch_render::pathmarch_scene::{Camera, RenderSettings, Scene, settings};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{
    MAX_INDIRECT_SAMPLES, MAX_LIGHT_PATHS, MAX_LIGHT_SAMPLES, MAX_NOISE, MAX_SPLITTING, MIN_NOISE, Mode, PreviewStep,
    Settings, Shutter,
};
use std::path::{Path, PathBuf};

/// Exposure of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Exposure {
    /// The one that suits the picture.
    Auto,
    /// In stops.
    Stops(f32),
}

fn parse_exposure(text: &str) -> Result<Exposure, String> {
    if text.trim() == "auto" {
        return Ok(Exposure::Auto);
    }
    value_parsers::number(settings::EXPOSURE)(text).map(Exposure::Stops).map_err(|error| format!("{error}, or auto"))
}

fn parse_switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("use on or off".to_owned()),
    }
}

#[derive(Clone, clap::Args)]
pub struct Arguments {
    /// Scene files; - for standard input, or the name of an example of the gallery
    #[arg(required = true, value_name = "SCENE")]
    pub(super) scenes: Vec<PathBuf>,
    /// Picture to write: .png, .jpg or .exr; with --frames also .mp4, .webm, .gif or .apng; .film for a part to be merged; - for a PNG on standard output; a directory for
    /// several scenes [default: name of the scene with .png, in the current directory]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) render: RenderOptions,
    /// Quantity to render [default: path]
    #[arg(long, value_name = "NAME", value_parser = named_value(Mode::ALL, Mode::name), long_help = mode_help())]
    pub(super) mode: Option<Mode>,
    /// Steps to leave out of --mode preview, such as shadows,occlusion
    #[arg(long, value_name = "STEPS", value_delimiter = ',', value_parser = named_value(PreviewStep::ALL, PreviewStep::name), long_help = preview_help())]
    pub(super) preview_without: Vec<PreviewStep>,
    /// Stop after this many seconds, at most 86400, but not before the first sample is done
    #[arg(long, value_name = "N", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    pub(super) seconds: Option<f64>,
    /// Give each tile of 32x32 pixels the samples that it needs for this relative error, 0.0001 to 1
    ///
    /// The error is the root of the relMSE that compare prints. A pilot of 32 samples, which are no part of the picture, decides
    /// the number of samples, so that the picture is not biased. --samples is the largest number [default: 16384]. The layer
    /// sampleCount of --aov shows how many there are. With --denoise, the error is that of the picture before it is filtered.
    #[arg(long, value_name = "ERROR", value_parser = parse_noise, allow_hyphen_values = true, verbatim_doc_comment)]
    pub(super) noise: Option<f32>,
    /// Index of the first sample; sample ranges rendered separately add up to the whole
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, 2_000_000_000)), allow_hyphen_values = true)]
    pub(super) first_sample: u32,
    /// Random seed; pictures with different seeds have independent noise
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, u32::MAX)), allow_hyphen_values = true)]
    pub(super) seed: u32,
    /// Camera of the scene, by name [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
    /// Paths per camera ray, 1 to 8 [default: chosen for the fastest convergence]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, MAX_SPLITTING)), allow_hyphen_values = true)]
    pub(super) splitting: Option<u32>,
    /// Light samples at the first surface of a path, 1 to 8 [default: chosen for the fastest convergence]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, MAX_LIGHT_SAMPLES)), allow_hyphen_values = true)]
    pub(super) light_samples: Option<u32>,
    /// Rays that leave the first surface of a path, 1 to 8 [default: chosen for the fastest convergence]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, MAX_INDIRECT_SAMPLES)), allow_hyphen_values = true)]
    pub(super) indirect_samples: Option<u32>,
    /// Light paths of each sample of traced caustics, 1 to 1048576 [default: chosen for the fastest convergence]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, MAX_LIGHT_PATHS)), allow_hyphen_values = true)]
    pub(super) light_paths: Option<u32>,
    /// Pixels share light that their paths find: on or off [default: on where the picture then converges sooner]
    #[arg(long, value_name = "on|off", value_parser = parse_switch)]
    pub(super) path_reuse: Option<bool>,
    /// More camera rays at the edges of visible lamps: on or off [default: on from a million samples, summed over pixels]
    #[arg(long, value_name = "on|off", value_parser = parse_switch)]
    pub(super) emitter_edges: Option<bool>,
    /// Exposure of PNG and JPEG in stops, -100 to 100; or auto, which suits the picture [default: the camera's]
    #[arg(long, value_name = "EV", value_parser = parse_exposure, allow_hyphen_values = true)]
    pub(super) exposure: Option<Exposure>,
    /// Write noise-free layers beside R, G and B; .exr only [default: all; or a list such as albedo,normal]
    #[arg(long, value_name = "LAYERS", num_args = 0..=1, default_missing_value = "all", value_parser = parse_layers, long_help = layer_help())]
    pub(super) aov: Option<Layers>,
    /// Filter the noise out of the picture [default method: regression; or oidn]
    #[arg(long, value_name = "METHOD", num_args = 0..=1, default_missing_value = Denoiser::default().name(), value_parser = parse_denoiser, long_help = denoiser_help())]
    pub(super) denoise: Option<Denoiser>,
    /// Average each denoised frame with the one before, along the motion: on or off [default: on, with regression]
    ///
    /// So the rest of the noise does not flicker. The first frame of a run has none before it, nor has one after frames that
    /// --skip-existing skips: a sequence in parts changes a little where a part starts. Only for --denoise regression.
    #[arg(long, value_name = "on|off", requires = "denoise", requires = "frames", value_parser = parse_switch, verbatim_doc_comment)]
    pub(super) denoise_temporal: Option<bool>,
    /// Frames of an animation: one (7), a range (1-120), or every second frame (1-120x2)
    ///
    /// Formulas of the scene read the frame number as frame, and frame/fps as t. In the file name, # stands for the
    /// digits of the frame number: -o out/frame-####.png. Frames already written are kept if the program is interrupted.
    #[arg(long, value_name = "RANGE", value_parser = frames::parse, allow_hyphen_values = true, verbatim_doc_comment)]
    pub(super) frames: Option<FrameRange>,
    /// Frames to render at the same time, 1 to 64; each needs the memory of one picture
    #[arg(long, value_name = "N", requires = "frames", default_value_t = 1, value_parser = parse_parallel, allow_hyphen_values = true)]
    pub(super) parallel: usize,
    /// Skip frames whose file exists and is whole, to continue after an interruption
    #[arg(long, requires = "frames")]
    pub(super) skip_existing: bool,
    /// Time of the picture: seconds since frame 0
    #[arg(long, value_name = "SECONDS", conflicts_with = "frames", value_parser = parse_time, allow_hyphen_values = true)]
    pub(super) time: Option<f64>,
    /// Continue from the checkpoint that an interrupted render left beside its output
    #[arg(long)]
    pub(super) resume: bool,
    /// Rectangle of pixels to render: width, height, left column and top row, as in 640x360+0+360
    #[arg(long, value_name = "WxH+X+Y", value_parser = parse_crop)]
    pub(super) crop: Option<Rect>,
    /// Allow the scene to read files outside its folder
    #[arg(long)]
    pub(super) allow_files: bool,
    /// Print progress as lines of JSON on standard output
    #[arg(long)]
    pub(super) json: bool,
    /// Render backend
    #[arg(long, value_enum, default_value = "auto")]
    pub(super) backend: BackendArgument,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Write the GPU kernel of the picture as commented WGSL, and render nothing
    #[arg(long, value_name = "FILE", conflicts_with_all = ["frames", "output"])]
    pub(super) dump_wgsl: Option<PathBuf>,
}

fn parse_parallel(text: &str) -> Result<usize, String> {
    let number = text.trim().parse().ok().filter(|number| (1..=64).contains(number));
    number.ok_or_else(|| "must be a whole number from 1 to 64".to_owned())
}

fn parse_noise(text: &str) -> Result<f32, String> {
    let noise = text.trim().parse().ok().filter(|noise| (MIN_NOISE..=MAX_NOISE).contains(noise));
    noise.ok_or_else(|| format!("must be a relative error from {MIN_NOISE} to {MAX_NOISE}, such as 0.01"))
}

/// Parses a rectangle such as `640x360+0+360`.
fn parse_crop(text: &str) -> Result<Rect, String> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let parse = || {
        let (size, place) = text.split_once('+')?;
        let (width, height) = size.split_once(['x', 'X', '×'])?;
        let (x, y) = place.split_once('+')?;
        Some(Rect { x: number(x)?, y: number(y)?, width: number(width)?, height: number(height)? })
    };
    parse()
        .filter(|rect| rect.pixels() > 0)
        .ok_or_else(|| "expected WIDTHxHEIGHT+X+Y in pixels, such as 640x360+0+360".to_owned())
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

/// Help of `--preview-without`: all steps with their documentation.
fn preview_help() -> String {
    let steps = PreviewStep::ALL.map(|step| format!("{}: {}", step.name(), step.doc()));
    format!("Steps to leave out of --mode preview, such as shadows,occlusion\n\n{}", steps.join("\n"))
}

/// Help of `--mode`: all modes with their documentation.
fn mode_help() -> String {
    let modes = Mode::ALL.map(|mode| format!("{}: {}", mode.name(), mode.doc()));
    format!(
        "Quantity to render [default: {}]\n\n{}\nExposure and tone mapping affect only path and preview.",
        Mode::default().name(),
        modes.join("\n")
    )
}

/// Help of `--aov`: all layers with their channels and documentation.
fn layer_help() -> String {
    let layers = Layer::ALL.map(|layer| {
        let parts: Vec<String> = layer.parts().iter().map(|part| format!(".{part}")).collect();
        format!("{}{}: {}", layer.name(), parts.join(" "), layer.doc())
    });
    format!(
        "Write noise-free layers beside R, G and B; .exr only [default: all; or a list such as albedo,normal]\n\n{}",
        layers.join("\n")
    )
}

/// Help of `--denoise`: all methods with their documentation.
fn denoiser_help() -> String {
    let methods = Denoiser::ALL.map(|denoiser| format!("{}: {}", denoiser.name(), denoiser.doc()));
    format!(
        "Filter the noise out of the picture [default method: {}]\n\n{}\nThe filter runs after the last sample, and \
         --seconds does not include it. With --aov, the layer noisy is the picture before. Only for --mode path.",
        Denoiser::default().name(),
        methods.join("\n")
    )
}

fn parse_denoiser(text: &str) -> Result<Denoiser, String> {
    Denoiser::from_name(text).ok_or_else(|| {
        let names = Denoiser::ALL.map(Denoiser::name).join(" or ");
        format!("unknown method \"{text}\"; expected {names}; the scene comes before --denoise")
    })
}

/// Largest number of samples of a pixel with `--noise`, if no other is given.
const MOST_SAMPLES: u32 = 16_384;

/// Largest time of an animation, seconds.
const MAX_TIME: f64 = 1e9;

fn parse_time(text: &str) -> Result<f64, String> {
    let seconds = text.trim().parse().ok().filter(|seconds: &f64| (0.0..=MAX_TIME).contains(seconds));
    seconds.ok_or_else(|| format!("must be a number of seconds from 0 to {MAX_TIME}"))
}

/// Layers of `--aov`.
#[derive(Clone)]
pub(super) struct Layers(pub(super) Vec<Layer>);

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
    pub(super) fn settings(&self, scene: &Scene) -> Result<Settings, Failure> {
        let render = self.render_settings(scene);
        let mode = self.mode.unwrap_or_default();
        let camera = match &self.camera {
            None => 0,
            Some(name) => scene.cameras.iter().position(|camera| camera.name == *name).ok_or_else(|| {
                let names = listed(scene.cameras.iter().map(|camera| camera.name.as_str()));
                Failure::Usage(format!("the scene has no camera \"{name}\"; it has {names}"))
            })?,
        };
        let mut settings = Settings::from(&render);
        if !self.render.overrides("samples") {
            settings.samples = if self.noise.is_some() { MOST_SAMPLES } else { mode.samples(settings.samples) };
        }
        if mode != Mode::Preview && !self.preview_without.is_empty() {
            return Err(Failure::Usage("--preview-without needs --mode preview".to_owned()));
        }
        for step in &self.preview_without {
            settings.preview_steps.set(*step, false);
        }
        let (first_sample, seed, splitting, crop) = (self.first_sample, self.seed, self.splitting, self.crop);
        let whole = Settings {
            first_sample,
            seed,
            camera,
            mode,
            splitting,
            light_samples: self.light_samples,
            indirect_samples: self.indirect_samples,
            light_paths: self.light_paths,
            path_reuse: self.path_reuse,
            emitter_edges: self.emitter_edges,
            crop,
            ..settings
        };
        let Some(range) = self.render.sample_range() else { return Ok(whole) };
        Ok(Settings {
            first_sample: range.start,
            whole_samples: Some(whole.samples.max(range.end)),
            samples: range.end - range.start,
            ..whole
        })
    }

    /// Render settings of the scene with those of the command line.
    pub(super) fn render_settings(&self, scene: &Scene) -> RenderSettings {
        let mut render = scene.render.clone();
        self.render.apply(&mut render);
        render
    }

    /// Checks that `--denoise` suits the mode, and that the method is available.
    pub(super) fn check_denoiser(&self) -> Result<(), Failure> {
        let Some(denoiser) = self.denoise else { return Ok(()) };
        let mode = self.mode.unwrap_or_default();
        if mode != Mode::Path {
            return Err(Failure::Usage(format!(
                "--denoise: only pictures of --mode path can be denoised, not those of --mode {}",
                mode.name()
            )));
        }
        if denoiser != Denoiser::Regression && self.denoise_temporal == Some(true) {
            return Err(Failure::Usage(format!(
                "--denoise-temporal: only frames of --denoise {} can be averaged, not those of {}",
                Denoiser::Regression.name(),
                denoiser.name()
            )));
        }
        denoiser.check().map_err(Failure::other)
    }

    /// True if denoised frames are averaged with those before.
    pub(super) fn joins_frames(&self) -> bool {
        self.denoise == Some(Denoiser::Regression) && self.frames.is_some() && self.denoise_temporal != Some(false)
    }

    pub(super) fn shutter(&self, scene: &Scene, fps: f32) -> Shutter {
        Shutter::open_for(scene, self.render_settings(scene).shutter, fps)
    }

    /// Name of the first scene, for messages.
    pub(super) fn scene_name(&self) -> String {
        self.scenes.first().map_or_else(String::new, |scene| scene.display().to_string())
    }

    /// True if the exposure follows the picture.
    pub(super) fn has_auto_exposure(&self, scene: &Scene, settings: &Settings) -> bool {
        match self.exposure {
            Some(exposure) => exposure == Exposure::Auto,
            None => settings.camera_of(scene).auto_exposure,
        }
    }

    /// Tone curve and exposure of a film; without a film, an automatic exposure is 0.
    pub(super) fn display(&self, scene: &Scene, settings: &Settings, film: Option<&Film>) -> Display {
        let camera = settings.camera_of(scene);
        let camera = match self.exposure {
            Some(Exposure::Stops(exposure)) => Camera { exposure, auto_exposure: false, ..camera.clone() },
            Some(Exposure::Auto) => Camera { exposure: 0.0, auto_exposure: true, ..camera.clone() },
            None => camera.clone(),
        };
        Display { tonemap: self.render_settings(scene).tonemap, exposure_stops: camera_stops(&camera, film) }
    }

    /// Checks arguments that exclude each other.
    pub(super) fn check(&self) -> Result<(), Failure> {
        self.check_denoiser()?;
        let refuse = |message: &str| Err(Failure::Usage(message.to_owned()));
        if self.first_sample > 0 && self.render.sample_range().is_some() {
            return refuse("--first-sample and a range of --samples exclude each other; use --samples A..B");
        }
        if self.denoise.is_some() && (self.crop.is_some() || self.output.as_ref().is_some_and(|output| is_film(output)))
        {
            return refuse("--denoise needs the whole picture; it excludes --crop and .film");
        }
        if self.noise.is_some() {
            let film = self.output.as_ref().is_some_and(|output| is_film(output));
            let excluded = [
                (self.mode.is_some_and(|mode| mode != Mode::Path), "--mode"),
                (self.first_sample > 0, "--first-sample"),
                (self.render.sample_range().is_some(), "a range of --samples"),
                (self.splitting.is_some(), "--splitting"),
                (self.light_samples.is_some(), "--light-samples"),
                (self.indirect_samples.is_some(), "--indirect-samples"),
                (self.path_reuse.is_some(), "--path-reuse"),
                (self.emitter_edges.is_some(), "--emitter-edges"),
                (film, "a .film"),
            ];
            if let Some((_, name)) = excluded.into_iter().find(|(given, _)| *given) {
                return refuse(&format!("--noise and {name} exclude each other"));
            }
        }
        if self.aov.is_some() && self.crop.is_some() {
            return refuse("--aov and --crop exclude each other");
        }
        if self.json && self.output.as_deref() == Some(Path::new("-")) {
            return refuse("--json and -o - both write to standard output");
        }
        Ok(())
    }

    /// Output of each scene.
    pub(super) fn outputs(&self) -> Result<Vec<PathBuf>, Failure> {
        let has_frames = self.frames.is_some();
        let outputs: Vec<PathBuf> = match &self.output {
            Some(directory) if directory.is_dir() && self.scenes.len() > 1 => {
                self.scenes.iter().map(|scene| directory.join(default_output(scene, has_frames))).collect()
            }
            Some(output) if self.scenes.len() == 1 => vec![output.clone()],
            Some(output) => {
                let message = format!("{} is not a directory; -o must name one for several scenes", output.display());
                return Err(Failure::Usage(message));
            }
            None => self.scenes.iter().map(|scene| default_output(scene, has_frames)).collect(),
        };
        for (index, output) in outputs.iter().enumerate() {
            if outputs[..index].contains(output) {
                return Err(Failure::Usage(format!(
                    "two scenes would be written to {}; render them one by one",
                    output.display()
                )));
            }
            self.check_output(output)?;
        }
        Ok(outputs)
    }

    fn check_output(&self, output: &Path) -> Result<(), Failure> {
        if video::is_video(output) {
            if self.frames.is_none() {
                return Err(Failure::Usage(format!(
                    "{}: a video needs --frames, as in --frames 1-120",
                    output.display()
                )));
            }
            video::check(output)?;
            return pathmarch_cli::check_output(output);
        }
        if let Some(frames) = self.frames {
            frames::check_pattern(output, frames).map_err(Failure::Usage)?;
        }
        let kind = Output::of(output)?;
        if self.aov.is_some() && ImageFormat::from_path(output).ok() != Some(ImageFormat::Exr) {
            return Err(Failure::Usage(format!(
                "--aov: {} cannot store layers, only OpenEXR can; use -o {}",
                output.display(),
                output.with_extension("exr").display()
            )));
        }
        if self.dump_wgsl.is_some() { Ok(()) } else { kind.check() }
    }
}
