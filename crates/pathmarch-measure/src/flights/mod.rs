//! `pathmarch-measure flights`: error of reconstructed sequences against converged ones.
//!
//! **Idea.** Seven sequences of 48 frames at one sample of each pixel: one second in motion, one second at rest. Some
//! frames are compared with converged pictures of the same moment, before and after reconstruction.
//!
//! **Cost.** The references: about two minutes a flight on two cores by default.

mod compare;
mod denoised;
mod flight;

use crate::denoise::parse_denoiser;
use crate::measure::{Interrupt, make_directory};
use clap::ValueEnum;
use compare::{compare, difference, enlarged, relmse_of_short_histories, shown, temporal_error};
use flight::{FPS, FRAMES, Flight, MOVING_FRAMES};
use pathmarch_cli::{BackendArgument, DONE, Failure, catch_interrupts, outln, value_parsers};
use pathmarch_render::denoise::Denoiser;
use pathmarch_render::image::{self, Picture, Provenance};
use pathmarch_render::pathmarch_scene::{Animation, Moment, Scene};
use pathmarch_render::reconstruct::{Frame, ReconstructOptions, Sequence};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Renderer, Settings};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    /// Flights to measure: camera, object, melt, light, glass, fractal, lights, or scene files, whose camera turns by 20 degrees
    /// unless the scene moves by itself [default: all]
    #[arg(value_name = "FLIGHT", value_parser = flight::parse)]
    flights: Vec<Flight>,
    /// Backend of the flights; the references are of the CPU
    #[arg(long, value_enum, default_value = "cpu")]
    backend: BackendArgument,
    /// Directory for pictures of the compared frames: before, after, reference
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Directory where converged pictures are kept for the next run
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// Size of the samples
    #[arg(long, value_name = "WxH", default_value = "320x180", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: SizeArgument,
    /// Size of the pictures, at most twice that of the samples [default: that of the samples]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    shown_size: Option<SizeArgument>,
    /// Samples of the references
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = value_parsers::whole((1, 65_536)), allow_hyphen_values = true)]
    samples: u32,
    /// Compare every so many frames, and the last one
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = value_parsers::whole((1, FRAMES)), allow_hyphen_values = true)]
    every: u32,
    /// Leave stages of reconstruction out
    #[arg(long, value_name = "STAGE", value_enum)]
    without: Vec<Stage>,
    /// Let pixels share light at rest, as live pictures on the CPU do where that pays
    #[arg(long)]
    path_reuse: bool,
    /// Denoise the samples of the compared frames by a method for final frames as well: regression or oidn
    #[arg(long, value_name = "METHOD", value_parser = parse_denoiser, conflicts_with_all = ["shown_size", "denoise"])]
    beside: Option<Denoiser>,
    /// Measure final frames of this many samples instead, denoised one by one and joined
    #[arg(long, value_name = "SAMPLES", value_parser = value_parsers::whole((2, 65_536)), allow_hyphen_values = true)]
    denoise: Option<u32>,
    /// Frames in motion of which --denoise measures every one
    #[arg(long, value_name = "RANGE", default_value = "9-16", value_parser = denoised::parse_range)]
    frames: denoised::Range,
    /// Rest after this many frames of motion, for --denoise
    #[arg(long, value_name = "N", default_value_t = MOVING_FRAMES, value_parser = value_parsers::whole((0, MOVING_FRAMES)), allow_hyphen_values = true)]
    rest_after: u32,
}

type SizeArgument = [u32; 2];

/// Stage of reconstruction that can be left out.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Stage {
    Reprojection,
    FireflyFilter,
    SpatialFilter,
    EmitterEdges,
    TextureFilter,
    Antialiasing,
}

/// All stages of reconstruction without these.
fn options(without: &[Stage]) -> ReconstructOptions {
    let has = |stage: Stage| !without.contains(&stage);
    ReconstructOptions {
        reprojection: has(Stage::Reprojection),
        firefly_filter: has(Stage::FireflyFilter),
        spatial_filter: has(Stage::SpatialFilter),
        emitter_edges: has(Stage::EmitterEdges),
        texture_filter: has(Stage::TextureFilter),
        antialiasing: has(Stage::Antialiasing),
        ..ReconstructOptions::default()
    }
}

