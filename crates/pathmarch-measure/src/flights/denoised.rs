//! Final frames of a flight, denoised one by one and joined.
//!
//! **Method.** Two references of a frame have independent noise. Squared errors are products of the differences from
//! both, whose mean is free of the noise of the references. The temporal error is the mean absolute error of the change
//! since the frame before, along the motion, as a screen shows it; there the reference is the mean of both, denoised. Both
//! are also measured without edges: pixels next to another material, albedo or normal, and pixels whose rays reach
//! several places, as in glass.

use super::compare::shown;
use super::{Arguments, Course, Flight, Interrupt};
use pathmarch_cli::{Failure, outln};
use pathmarch_render::denoise::{Denoiser, Features, HalfBuffers, SequenceDenoiser};
use pathmarch_render::image::{self, Picture, Provenance};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::reconstruct::{ReconstructOptions, Sequence};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Renderer, Settings};
use std::time::Instant;

/// First and last frame.
pub(super) type Range = [u32; 2];

pub(super) fn parse_range(text: &str) -> Result<Range, String> {
    let number = |text: &str| text.parse::<u32>().ok();
    let parsed = text.split_once('-').and_then(|(first, last)| Some([number(first)?, number(last)?]));
    let limit = super::FRAMES;
    parsed
        .filter(|[first, last]| first <= last && *last < limit)
        .ok_or_else(|| format!("expected two frames below {limit}, such as 9-16"))
}

/// Seed of all frames, as in a sequence of `pathmarch render`.
const SEED: u32 = 0;
/// Seeds of the two references of a frame, before its number.
const REFERENCE_SEEDS: [u32; 2] = [1000, 2000];
/// Deviation of the positions that the rays of a pixel reach, in sides of the pixel, above which they are several places.
const MAX_SPREAD: f32 = 4.0;
/// Least square of a channel that squared errors are divided by.
const RELMSE_FLOOR: f32 = 0.01;

/// A frame with its references; the pictures are denoised alone and joined.
struct Measured {
    pictures: [Picture; 2],
    noisy: Picture,
    references: [Picture; 2],
    /// Mean of the denoised references.
    clean: Picture,
    display: Display,
}

/// Mean over all pixels, and over those without edges.
type Means = [f64; 2];

/// Sums for [`Means`].
#[derive(Default)]
struct Sums {
    sums: [f64; 2],
    counts: [u32; 2],
}

impl Sums {
    fn add(&mut self, value: f64, is_edge: bool) {
        for k in 0..if is_edge { 1 } else { 2 } {
            self.sums[k] += value;
            self.counts[k] += 1;
        }
    }

    fn means(&self) -> Means {
        std::array::from_fn(|k| self.sums[k] / f64::from(self.counts[k].max(1)))
    }
}

/// Pixels next to another material, albedo or normal, and those whose rays reach several places.
fn edges(features: &Features, [width, height]: [u32; 2]) -> Vec<bool> {
    let mean = |index: usize| {
        let [a, b] = [0, 1].map(|half: usize| &features.halves[half][index]);
        let count = (a.surfaces + b.surfaces).max(1.0);
        let rays = 2.0 * features.rays as f32;
        ((a.albedo + b.albedo) / rays, (a.normal + b.normal) / count, (a.material + b.material) / count, count / rays)
    };
    let differ = |index: usize, other: usize| {
        let (a, b) = (mean(index), mean(other));
        let turned = a.1.dot(b.1) < 0.9 && a.3 > 0.5;
        (a.0 - b.0).abs().max_element() > 0.05 || turned || (a.2 - b.2).abs() > 1e-3 || (a.3 - b.3).abs() > 1e-3
    };
    let is_edge = |index: u32| {
        let (x, y) = (index % width, index / width);
        let neighbours = (y.saturating_sub(1)..=(y + 1).min(height - 1))
            .flat_map(|row| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |column| row * width + column));
        let [a, b] = [0, 1].map(|half: usize| &features.halves[half][index as usize]);
        let footprint = features.pixel * (a.length + b.length) / (a.surfaces + b.surfaces).max(1.0);
        let spread = ((a.squared_spread + b.squared_spread) / (a.surfaces + b.surfaces).max(1.0)).sqrt();
        spread > MAX_SPREAD * footprint || neighbours.into_iter().any(|other| differ(index as usize, other as usize))
    };
    (0..width * height).map(is_edge).collect()
}

