//! `pathmarch-measure flights`: error of reconstructed sequences against converged ones.
//!
//! **Idea.** Six sequences of 48 frames at one sample of each pixel: one second in motion, one second at rest. Some
//! frames are compared with converged pictures of the same moment, before and after reconstruction.
//!
//! **Cost.** The references: about two minutes a flight on two cores by default.

use crate::bench;
use crate::measure::Interrupt;
use pathmarch_cli::{DONE, Failure, catch_interrupts, outln, value_parsers};
use pathmarch_render::image::{self, Picture, PictureKind, Provenance};
use pathmarch_render::metrics::{self, block_means};
use pathmarch_render::pathmarch_scene::{Camera, Moment, Scene};
use pathmarch_render::reconstruct::{Frame, ReconstructOptions, Sequence};
use pathmarch_render::tonemap::{Display, srgb_decode};
use pathmarch_render::{Backend, Renderer, Settings};
use std::path::PathBuf;
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    /// Flights to measure [default: all]
    #[arg(value_name = "NAME", value_parser = parse_name)]
    names: Vec<&'static str>,
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
}

type SizeArgument = [u32; 2];

/// Frames of a flight.
const FRAMES: u32 = 48;
/// Frames in motion; the others show one second at rest.
const MOVING_FRAMES: u32 = 24;
const FPS: f32 = 24.0;

/// Sequence to reconstruct.
struct Flight {
    name: &'static str,
    /// Built-in scene, or the text of a scene.
    scene: Source,
    /// Degrees by which the camera turns about its target in the whole flight.
    turn: f32,
}

