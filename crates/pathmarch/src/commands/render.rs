//! `pathmarch render`: a scene to a picture.

use super::{BackendArgument, check_directory, listed, parse_size, progress_bar, watch_interrupts};
use crate::exit::{DONE, Failure, INTERRUPTED, print_report};
use crate::picture::{Rendered, accumulate};
use pathmarch_render::aov::Layer;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::{Caustics, Sampler, Scene};
use pathmarch_render::tonemap::{Display, Tonemap};
use pathmarch_render::{Job, MAX_BOUNCES, Mode, RenderError, Renderer, Settings};
use std::path::PathBuf;
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
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: Option<u32>,
    /// Stop after this many seconds, whatever is done by then; at least one sample is
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    seconds: Option<f64>,
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
    #[arg(long, value_name = "NAME", value_parser = one_of(Tonemap::ALL, Tonemap::name))]
    tonemap: Option<Tonemap>,
    /// Random numbers: sobol, or independent to compare with [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = one_of(Sampler::ALL, Sampler::name))]
    sampler: Option<Sampler>,
    /// Light through clear glass: traced, or fast, which is free of noise and biased [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = one_of(Caustics::ALL, Caustics::name))]
    caustics: Option<Caustics>,
    /// Largest radiance of a contribution of light that bounced, against fireflies; darkens [default: the scene's]
    #[arg(long, value_name = "RADIANCE", value_parser = parse_clamp)]
    clamp: Option<f32>,
    /// How near to a surface a ray ends, in pixels as seen: smaller shows finer detail, and costs steps [default: the scene's]
    #[arg(long, value_name = "PIXELS", value_parser = parse_detail)]
    detail: Option<f32>,
    /// Stops of exposure for PNG and JPEG [default: the camera's]
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
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

fn parse_seconds(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|seconds: &f64| *seconds > 0.0 && seconds.is_finite())
        .ok_or("expected a number above 0".to_owned())
}

fn parse_clamp(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|limit: &f32| *limit > 0.0 && limit.is_finite())
        .ok_or("expected a number above 0".to_owned())
}

fn parse_detail(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|pixels: &f32| (0.001..=10.0).contains(pixels))
        .ok_or("expected a number from 0.001 to 10".to_owned())
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
        })
    }

    fn output(&self) -> Result<PathBuf, Failure> {
        let output = match &self.output {
            Some(output) => output.clone(),
            None => PathBuf::from(self.scene.file_stem().unwrap_or_default()).with_extension("png"),
        };
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
    let scene = Scene::load(&arguments.scene)?;
    for warning in &scene.warnings {
        print_report(warning);
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
        "{}: {width}x{height}, {}, on {} ({})",
        arguments.scene.display(),
        described(&settings),
        renderer.backend_name(),
        renderer.adapter_name(),
    );
    let started = Instant::now();
    accumulate_and_tell(&mut job, &settings, arguments.seconds, &interrupted).map_err(Failure::other)?;
    let film = job.film().map_err(Failure::other)?;
    let seconds = started.elapsed().as_secs_f64();
    let camera = settings.camera_of(&scene);
    let display = settings.mode.display(Display {
        tonemap: arguments.tonemap.unwrap_or(scene.render.tonemap),
        exposure_stops: arguments.exposure.unwrap_or(camera.exposure),
    });
    let rendered = Rendered {
        scene: &scene,
        settings: &settings,
        film: &film,
        backend: renderer.backend_name(),
        adapter: renderer.adapter_name(),
    };
    let layers = arguments.aov.as_ref().map_or(&[][..], |Layers(layers)| layers);
    rendered.write(&output, &display, layers).map_err(Failure::Other)?;
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

/// What is rendered, in words.
fn described(settings: &Settings) -> String {
    let Settings { samples, bounces, mode, .. } = settings;
    match mode {
        Mode::Path => format!("{samples} samples, {bounces} bounces"),
        Mode::Variance => format!("mode {}, {samples} samples, {bounces} bounces", mode.name()),
        _ => format!("mode {}, {samples} samples", mode.name()),
    }
}

/// Renders until all samples are done, the time is over or an interrupt comes, and shows how far it is.
fn accumulate_and_tell(
    job: &mut Job,
    settings: &Settings,
    seconds: Option<f64>,
    interrupted: &AtomicBool,
) -> Result<(), RenderError> {
    // Thousandths of a sample, so that a sample that takes long is seen to move.
    let total = u64::from(settings.samples) * 1000;
    let bar = progress_bar(total);
    let started = Instant::now();
    let over = |done: f64| {
        let late = seconds.is_some_and(|seconds| started.elapsed().as_secs_f64() >= seconds);
        interrupted.load(Ordering::SeqCst) || late && done >= 1.0
    };
    accumulate(job, settings.samples, over, |done| {
        bar.set_position((done * 1000.0) as u64);
        let rate = done / started.elapsed().as_secs_f64().max(1e-9);
        bar.set_message(format!("{}/{} samples, {rate:.2} samples/s", done as u32, settings.samples));
    })?;
    bar.finish_and_clear();
    Ok(())
}
