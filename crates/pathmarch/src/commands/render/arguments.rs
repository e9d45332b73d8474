//! Arguments of `pathmarch render`, and the settings they stand for.

use crate::commands::listed;
use crate::frames::{self, FrameRange};
use pathmarch_cli::{BackendArgument, Failure, check_directory, value_parsers};
use pathmarch_render::aov::Layer;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::{Caustics, Sampler, Scene, settings};
use pathmarch_render::tonemap::Tonemap;
use pathmarch_render::{MAX_SPLITTING, Mode, Settings, Shutter};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    pub(super) scene: PathBuf,
    /// Picture to write: .png, .jpg or .exr [default: name of the scene with .png, in the current directory]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    pub(super) size: Option<[u32; 2]>,
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
    /// Exposure and tone mapping affect only path and preview.
    #[arg(long, value_name = "NAME", value_parser = named_value(Mode::ALL, Mode::name), verbatim_doc_comment)]
    pub(super) mode: Option<Mode>,
    /// Samples per pixel [default: the scene's; 16 in modes that trace no paths]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole(settings::SAMPLES), allow_hyphen_values = true)]
    pub(super) samples: Option<u32>,
    /// Stop after this many seconds, at most 86400, but not before the first sample is done
    #[arg(long, value_name = "N", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    pub(super) seconds: Option<f64>,
    /// Index of the first sample; sample ranges rendered separately add up to the whole
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, 2_000_000_000)), allow_hyphen_values = true)]
    pub(super) first_sample: u32,
    /// Scattering events after the first hit; 0 renders emitted and direct light only [default: the scene's]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole(settings::BOUNCES), allow_hyphen_values = true)]
    pub(super) bounces: Option<u32>,
    /// Random seed; pictures with different seeds have independent noise
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, u32::MAX)), allow_hyphen_values = true)]
    pub(super) seed: u32,
    /// Camera of the scene, by name [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(super) camera: Option<String>,
    /// Tone mapping of PNG and JPEG: agx, neutral or srgb [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = named_value(Tonemap::ALL, Tonemap::name))]
    pub(super) tonemap: Option<Tonemap>,
    /// Sampler: sobol, or independent for comparison [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = named_value(Sampler::ALL, Sampler::name))]
    pub(super) sampler: Option<Sampler>,
    /// Caustics through clear glass: traced, or fast (noise-free but biased) [default: the scene's]
    #[arg(long, value_name = "NAME", value_parser = named_value(Caustics::ALL, Caustics::name))]
    pub(super) caustics: Option<Caustics>,
    /// Clamp the radiance of indirect light to this: fewer fireflies, but darker [default: the scene's]
    #[arg(long, value_name = "RADIANCE", value_parser = value_parsers::number(settings::CLAMP), allow_hyphen_values = true)]
    pub(super) clamp: Option<f32>,
    /// Paths per camera ray, 1 to 8 [default: chosen for the fastest convergence]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, MAX_SPLITTING)), allow_hyphen_values = true)]
    pub(super) splitting: Option<u32>,
    /// Hit distance of a ray, in pixels: smaller shows finer detail and needs more steps [default: the scene's]
    #[arg(long, value_name = "PIXELS", value_parser = value_parsers::number(settings::DETAIL), allow_hyphen_values = true)]
    pub(super) detail: Option<f32>,
    /// Exposure of PNG and JPEG in stops, -100 to 100 [default: the camera's]
    #[arg(long, value_name = "EV", value_parser = value_parsers::number(settings::EXPOSURE), allow_hyphen_values = true)]
    pub(super) exposure: Option<f32>,
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
    pub(super) aov: Option<Layers>,
    /// Frames of an animation: one (7), a range (1-120), or every second frame (1-120x2)
    ///
    /// Formulas of the scene read the frame number as frame, and frame/fps as t. In the file name, # stands for the
    /// digits of the frame number: -o out/frame-####.png. Frames already written are kept if the program is interrupted.
    #[arg(long, value_name = "RANGE", value_parser = frames::parse, allow_hyphen_values = true, verbatim_doc_comment)]
    pub(super) frames: Option<FrameRange>,
    /// Skip frames whose file exists, to continue after an interruption
    #[arg(long, requires = "frames")]
    pub(super) skip_existing: bool,
    /// Frames per second [default: the scene's]
    #[arg(long, value_name = "N", value_parser = value_parsers::number(settings::FPS), allow_hyphen_values = true)]
    pub(super) fps: Option<f32>,
    /// Time of the picture: seconds since frame 0
    #[arg(long, value_name = "SECONDS", conflicts_with = "frames", value_parser = parse_time, allow_hyphen_values = true)]
    pub(super) time: Option<f64>,
    /// Fraction of the frame time that the shutter is open, 0 to 1: motion blur [default: the scene's]
    #[arg(long, value_name = "PART", value_parser = value_parsers::number(settings::SHUTTER), allow_hyphen_values = true)]
    pub(super) shutter: Option<f32>,
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

    pub(super) fn shutter(&self, scene: &Scene, fps: f32) -> Shutter {
        Shutter::open_for(scene, self.shutter.unwrap_or(scene.render.shutter), fps)
    }

    pub(super) fn output(&self) -> Result<PathBuf, Failure> {
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