/// Seed of all frames in motion.
const MOVING_SEED: u32 = 77;

/// Flight with its scene, settings and references.
struct Course<'a> {
    flight: &'a Flight,
    arguments: &'a Arguments,
    animation: Animation,
    still: Arc<Scene>,
    renderer: Renderer,
    /// Renderer of the references.
    cpu: Renderer,
}

impl<'a> Course<'a> {
    fn new(flight: &'a Flight, arguments: &'a Arguments) -> Result<Self, Failure> {
        let mut animation = flight.animation()?;
        let still = animation.at(Moment::of_frame(0, FPS)).map(Arc::new)?;
        let renderer = Renderer::open(arguments.backend.into(), None).map_err(Failure::other)?;
        let cpu = Renderer::open(Backend::Cpu, None).map_err(Failure::other)?;
        Ok(Self { flight, arguments, animation, still, renderer, cpu })
    }

    /// Scene of a frame; `last` if it has not changed since.
    fn scene(&mut self, frame: u32, last: &Arc<Scene>) -> Result<Arc<Scene>, Failure> {
        if !self.still.animated || frame > MOVING_FRAMES {
            return Ok(last.clone());
        }
        Ok(self.animation.at(Moment::of_frame(frame, FPS)).map(Arc::new)?)
    }

    /// Settings of a frame: the next sample of a sequence while moving, one more of a film in each frame at rest.
    fn settings(&self, scene: &Scene, frame: u32) -> Settings {
        let viewpoint = Some(self.flight.camera(scene, frame));
        let (seed, first_sample, samples) = match frame.checked_sub(MOVING_FRAMES) {
            None => (MOVING_SEED, frame, 1),
            Some(resting) => (MOVING_FRAMES, 0, 1 + resting),
        };
        let path_reuse = (self.arguments.path_reuse && frame >= MOVING_FRAMES).then_some(true);
        Settings {
            size: self.arguments.size,
            samples,
            seed,
            first_sample,
            viewpoint,
            path_reuse,
            ..Settings::of(scene)
        }
    }

    /// Size of the pictures.
    fn shown_size(&self) -> [u32; 2] {
        self.arguments.shown_size.unwrap_or(self.arguments.size)
    }

    /// Converged picture of a frame, kept in the directory for references if there is one.
    fn reference(&self, scene: &Scene, frame: u32) -> Result<Picture, Failure> {
        let frame = frame.min(MOVING_FRAMES);
        let (Arguments { samples, references, .. }, size) = (self.arguments, self.shown_size());
        let [width, height] = size;
        let name = format!("{}-{frame:02}-{width}x{height}-{samples}.exr", self.flight.name);
        let path = references.as_ref().map(|directory| directory.join(name));
        if let Some(path) = path.as_ref().filter(|path| path.exists()) {
            return image::load(path).map(|loaded| loaded.picture).map_err(Failure::other);
        }
        let many = Settings {
            samples: *samples,
            first_sample: 0,
            seed: 1000 + frame,
            size,
            path_reuse: None,
            ..self.settings(scene, frame)
        };
        let picture = self.cpu.render(scene, &many).map_err(Failure::other)?.mean();
        if let Some(path) = &path {
            image::save(path, &picture, &Display::default(), &Provenance::default()).map_err(Failure::other)?;
        }
        Ok(picture)
    }

    /// Samples of a frame, denoised as a final frame.
    fn denoised(&self, scene: &Scene, frame: u32, denoiser: Denoiser) -> Result<Picture, Failure> {
        let settings = self.settings(scene, frame);
        let settings = Settings {
            splitting: Some(1),
            light_samples: Some(1),
            indirect_samples: Some(1),
            path_reuse: settings.path_reuse.or(Some(false)),
            emitter_edges: Some(false),
            ..settings
        };
        let [_, clean] = denoised::final_frame(&self.renderer, scene, &settings, denoiser)?;
        Ok(clean)
    }