/// relMSE against two references.
fn relmse(picture: &Picture, [a, b]: &[Picture; 2], edges: &[bool]) -> Means {
    let mut sums = Sums::default();
    let pixels = picture.pixels.iter().zip(a.pixels.iter().zip(&b.pixels));
    for ((pixel, (a, b)), is_edge) in pixels.zip(edges) {
        let channel = |k: usize| {
            let reference = 0.5 * (a[k] + b[k]);
            f64::from((pixel[k] - a[k]) * (pixel[k] - b[k]) / (reference * reference + RELMSE_FLOOR))
        };
        sums.add((0..3).map(channel).sum::<f64>() / 3.0, *is_edge);
    }
    sums.means()
}

/// Mean absolute temporal error of a picture against a reference, each with that of the frame before, and its picture.
fn temporal_error(now: [&Picture; 2], before: [&Picture; 2], motion: &Picture, edges: &[bool]) -> (Means, Picture) {
    let mut sums = Sums::default();
    let mut errors = Picture { pixels: vec![[0.0; 3]; motion.pixels.len()], ..*motion };
    for (index, &[dx, dy, is_known]) in motion.pixels.iter().enumerate() {
        let (x, y) = (index as u32 % motion.width, index as u32 / motion.width);
        let [x, y] = [x as f32 + dx, y as f32 + dy].map(f32::round);
        if is_known == 0.0 || x < 0.0 || y < 0.0 {
            continue;
        }
        let Some(earlier) = before[0].get(x as u32, y as u32).map(|_| (x as u32, y as u32)) else { continue };
        let change = |k: usize, channel: usize| {
            let past = before[k].get(earlier.0, earlier.1).unwrap_or_default()[channel];
            now[k].pixels[index][channel] - past
        };
        let error = |channel| (change(0, channel) - change(1, channel)).abs();
        errors.pixels[index] = [0, 1, 2].map(error);
        sums.add(f64::from(errors.pixels[index].iter().sum::<f32>()) / 3.0, edges[index]);
    }
    (sums.means(), errors)
}

/// Mean of the samples of a final frame, and that denoised.
pub(super) fn final_frame(
    renderer: &Renderer,
    scene: &Scene,
    settings: &Settings,
    denoiser: Denoiser,
) -> Result<[Picture; 2], Failure> {
    let mut halves = HalfBuffers::new(settings);
    let mut job = renderer.start(scene, settings).map_err(Failure::other)?;
    job.record(&mut halves, |_| false, |_| {}).map_err(Failure::other)?;
    let features = Features::trace(scene, settings, settings.samples).map_err(Failure::other)?;
    let clean = denoiser.denoise(&halves, &features).map_err(Failure::other)?;
    Ok([halves.film().mean(), clean])
}

/// Reference of a frame with one of the two seeds, before and after denoising, kept as those of other flights are.
fn reference(course: &Course, scene: &Scene, frame: u32, seed: u32) -> Result<[Picture; 2], Failure> {
    let &Arguments { samples, ref references, size: [width, height], .. } = course.arguments;
    let moving = frame.min(course.arguments.rest_after);
    let paths = references.as_ref().map(|directory| {
        ["noisy", "clean"].map(|part| {
            directory.join(format!("{}-{moving:02}-{width}x{height}-{samples}-{seed}-{part}.exr", course.flight.name))
        })
    });
    if let Some([noisy, clean]) = paths.as_ref().filter(|paths| paths.iter().all(|path| path.exists())) {
        let load = |path| image::load(path).map(|loaded| loaded.picture).map_err(Failure::other);
        return Ok([load(noisy)?, load(clean)?]);
    }
    let many = Settings { samples, seed: seed + frame, ..settings(course, scene, frame) };
    let pictures = final_frame(&course.renderer, scene, &many, Denoiser::Regression)?;
    for (path, picture) in paths.iter().flatten().zip(&pictures) {
        image::save(path, picture, &Display::default(), &Provenance::default()).map_err(Failure::other)?;
    }
    Ok(pictures)
}

fn mean_of(a: &Picture, b: &Picture) -> Picture {
    let pixels = a.pixels.iter().zip(&b.pixels).map(|(a, b)| std::array::from_fn(|k| 0.5 * (a[k] + b[k]))).collect();
    Picture { pixels, ..*a }
}

/// Settings of a frame, without samples.
fn settings(course: &Course, scene: &Scene, frame: u32) -> Settings {
    let viewpoint = Some(course.flight.camera(scene, frame.min(course.arguments.rest_after)));
    Settings { size: course.arguments.size, seed: SEED, viewpoint, ..Settings::of(scene) }
}

fn save(course: &Course, frame: u32, part: &str, picture: &Picture, display: &Display) -> Result<(), Failure> {
    let Some(directory) = &course.arguments.output else { return Ok(()) };
    let path = directory.join(format!("{}-{frame:02}-{part}.png", course.flight.name));
    image::save(&path, picture, display, &Provenance::default()).map_err(Failure::other)
}

