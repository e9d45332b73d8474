//! `pathmarch-measure denoise`: time and error of denoised pictures.
//!
//! **Method.** Each scene is rendered once, with a number of samples or for some seconds, and denoised. Its samples and
//! its denoised picture are compared with a reference of the same size, whose own noise is subtracted
//! ([`crate::measure`]). Times exclude compilation and files. With `--cycles`, Cycles renders the same scene right after,
//! and denoises with Open Image Denoise.
//!
//! **Cost.** That of the references, if they are missing.

use crate::bench;
use crate::measure::{self, Interrupt, MAX_SAMPLES, Reference, ReferenceStore, make_directory};
use crate::peers::{Cycles, DescribedScene, Python};
use pathmarch_cli::{BackendArgument, DONE, Failure, catch_interrupts, outln, value_parsers};
use pathmarch_render::denoise::{Denoiser, Features, HalfBuffers};
use pathmarch_render::image::{self, Picture, Provenance};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Renderer, Settings};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Cells along the longest side of objects that become meshes for Cycles.
const CELLS: u32 = 256;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scenes to measure: scene files, or examples of the gallery by name
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Directory of references: your own NAME.exr for a scene, otherwise rendered ones
    #[arg(long, value_name = "DIR")]
    references: PathBuf,
    /// Render time of a missing reference
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    reference_seconds: f64,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: [u32; 2],
    /// Samples of each pixel
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = value_parsers::whole((1, MAX_SAMPLES)), allow_hyphen_values = true)]
    samples: u32,
    /// Sample for this long instead; denoising takes further time
    #[arg(long, value_name = "N", conflicts_with = "samples", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    seconds: Option<f64>,
    /// Random seed
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::whole((0, u32::MAX)), allow_hyphen_values = true)]
    seed: u32,
    /// Method: regression or oidn
    #[arg(long, value_name = "METHOD", default_value = Denoiser::default().name(), value_parser = parse_denoiser)]
    denoiser: Denoiser,
    /// Render backend
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Also render each scene with Cycles, with this many samples and Open Image Denoise
    #[arg(long, value_name = "SAMPLES", value_parser = value_parsers::whole((1, MAX_SAMPLES)), allow_hyphen_values = true)]
    cycles: Option<u32>,
    /// Python with the module bpy, or blender, for Cycles [default: python3]
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// Existing directory for pictures: before, after, reference
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

pub(crate) fn parse_denoiser(text: &str) -> Result<Denoiser, String> {
    let expected = || format!("expected one of {}", Denoiser::ALL.map(Denoiser::name).join(", "));
    Denoiser::from_name(text).ok_or_else(expected)
}

/// Measured picture.
struct Measured {
    before: Picture,
    after: Picture,
    samples: u32,
    /// Seconds of sampling, of features, and of the filter.
    seconds: [f64; 3],
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let interrupt = Interrupt(catch_interrupts()?);
    arguments.denoiser.check().map_err(Failure::other)?;
    let renderer = Renderer::open(arguments.backend.into(), arguments.adapter.as_deref()).map_err(Failure::other)?;
    let cycles = arguments.cycles.map(|samples| find_cycles(arguments, samples)).transpose()?;
    arguments.output.as_deref().map_or(Ok(()), make_directory)?;
    let references = ReferenceStore::new(arguments.references.clone(), arguments.reference_seconds)?;
    outln!("{:26} samples  seconds: sampling + features + filter = total   relMSE before -> after   mean", "scene");
    for path in &arguments.scenes {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let scene = load(path)?;
        let samples = arguments.seconds.map_or(arguments.samples, |_| MAX_SAMPLES);
        let settings = Settings { size: arguments.size, samples, seed: arguments.seed, ..Settings::of(&scene) };
        let reference = references.get(&name, &scene, &settings, &renderer, &interrupt)?;
        let measured = measure(arguments, &renderer, &scene, &settings, &interrupt)?;
        print_row(&name, &measured, &reference)?;
        if let Some((cycles, samples)) = &cycles {
            print_cycles(cycles, *samples, (&scene, &settings), &reference)?;
        }
        if let Some(directory) = &arguments.output {
            save_pictures(directory, &name, &scene, &measured, &reference)?;
        }
    }
    Ok(DONE)
}