    fn save(&self, frame: u32, pictures: [(&str, &Picture); 3], display: &Display) -> Result<(), Failure> {
        let Some(directory) = &self.arguments.output else { return Ok(()) };
        for (part, picture) in pictures {
            let path = directory.join(format!("{}-{:02}-{part}.png", self.flight.name, frame + 1));
            image::save(&path, picture, display, &Provenance::default()).map_err(Failure::other)?;
        }
        Ok(())
    }
}

/// Median and minimum of times in seconds, as text in milliseconds.
fn milliseconds(seconds: &[f64]) -> String {
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |index: usize| sorted.get(index).copied().unwrap_or_default() * 1e3;
    format!("{:.1} ({:.1})", at(sorted.len() / 2), at(0))
}

fn fly(flight: &Flight, arguments: &Arguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let mut course = Course::new(flight, arguments)?;
    let mut sequence = Sequence::new(&course.renderer, options(&arguments.without));
    let (mut flicker, mut times) = (Vec::new(), [Vec::new(), Vec::new()]);
    let mut passes = BTreeMap::new();
    let mut last: Option<Frame> = None;
    let mut scene = course.still.clone();
    for number in 0..FRAMES {
        interrupt.check()?;
        let before = scene.clone();
        scene = course.scene(number, &scene)?;
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
        let frame = sequence
            .render_upscaled(&scene, &course.settings(&scene, number), course.shown_size())
            .map_err(Failure::other)?;
        for (times, seconds) in times.iter_mut().zip([frame.trace_seconds, frame.reconstruct_seconds]) {
            times.push(seconds);
        }
        for pass in &frame.passes {
            passes.entry(pass.name).or_insert_with(Vec::new).push(pass.seconds);
        }
        if let Some(last) = last.as_ref().filter(|_| number > MOVING_FRAMES + 4) {
            flicker.push(difference(&shown(&frame.reconstructed, &display), &shown(&last.reconstructed, &display)));
        }
        if (number + 1) % arguments.every == 0 || number + 1 == FRAMES {
            let reference = course.reference(&scene, number)?;
            let noisy = enlarged(&frame.noisy, course.shown_size());
            let mut row = compare(number, [&noisy, &frame.reconstructed], &reference, &display)?;
            let is_enlarged = course.shown_size() != arguments.size;
            if !is_enlarged {
                row.short_history = relmse_of_short_histories(&frame, &reference)?;
            }
            if let Some(last) = last.as_ref().filter(|_| number <= MOVING_FRAMES && !is_enlarged) {
                let before = course.reference(&before, number - 1)?;
                let pictures = [&frame.reconstructed, &last.reconstructed, &reference, &before];
                let [a, b, c, d] = pictures.map(|picture| shown(picture, &display));
                row.temporal = Some(temporal_error([&a, &b, &c, &d], &frame.motion));
            }
            row.print(&flight.name);
            if let Some(denoiser) = arguments.beside {
                let denoised = course.denoised(&scene, number, denoiser)?;
                let row = compare(number, [&frame.noisy, &denoised], &reference, &display)?;
                row.print(denoiser.name());
            }
            let pictures = [("before", &noisy), ("after", &frame.reconstructed), ("reference", &reference)];
            course.save(number, pictures, &display)?;
        }
        last = Some(frame);
    }
    let [trace, reconstruct] = times.map(|seconds| milliseconds(&seconds));
    let flicker = flicker.iter().sum::<f64>() / flicker.len().max(1) as f64;
    outln!(
        "{:8} milliseconds a frame, median (least): tracing {trace}, reconstruction {reconstruct}; flicker at rest {flicker:.5}",
        flight.name
    );
    let passes: Vec<String> =
        passes.iter().map(|(name, seconds)| format!("{name} {}", milliseconds(seconds))).collect();
    outln!("{:8} milliseconds a pass: {}", flight.name, passes.join(", "));
    Ok(())
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let interrupt = Interrupt(catch_interrupts()?);
    for directory in arguments.output.iter().chain(&arguments.references) {
        make_directory(directory)?;
    }
    let all = if arguments.flights.is_empty() { flight::built_in() } else { arguments.flights.clone() };
    for flight in &all {
        match arguments.denoise {
            Some(samples) => denoised::fly(flight, arguments, samples, &interrupt)?,
            None => fly(flight, arguments, &interrupt)?,
        }
    }
    Ok(DONE)
}
