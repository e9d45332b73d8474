//! `pathmarch-measure flights`: error of reconstructed sequences against converged ones.
//!
//! **Idea.** Six sequences of 48 frames at one sample of each pixel: three quarters in motion, the rest at rest. Some
//! frames are compared with converged pictures of the same moment, before and after reconstruction.
//!
//! **Cost.** The references: about two minutes a flight on two cores by default.

use crate::bench;
use crate::measure::Interrupt;
use pathmarch_cli::{DONE, Failure, catch_interrupts, value_parsers};
use pathmarch_render::image::{self, Picture, PictureKind, Provenance};
use pathmarch_render::metrics::{self, block_means};
use pathmarch_render::pathmarch_scene::{Camera, Moment, Scene};
use pathmarch_render::reconstruct::Sequence;
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
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "320x180", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: SizeArgument,
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
/// Frames in motion.
const MOVING_FRAMES: u32 = 36;
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
    /// Mean luminance after, divided by that of the reference.
    energy: f64,
    /// Smallest and largest ratio of the 32x32 tiles.
    tiles: [f64; 2],
}

/// Picture as a screen shows it: clipped to 0..=1, linear.
fn shown(picture: &Picture, display: &Display) -> Picture {
    let pixels = picture.pixels.iter().map(|pixel| display.encode(*pixel).map(srgb_decode)).collect();
    Picture { pixels, ..*picture }
}

fn mean(picture: &Picture) -> f64 {
    picture.mean_colour().iter().sum::<f64>() / 3.0
}

fn compare(frame: u32, pictures: [&Picture; 2], reference: &Picture, display: &Display) -> Result<Row, Failure> {
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
    Ok(Row { frame, flip, relmse, energy: mean(pictures[1]) / mean(reference), tiles })
}

fn fly(flight: &Flight, arguments: &Arguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let text = flight.text()?;
    let parse = |frame: u32| Scene::parse_at(flight.name, &text, Moment::of_frame(frame, FPS)).map(Arc::new);
    let still = parse(0)?;
    let renderer = Renderer::open(Backend::Cpu, None).map_err(Failure::other)?;
    let mut sequence = Sequence::new();
    let (mut rows, mut flicker, mut times) = (Vec::new(), Vec::new(), [0.0; 2]);
    let mut last: Option<Picture> = None;
    let mut scene = still.clone();
    for frame in 0..FRAMES {
        interrupt.check()?;
        if still.animated && frame <= MOVING_FRAMES {
            scene = parse(frame)?;
        }
        let settings = Settings {
            size: arguments.size,
            samples: 1,
            seed: frame,
            viewpoint: Some(flight.camera(&scene, frame)),
            ..Settings::of(&scene)
        };
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
        let rendered = sequence.render(&scene, &settings).map_err(Failure::other)?;
        times = [times[0] + rendered.trace_seconds, times[1] + rendered.reconstruct_seconds];
        let displayed = shown(&rendered.reconstructed, &display);
        if let Some(last) = last.filter(|_| frame > MOVING_FRAMES + 4) {
            let change =
                |(a, b): (&[f32; 3], &[f32; 3])| f64::from((0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>()) / 3.0;
            let changes = displayed.pixels.iter().zip(&last.pixels).map(change);
            flicker.push(changes.sum::<f64>() / displayed.pixels.len() as f64);
        }
        last = Some(displayed);
        if (frame + 1) % arguments.every != 0 && frame + 1 != FRAMES {
            continue;
        }
        let many = Settings { samples: arguments.samples, seed: 1000 + frame, ..settings };
        let reference = renderer.render(&scene, &many).map_err(Failure::other)?.mean();
        rows.push(compare(frame, [&rendered.noisy, &rendered.reconstructed], &reference, &display)?);
        if let Some(directory) = &arguments.output {
            for (part, picture) in
                [("before", &rendered.noisy), ("after", &rendered.reconstructed), ("reference", &reference)]
            {
                let path = directory.join(format!("{}-{:02}-{part}.png", flight.name, frame + 1));
                image::save(&path, picture, &display, &Provenance::default()).map_err(Failure::other)?;
            }
        }
    }
    for row in &rows {
        println!(
            "{:8} {:3}   FLIP {:.3} -> {:.3}   relMSE {:8.4} -> {:.4}   energy {:.3}, tiles {:.3} to {:.3}",
            flight.name,
            row.frame + 1,
            row.flip[0],
            row.flip[1],
            row.relmse[0],
            row.relmse[1],
            row.energy,
            row.tiles[0],
            row.tiles[1]
        );
    }
    let [trace, reconstruct] = times.map(|seconds| seconds * 1e3 / f64::from(FRAMES));
    let flicker = flicker.iter().sum::<f64>() / flicker.len().max(1) as f64;
    println!(
        "{:8} tracing {trace:.1} ms, reconstruction {reconstruct:.1} ms a frame; flicker at rest {flicker:.5}",
        flight.name
    );
    Ok(())
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let interrupt = Interrupt(catch_interrupts()?);
    if let Some(directory) = &arguments.output {
        std::fs::create_dir_all(directory)
            .map_err(|error| Failure::Other(format!("{}: {error}", directory.display())))?;
    }
    for flight in FLIGHTS.iter().filter(|flight| arguments.names.is_empty() || arguments.names.contains(&flight.name)) {
        fly(flight, arguments, &interrupt)?;
    }
    Ok(DONE)
}
