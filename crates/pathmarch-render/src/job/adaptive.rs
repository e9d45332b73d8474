//! Adaptive sampling: as many samples for each tile as its error asks for.
//!
//! **Idea.** A pilot of independent samples measures the variance of every pixel. From it alone follows the number of samples of
//! each tile of 32 by 32 pixels. The pilot is no part of the picture: a tile that happens to look smooth is not ended early
//! because of that, so that the picture is as unbiased as one with equal numbers of samples. The samples are taken in two
//! halves with independent noise, whose difference measures the error that was reached.
//!
//! **Source.** Kirk and Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis": samples that decide their own number bias the
//! picture. The error is relMSE as `compare` prints it, of luminance (Rousselle, Knaus, Zwicker 2012, "Adaptive Rendering with
//! Non-Local Means Filtering", section 4: half buffers).
//!
//! **Differences.** Samples are Sobol' points, whose error is below that of independent ones, so that most tiles become better than
//! is asked for. The variance of a tile is taken at the upper end of a confidence interval. A tile gets at least half as many samples as each of its neighbours: variance at its border may have been missed.
//!
//! **Cost.** The pilot has 32 samples. On a GPU it needs a kernel of its own.

use super::tracer::Tracer;
use super::{BackendInfo, Renderer};
use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::mode::Mode;
use crate::output::film::Film;
use crate::output::parts::Rect;
use crate::scene::light::luminance;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::collections::VecDeque;

/// Smallest error that can be asked for.
pub const MIN_NOISE: f32 = 1e-4;
/// Largest error that can be asked for.
pub const MAX_NOISE: f32 = 1.0;

/// Edge of a tile, pixels.
const TILE: u32 = 32;
/// Samples of every pixel, at least.
const LEAST: u32 = 16;
/// Samples of the pilot.
const PILOT: u32 = 32;
/// Added to squared means, as in relMSE.
const EPSILON: f64 = 0.01;
/// Changes of the seed for the second half and for the pilot.
const SEEDS: [u32; 2] = [0x5bd1_e995, 0x27d4_eb2f];

/// Tile of a picture with adaptive sampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveTile {
    /// Pixels.
    pub rect: Rect,
    /// Samples of each pixel.
    pub samples: u32,
    /// Estimated relative error: the root of the relMSE of its luminance.
    pub error: f32,
}

/// Picture being rendered with adaptive sampling.
pub struct AdaptiveJob {
    noise: f32,
    /// Largest number of samples, even.
    most: u32,
    rect: Rect,
    backend: BackendInfo,
    halves: [Tracer; 2],
    pilot: Option<Tracer>,
    /// Samples that are planned for each tile.
    tiles: Vec<(Rect, u32)>,
    steps: VecDeque<Step>,
    /// Samples done and to do, summed over pixels.
    done: f64,
    planned: f64,
}

/// Part of the work.
struct Step {
    tracer: Which,
    /// Samples of the tracer at the beginning and at the end.
    samples: [u32; 2],
    /// Pixels.
    rects: Vec<Rect>,
}

#[derive(Clone, Copy, PartialEq)]
enum Which {
    Half(usize),
    Pilot,
}

impl Step {
    /// Samples, summed over pixels.
    fn work(&self) -> f64 {
        let pixels: usize = self.rects.iter().map(Rect::pixels).sum();
        pixels as f64 * f64::from(self.samples[1] - self.samples[0])
    }
}

impl Renderer {
    /// Starts a picture of one moment in which every tile of 32 by 32 pixels has an estimated relative error below `noise`. The
    /// settings' `samples` are the largest number for a pixel, `first_sample`, `splitting` and `path_reuse` are ignored.
    ///
    /// # Errors
    /// Those of [`start`](Self::start), and [`RenderError::Settings`] if the mode is not [`Mode::Path`] or `noise` is not from
    /// [`MIN_NOISE`] to [`MAX_NOISE`].
    pub fn start_adaptive(&self, scene: &Scene, settings: &Settings, noise: f32) -> Result<AdaptiveJob, RenderError> {
        if settings.mode != Mode::Path {
            return Err(RenderError::Settings("adaptive sampling is for path-traced pictures only".to_owned()));
        }
        if !(MIN_NOISE..=MAX_NOISE).contains(&noise) {
            return Err(RenderError::Settings(format!("a noise of {noise} is not from {MIN_NOISE} to {MAX_NOISE}")));
        }
        // Both halves have at least one sample.
        let most = settings.samples.max(2) & !1;
        let whole = Settings {
            first_sample: 0,
            whole_samples: None,
            splitting: Some(1),
            path_reuse: Some(false),
            samples: most,
            ..settings.clone()
        };
        let renderer = self.settled(scene, &whole, &RenderInput::new(scene, &whole));
        let start = |change: u32, mode, samples| {
            renderer.trace(scene, &Settings { seed: whole.seed ^ change, mode, samples, ..whole.clone() })
        };
        let ((first, backend), (second, _)) = (start(0, Mode::Path, most)?, start(SEEDS[0], Mode::Path, most)?);
        let needs_pilot = most > LEAST;
        let pilot = needs_pilot.then(|| start(SEEDS[1], Mode::Variance, PILOT)).transpose()?.map(|(tracer, _)| tracer);
        let rect = whole.rect();
        let least = LEAST.min(most);
        let mut steps: VecDeque<Step> =
            (0..2).map(|half| Step { tracer: Which::Half(half), samples: [0, least / 2], rects: vec![rect] }).collect();
        steps.extend(needs_pilot.then(|| Step { tracer: Which::Pilot, samples: [0, PILOT], rects: vec![rect] }));
        let planned = steps.iter().map(Step::work).sum();
        let tiles = tiles(rect).into_iter().map(|tile| (tile, least)).collect();
        let halves = [first, second];
        Ok(AdaptiveJob { noise, most, rect, backend, halves, pilot, tiles, steps, done: 0.0, planned })
    }
}