/// Measures frames of a flight, whose first one is frame 0.
pub(super) fn fly(flight: &Flight, arguments: &Arguments, samples: u32, interrupt: &Interrupt) -> Result<(), Failure> {
    let mut course = Course::new(flight, arguments)?;
    let [first, last] = arguments.frames;
    let mut sequence = SequenceDenoiser::new();
    let mut motions = Sequence::new(&course.cpu, ReconstructOptions::default());
    let mut scene = course.still.clone();
    let mut past: Option<Measured> = None;
    let (mut sums, mut count, mut seconds) = ([[0.0; 2]; 4], 0, [0.0; 2]);
    for frame in 0..=last {
        interrupt.check()?;
        scene = course.scene(frame.min(arguments.rest_after), &scene)?;
        let settings = Settings { samples, ..settings(&course, &scene, frame) };
        let mut halves = HalfBuffers::new(&settings);
        let mut job = course.renderer.start(&scene, &settings).map_err(Failure::other)?;
        job.record(&mut halves, |_| interrupt.check().is_err(), |_| {}).map_err(Failure::other)?;
        interrupt.check()?;
        let features = Features::trace(&scene, &settings, samples).map_err(Failure::other)?;
        let mut clock = Instant::now();
        let mut lap = |seconds: &mut f64| {
            *seconds += clock.elapsed().as_secs_f64();
            clock = Instant::now();
        };
        let joined = sequence.denoise(&halves, &features).map_err(Failure::other)?;
        lap(&mut seconds[1]);
        if frame + 1 < first {
            continue;
        }
        let apart = Denoiser::Regression.denoise(&halves, &features).map_err(Failure::other)?;
        lap(&mut seconds[0]);
        let one_sample = Settings { samples: 1, first_sample: frame, ..settings };
        let motion = motions.render(&scene, &one_sample).map_err(Failure::other)?.motion;
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
        let [a, b] = REFERENCE_SEEDS.map(|seed| reference(&course, &scene, frame, seed));
        let ([a, clean_a], [b, clean_b]) = (a?, b?);
        let pictures = [apart, joined];
        let clean = mean_of(&clean_a, &clean_b);
        let measured = Measured { pictures, noisy: halves.film().mean(), references: [a, b], clean, display };
        if let Some(past) = past.as_ref().filter(|_| frame >= first) {
            let edges = edges(&features, arguments.size);
            let relmse = [0, 1].map(|k: usize| relmse(&measured.pictures[k], &measured.references, &edges));
            let brighter = Display { exposure_stops: 3.0, ..Display::default() };
            let [temporal_apart, temporal_joined] = [0, 1].map(|k: usize| {
                let both =
                    |frame: &Measured| [&frame.pictures[k], &frame.clean].map(|picture| shown(picture, &frame.display));
                let (now, before) = (both(&measured), both(past));
                let (means, errors) = temporal_error(now.each_ref(), before.each_ref(), &motion, &edges);
                save(&course, frame, ["apart-flicker", "joined-flicker"][k], &errors, &brighter).map(|()| means)
            });
            let row = [relmse[0], relmse[1], temporal_apart?, temporal_joined?];
            print_row(&flight.name, &format!("{frame:3}"), row);
            sums = std::array::from_fn(|k| std::array::from_fn(|part| sums[k][part] + row[k][part]));
            count += 1;
        }
        let Measured { pictures: [apart, joined], noisy, clean, display, .. } = &measured;
        for (part, picture) in [("noisy", noisy), ("apart", apart), ("joined", joined), ("reference", clean)] {
            save(&course, frame, part, picture, display)?;
        }
        past = Some(measured);
    }
    print_row(&flight.name, "mean", sums.map(|means| means.map(|mean| mean / f64::from(count.max(1)))));
    outln!(
        "{:8} seconds of a filter: apart {:.2}, joined {:.2}",
        flight.name,
        seconds[0] / f64::from(count + 1),
        seconds[1] / f64::from(last + 1)
    );
    Ok(())
}

/// Prints relMSE apart and joined, and temporal errors apart and joined.
fn print_row(name: &str, frame: &str, row: [Means; 4]) {
    let pair = |apart: &Means, joined: &Means, part: usize| {
        let (apart, joined) = (apart[part], joined[part]);
        format!("{apart:.2e} -> {joined:.2e} ({:.2})", joined / apart)
    };
    let [a, b, c, d] = &row;
    let [all, inside] = [0, 1].map(|part| format!("relMSE {}, temporal error {}", pair(a, b, part), pair(c, d, part)));
    outln!("{name:8} {frame:4}  {all}   without edges: {inside}");
}