enum Source {
    BuiltIn(&'static str),
    Text(&'static str),
}

/// Ball that rolls over a checker.
const MOVING_OBJECT: &str = r#"pathmarch 1
camera { position 0 1.6 4; target 0 0.4 0 }
render { bounces 3 }
sky "gradient" { zenith 0.3 0.45 0.7; horizon 0.8 0.85 0.9 }
sun { direction 1 2 1; irradiance 2; angle 3 }
material "checker" { diffuse { checker size=0.4 { colour 0.1; colour 0.8 } } }
material "red" { diffuse 0.7 0.15 0.1 }
object "ground" material="checker" { plane }
object "ball" material="red" { sphere 0.5 { at "1.6*min(t, 1.5) - 1.2" 0.5 0 } }
object "block" material="red" { box 0.5 1.2 0.5 { at 0 0.6 -1 } }
"#;

/// Room whose lamp dims to a twentieth after half a second.
const SWITCHED_LIGHT: &str = r#"pathmarch 1
camera { position 0 1 5.15; target 0 0.99 0; fov 27.2 }
render { bounces 4 }
param power "8 - 7.6*step(0.5, t)"
material "white" { diffuse 0.74 }
material "red" { diffuse 0.62 0.06 0.04 }
material "lamp" { emit power }
object "floor" material="white" { rect 3.4 2.4 }
object "ceiling" material="white" { rect 3.4 2.4 { normal 0 -1 0; at 0 2 0 } }
object "back wall" material="white" { rect 3.4 2 { rotate 90 0 0; at 0 1 -1.2 } }
object "left wall" material="red" { box 0.1 2 2.4 { at -1.75 1 0 } }
object "right wall" material="white" { box 0.1 2 2.4 { at 1.75 1 0 } }
object "tall box" material="white" { box 0.62 1.25 0.62 { rotate 0 43 0; at -0.62 0.625 -0.38 } }
object "lamp" material="lamp" { rect 1.3 0.9 { normal 0 -1 0; at 0 1.995 -0.1 } }
"#;

const FLIGHTS: [Flight; 6] = [
    Flight { name: "camera", scene: Source::BuiltIn("cornell"), turn: 12.0 },
    Flight { name: "object", scene: Source::Text(MOVING_OBJECT), turn: 0.0 },
    Flight { name: "light", scene: Source::Text(SWITCHED_LIGHT), turn: 0.0 },
    Flight { name: "glass", scene: Source::BuiltIn("glass-still-life"), turn: 20.0 },
    Flight { name: "fractal", scene: Source::BuiltIn("mandelbulb"), turn: 30.0 },
    Flight { name: "lights", scene: Source::BuiltIn("many-lights"), turn: 20.0 },
];

fn parse_name(text: &str) -> Result<&'static str, String> {
    let names = FLIGHTS.map(|flight| flight.name);
    names.into_iter().find(|name| *name == text).ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

impl Flight {
    fn text(&self) -> Result<String, Failure> {
        match self.scene {
            Source::Text(text) => Ok(text.to_owned()),
            Source::BuiltIn(name) => {
                bench::built_in(name).ok_or_else(|| Failure::Other(format!("there is no example {name}")))
            }
        }
    }

    /// Camera of a frame: turned about the vertical through its target.
    fn camera(&self, scene: &Scene, frame: u32) -> Camera {
        let mut camera = scene.cameras[0].clone();
        let angle = (self.turn * frame.min(MOVING_FRAMES) as f32 / MOVING_FRAMES as f32).to_radians();
        let (sine, cosine) = angle.sin_cos();
        let [x, y, z] = std::array::from_fn(|k| camera.position[k] - camera.target[k]);
        let turned = [x * cosine + z * sine, y, z * cosine - x * sine];
        camera.position = std::array::from_fn(|k| camera.target[k] + turned[k]);
        camera
    }
}

/// Result of a compared frame.
struct Row {
    frame: u32,
    /// FLIP and relMSE, before and after.
    flip: [f64; 2],
    relmse: [f64; 2],
    /// relMSE after, of pixels with fewer than [`SHORT_HISTORY`] samples; `None` if there are none, and in enlarged pictures.
    short_history: Option<f64>,
    /// Mean difference between the changes of the picture and of the reference since the last frame, along the motion;
    /// `None` at rest, and in enlarged pictures.
    temporal: Option<f64>,
    /// Mean luminance after, divided by that of the reference.
    energy: f64,
    /// Smallest and largest ratio of the 32x32 tiles.
    tiles: [f64; 2],
}

/// Number of samples below which a history is short.
const SHORT_HISTORY: f32 = 4.0;

impl Row {
    fn print(&self, name: &str) {
        let Self { frame, flip, relmse, short_history, temporal, energy, tiles } = self;
        let optional = |value: &Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.4}"));
        outln!(
            "{name:8} {:3}   FLIP {:.3} -> {:.3}   relMSE {:8.4} -> {:.4}, short history {}   temporal {}   energy \
             {energy:.3}, tiles {:.3} to {:.3}",
            frame + 1,
            flip[0],
            flip[1],
            relmse[0],
            relmse[1],
            optional(short_history),
            optional(temporal),
            tiles[0],
            tiles[1]
        );
    }
}

/// Picture as a screen shows it: clipped to 0..=1, linear.
fn shown(picture: &Picture, display: &Display) -> Picture {
    let pixels = picture.pixels.iter().map(|pixel| display.encode(*pixel).map(srgb_decode)).collect();
    Picture { pixels, ..*picture }
}

fn mean(picture: &Picture) -> f64 {
    picture.mean_colour().iter().sum::<f64>() / 3.0
}

/// relMSE of the pixels with fewer than [`SHORT_HISTORY`] samples.
fn relmse_of_short_histories(frame: &Frame, reference: &Picture) -> Result<Option<f64>, Failure> {
    let is_short = |lengths: &[f32; 3]| lengths[0] < SHORT_HISTORY;
    let pick = |picture: &Picture| -> Vec<[f32; 3]> {
        let pixels = picture.pixels.iter().zip(&frame.history_length.pixels);
        pixels.filter(|(_, lengths)| is_short(lengths)).map(|(pixel, _)| *pixel).collect()
    };
    let row = |pixels: Vec<[f32; 3]>| Picture { width: pixels.len() as u32, height: 1, pixels };
    let [ours, expected] = [row(pick(&frame.reconstructed)), row(pick(reference))];
    if ours.width == 0 {
        return Ok(None);
    }
    metrics::relmse(&ours, &expected).map(Some).map_err(Failure::other)
}

/// Mean over pixels and channels of |(ours - ours before) - (reference - reference before)|, where "before" is the nearest
/// pixel of the last frame along the motion. Pixels that were hidden do not count.
fn temporal_error([ours, ours_before, reference, reference_before]: [&Picture; 4], motion: &Picture) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for (index, &[dx, dy, is_known]) in motion.pixels.iter().enumerate() {
        let (x, y) = (index as u32 % motion.width, index as u32 / motion.width);
        let (x, y) = ((x as f32 + dx).round(), (y as f32 + dy).round());
        if is_known == 0.0 || x < 0.0 || y < 0.0 {
            continue;
        }
        let before = |picture: &Picture| picture.get(x as u32, y as u32);
        let (Some(a), Some(b)) = (before(ours_before), before(reference_before)) else { continue };
        let difference = |k: usize| (ours.pixels[index][k] - a[k]) - (reference.pixels[index][k] - b[k]);
        sum += (0..3).map(|k| f64::from(difference(k).abs())).sum::<f64>() / 3.0;
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// Picture enlarged to this size by repeating pixels.
fn enlarged(picture: &Picture, [width, height]: [u32; 2]) -> Picture {
    Picture::from_fn(width, height, |x, y| {
        picture.get(x * picture.width / width, y * picture.height / height).unwrap_or_default()
    })
}

/// Compares the samples of a frame and its reconstructed picture with a reference.
fn compare(number: u32, pictures: [&Picture; 2], reference: &Picture, display: &Display) -> Result<Row, Failure> {
    let shown_reference = shown(reference, display);
    let (mut flip, mut relmse) = ([0.0; 2], [0.0; 2]);
    for (k, picture) in pictures.into_iter().enumerate() {
        let compared = metrics::compare(&shown(picture, display), &shown_reference, PictureKind::Ldr);
        flip[k] = compared.map_err(Failure::other)?.flip;
        relmse[k] = metrics::relmse(picture, reference).map_err(Failure::other)?;
    }
    let [ours, expected] = [block_means(pictures[1], 32), block_means(reference, 32)];
    let ratio = |(ours, expected): (&[f32; 3], &[f32; 3])| {
        let sum = |pixel: &[f32; 3]| f64::from(pixel.iter().sum::<f32>());
        sum(ours) / sum(expected).max(1e-3)
    };
    let ratios: Vec<f64> = ours.pixels.iter().zip(&expected.pixels).map(ratio).collect();
    let tiles = [ratios.iter().copied().fold(f64::INFINITY, f64::min), ratios.iter().copied().fold(0.0, f64::max)];
    let energy = mean(pictures[1]) / mean(reference);
    Ok(Row { frame: number, flip, relmse, short_history: None, temporal: None, energy, tiles })
}

/// Flight with its scene, settings and references.
struct Course<'a> {
    flight: &'a Flight,
    arguments: &'a Arguments,
    text: String,
    still: Arc<Scene>,
    renderer: Renderer,
}

impl<'a> Course<'a> {
    fn new(flight: &'a Flight, arguments: &'a Arguments) -> Result<Self, Failure> {
        let text = flight.text()?;
        let still = Scene::parse_at(flight.name, &text, Moment::of_frame(0, FPS)).map(Arc::new)?;
        let renderer = Renderer::open(Backend::Cpu, None).map_err(Failure::other)?;
        Ok(Self { flight, arguments, text, still, renderer })
    }