impl AdaptiveJob {
    /// Backend that renders it.
    pub fn backend(&self) -> &BackendInfo {
        &self.backend
    }

    /// Renders until every tile has its samples or `stop` returns true, but not before each pixel has a sample; calls `progress`
    /// after each slice of the work.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn run(&mut self, stop: impl Fn() -> bool, mut progress: impl FnMut(&Self)) -> Result<(), RenderError> {
        while !(self.is_done() || stop() && self.halves[0].samples_done() >= 1.0) {
            self.advance()?;
            progress(self);
        }
        Ok(())
    }

    /// Renders a slice of the work.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn advance(&mut self) -> Result<(), RenderError> {
        let Some(step) = self.steps.front() else { return Ok(()) };
        let goal = step.samples[1];
        let Some(tracer) = tracer_of(&mut self.halves, &mut self.pilot, step.tracer) else { return Ok(()) };
        if tracer.samples_done() == f64::from(step.samples[0]) {
            tracer.restrict(step.rects.clone());
        }
        tracer.advance(goal)?;
        if tracer.samples_done() < f64::from(goal) {
            return Ok(());
        }
        self.done += step.work();
        let ended = step.tracer;
        self.steps.pop_front();
        if ended == Which::Pilot
            && let Some(mut pilot) = self.pilot.take()
        {
            let film = pilot.film()?;
            self.plan(&film);
        }
        Ok(())
    }

    /// True if every tile has its samples.
    pub fn is_done(&self) -> bool {
        self.steps.is_empty()
    }

    /// True once the number of samples of each tile is known, and with it the time that is left.
    pub fn is_planned(&self) -> bool {
        self.pilot.is_none()
    }

    /// Share of the planned work that is done, 0 to 1. Before [`is_planned`](Self::is_planned), of the pilot and what precedes it.
    pub fn share_done(&self) -> f64 {
        let current = self.steps.front().map_or(0.0, |step| {
            let tracer = match step.tracer {
                Which::Half(half) => Some(&self.halves[half]),
                Which::Pilot => self.pilot.as_ref(),
            };
            let [start, end] = step.samples.map(f64::from);
            let done = tracer.map_or(0.0, |tracer| (tracer.samples_done() - start) / (end - start));
            step.work() * done.clamp(0.0, 1.0)
        });
        (self.done + current) / self.planned.max(1.0)
    }

    /// Film so far, and its tiles. Pixels have different numbers of samples ([`Film::sample_counts`]).
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn film(&mut self) -> Result<(Film, Vec<AdaptiveTile>), RenderError> {
        let mut films = [self.halves[0].film()?, self.halves[1].film()?];
        for film in &mut films {
            for (tile, samples) in &self.tiles {
                let skipped = film.samples.saturating_sub(samples / 2);
                pixels(self.rect, *tile).for_each(|pixel| film.count_skipped(pixel, skipped));
            }
        }
        let tiles = reached(self.rect, &self.tiles, &films);
        let [mut film, second] = films;
        film.add(&second).map_err(|error| RenderError::Settings(error.to_string()))?;
        Ok((film, tiles))
    }

    /// Plans the samples of each tile by the film of the pilot.
    fn plan(&mut self, pilot: &Film) {
        let columns = self.rect.width.div_ceil(TILE) as usize;
        let counts = pilot.sample_counts();
        let errors = self.tiles.iter().map(|(tile, _)| error_of_a_sample(pilot, &counts, self.rect, *tile));
        let (least, most) = (f64::from(LEAST), f64::from(self.most));
        let needed: Vec<u32> = errors.map(|error| needed(error, self.noise).clamp(least, most) as u32).collect();
        for (k, (_, samples)) in self.tiles.iter_mut().enumerate() {
            let neighbours = neighbours(k, columns, needed.len()).map(|other| needed[other] / 2).max();
            *samples = level(needed[k].max(neighbours.unwrap_or(0))).min(self.most);
        }
        let mut levels: Vec<u32> = self.tiles.iter().map(|(_, samples)| *samples).filter(|n| *n > LEAST).collect();
        levels.sort_unstable();
        levels.dedup();
        let mut before = LEAST;
        for level in levels {
            let active = |(tile, samples): &(Rect, u32)| (*samples >= level).then_some(*tile);
            let rects = merged(self.tiles.iter().filter_map(active));
            for half in 0..2 {
                let samples = [before / 2, level / 2];
                self.steps.push_back(Step { tracer: Which::Half(half), samples, rects: rects.clone() });
            }
            before = level;
        }
        self.planned = self.done + self.steps.iter().map(Step::work).sum::<f64>();
    }
}