/// Loads a scene file, or an example of the gallery.
fn load(path: &Path) -> Result<Scene, Failure> {
    match bench::built_in(&path.to_string_lossy()) {
        Some(text) if !path.is_file() => Ok(Scene::parse(&path.to_string_lossy(), &text)?),
        _ => Ok(Scene::load(path)?),
    }
}

fn measure(
    arguments: &Arguments,
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    interrupt: &Interrupt,
) -> Result<Measured, Failure> {
    let mut job = measure::start(renderer, scene, settings)?;
    let mut halves = HalfBuffers::new(settings);
    let started = Instant::now();
    let late = || arguments.seconds.is_some_and(|seconds| started.elapsed().as_secs_f64() >= seconds);
    let stop = |done: f64| interrupt.check().is_err() || late() && done >= 1.0;
    job.record(&mut halves, stop, |_| {}).map_err(Failure::other)?;
    interrupt.check()?;
    let sampled = started.elapsed().as_secs_f64();
    let samples = halves.samples();
    let features = Features::trace(scene, settings, samples).map_err(Failure::other)?;
    let traced = started.elapsed().as_secs_f64();
    let after = arguments.denoiser.denoise(&halves, &features).map_err(Failure::other)?;
    let filtered = started.elapsed().as_secs_f64();
    let seconds = [sampled, traced - sampled, filtered - traced];
    Ok(Measured { before: halves.film().mean(), after, samples, seconds })
}

fn print_row(name: &str, measured: &Measured, reference: &Reference) -> Result<(), Failure> {
    let [sampling, features, filter] = measured.seconds;
    outln!(
        "{name:26} {:7}  {sampling:.2} + {features:.2} + {filter:.2} = {:.2} s   {:.2e} -> {:.2e}   {:+.3} % -> {:+.3} %",
        measured.samples,
        sampling + features + filter,
        reference.error_of(&measured.before)?,
        reference.error_of(&measured.after)?,
        1e2 * reference.mean_difference(&measured.before),
        1e2 * reference.mean_difference(&measured.after),
    );
    Ok(())
}

fn find_cycles(arguments: &Arguments, samples: u32) -> Result<(Cycles, u32), Failure> {
    let cycles = Cycles::find(Python::new(arguments.python.as_deref()));
    let missing =
        || Failure::Other("--cycles needs a Python with bpy (pip install bpy==4.5.*): name it by --python".into());
    Ok((cycles.ok_or_else(missing)?, samples))
}

/// The same scene by Cycles, denoised.
fn print_cycles(
    cycles: &Cycles,
    samples: u32,
    (scene, settings): (&Scene, &Settings),
    reference: &Reference,
) -> Result<(), Failure> {
    let directory = tempfile::tempdir().map_err(Failure::other)?;
    let described = DescribedScene::write(scene, settings, CELLS, directory.path())?;
    for found in cycles.render(&described, settings.size, &[samples], 0, true, directory.path())? {
        outln!(
            "{:26} {:7}  {:.2} s   {:.2e}   {:+.3} %",
            format!("  Cycles {}", cycles.version()),
            found.samples,
            found.seconds,
            reference.error_of(&found.picture)?,
            1e2 * reference.mean_difference(&found.picture),
        );
    }
    Ok(())
}

fn save_pictures(
    directory: &Path,
    name: &str,
    scene: &Scene,
    measured: &Measured,
    reference: &Reference,
) -> Result<(), Failure> {
    let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
    let pictures = [("before", &measured.before), ("after", &measured.after), ("reference", &reference.picture)];
    for (part, picture) in pictures {
        let path = directory.join(format!("{name}-{part}.png"));
        image::save(&path, picture, &display, &Provenance::default()).map_err(Failure::other)?;
    }
    Ok(())
}