    /// Scene of a frame; `last` if it has not changed since.
    fn scene(&self, frame: u32, last: &Arc<Scene>) -> Result<Arc<Scene>, Failure> {
        if !self.still.animated || frame > MOVING_FRAMES {
            return Ok(last.clone());
        }
        Ok(Scene::parse_at(self.flight.name, &self.text, Moment::of_frame(frame, FPS)).map(Arc::new)?)
    }

    /// Settings of a frame: one sample while moving, one more in each frame at rest.
    fn settings(&self, scene: &Scene, frame: u32) -> Settings {
        let viewpoint = Some(self.flight.camera(scene, frame));
        let (seed, samples) = (frame.min(MOVING_FRAMES), 1 + frame.saturating_sub(MOVING_FRAMES));
        Settings { size: self.arguments.size, samples, seed, viewpoint, ..Settings::of(scene) }
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
        let many = Settings { samples: *samples, seed: 1000 + frame, size, ..self.settings(scene, frame) };
        let picture = self.renderer.render(scene, &many).map_err(Failure::other)?.mean();
        if let Some(path) = &path {
            image::save(path, &picture, &Display::default(), &Provenance::default()).map_err(Failure::other)?;
        }
        Ok(picture)
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

/// Mean absolute difference of two pictures.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let change = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>()) / 3.0;
    a.pixels.iter().zip(&b.pixels).map(change).sum::<f64>() / a.pixels.len() as f64
}

fn fly(flight: &Flight, arguments: &Arguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let course = Course::new(flight, arguments)?;
    let mut sequence = Sequence::new(&course.renderer, ReconstructOptions::default());
    let (mut flicker, mut times) = (Vec::new(), [0.0; 2]);
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
        times = [times[0] + frame.trace_seconds, times[1] + frame.reconstruct_seconds];
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
            row.print(flight.name);
            let pictures = [("before", &noisy), ("after", &frame.reconstructed), ("reference", &reference)];
            course.save(number, pictures, &display)?;
        }
        last = Some(frame);
    }
    let [trace, reconstruct] = times.map(|seconds| seconds * 1e3 / f64::from(FRAMES));
    let flicker = flicker.iter().sum::<f64>() / flicker.len().max(1) as f64;
    outln!(
        "{:8} tracing {trace:.1} ms, reconstruction {reconstruct:.1} ms a frame; flicker at rest {flicker:.5}",
        flight.name
    );
    Ok(())
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let interrupt = Interrupt(catch_interrupts()?);
    for directory in arguments.output.iter().chain(&arguments.references) {
        std::fs::create_dir_all(directory)
            .map_err(|error| Failure::Other(format!("{}: {error}", directory.display())))?;
    }
    for flight in FLIGHTS.iter().filter(|flight| arguments.names.is_empty() || arguments.names.contains(&flight.name)) {
        fly(flight, arguments, &interrupt)?;
    }
    Ok(DONE)
}