fn tracer_of<'a>(halves: &'a mut [Tracer; 2], pilot: &'a mut Option<Tracer>, which: Which) -> Option<&'a mut Tracer> {
    match which {
        Which::Half(half) => halves.get_mut(half),
        Which::Pilot => pilot.as_mut(),
    }
}

/// Tiles of a picture, row by row.
fn tiles(rect: Rect) -> Vec<Rect> {
    let starts = |start: u32, end: u32| (start..end).step_by(TILE as usize).map(move |at| (at, TILE.min(end - at)));
    let rows = starts(rect.y, rect.bottom());
    rows.flat_map(|(y, height)| starts(rect.x, rect.right()).map(move |(x, width)| Rect { x, y, width, height }))
        .collect()
}

/// Indices of the pixels of a tile in a film of `rect`.
fn pixels(rect: Rect, tile: Rect) -> impl Iterator<Item = usize> {
    let (x, y) = (tile.x - rect.x, tile.y - rect.y);
    (y..y + tile.height).flat_map(move |y| (x..x + tile.width).map(move |x| (y * rect.width + x) as usize))
}

/// Tiles of a row that are next to each other become one rectangle.
fn merged(tiles: impl Iterator<Item = Rect>) -> Vec<Rect> {
    let mut rects: Vec<Rect> = Vec::new();
    for tile in tiles {
        match rects.last_mut() {
            Some(last) if last.y == tile.y && last.right() == tile.x => last.width += tile.width,
            _ => rects.push(tile),
        }
    }
    rects
}

/// Indices of the tiles around a tile.
fn neighbours(k: usize, columns: usize, count: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (k % columns, k / columns);
    let around = |at: usize| at.saturating_sub(1)..at + 2;
    around(y).flat_map(move |row| around(x).map(move |column| (row, column))).filter_map(move |(row, column)| {
        let other = row * columns + column;
        (column < columns && other < count && other != k).then_some(other)
    })
}

/// Squared relative error of a tile with one sample of each pixel, from sums of luminances and of their squares: the upper end of a
/// confidence interval, as pixels differ and the pilot may have missed bright samples.
fn error_of_a_sample(film: &Film, counts: &[u32], rect: Rect, tile: Rect) -> f64 {
    /// Standard errors between the mean over the pixels and the upper end.
    const CONFIDENCE: f64 = 3.0;
    let error = |pixel: usize| {
        let ([sum, square, _], n) = (film.sums[pixel].map(f64::from), f64::from(counts[pixel]));
        if n < 2.0 {
            return 0.0;
        }
        let mean = sum / n;
        let variance = ((square / n - mean * mean) * (n / (n - 1.0))).max(0.0);
        variance / (mean * mean + EPSILON)
    };
    let n = tile.pixels() as f64;
    let mean = pixels(rect, tile).map(error).sum::<f64>() / n;
    let variance = pixels(rect, tile).map(|pixel| (error(pixel) - mean).powi(2)).sum::<f64>() / n;
    mean + CONFIDENCE * (variance / n).sqrt()
}

/// Number of samples after which a squared relative error has fallen to that of `noise`.
fn needed(error: f64, noise: f32) -> f64 {
    (error / f64::from(noise).powi(2)).ceil()
}

/// Number of samples that is rendered where `needed` are: four steps from each power of two to the next, as Sobol' points are the
/// more even the rounder their number is.
fn level(needed: u32) -> u32 {
    let step = 1 << needed.max(LEAST).ilog2().saturating_sub(2);
    needed.next_multiple_of(step)
}

/// Tiles with the error that was reached: half of the difference of two halves with independent noise.
fn reached(rect: Rect, planned: &[(Rect, u32)], films: &[Film; 2]) -> Vec<AdaptiveTile> {
    let [first, second] = films.each_ref().map(|film| (film.mean(), film.sample_counts()));
    let complete = films.iter().all(|film| film.samples > 0);
    let tile = |(tile, _): &(Rect, u32)| {
        let samples = pixels(rect, *tile).map(|pixel| first.1[pixel] + second.1[pixel]).max().unwrap_or(0);
        let squares = pixels(rect, *tile).map(|pixel| {
            let [a, b] = [&first.0, &second.0].map(|picture| f64::from(luminance(picture.pixels[pixel])));
            let (mean, difference) = ((a + b) / 2.0, (a - b) / 2.0);
            difference * difference / (mean * mean + EPSILON)
        });
        let error = if complete { (squares.sum::<f64>() / tile.pixels() as f64).sqrt() as f32 } else { f32::INFINITY };
        AdaptiveTile { rect: *tile, samples, error }
    };
    planned.iter().map(tile).collect()
}
