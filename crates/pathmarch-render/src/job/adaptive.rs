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
//! **Parts.** Halves and pilot are recorded as parts of films, by chunks of samples that follow from the plan alone, so that a
//! picture that goes on from its parts is that of an uninterrupted render, to the last bit.
//!
//! **Cost.** The pilot has 32 samples. On a GPU it needs a kernel of its own.

use super::motion::{MotionBlur, Shutter};
use super::{BackendInfo, Job, Renderer, Work};
use crate::error::RenderError;
use crate::integrator::photons::default_path_count;
use crate::mode::Mode;
use crate::output::film::Film;
use crate::output::half_films::HalfFilms;
use crate::output::parts::{FilmPart, Identity, Rect, SampleRecorder};
use crate::scene::light::luminance;
use crate::settings::Settings;
use pathmarch_scene::{Animation, Scene};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

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
    /// Both halves, and the pilot.
    traces: [Trace; 3],
    /// Samples that are planned for each tile.
    tiles: Vec<(Rect, u32)>,
    steps: VecDeque<Step>,
    is_planned: bool,
    /// True if the trace of the current step takes samples only in its rectangles.
    restricted: bool,
    /// Samples done and to do, summed over pixels.
    done: f64,
    planned: f64,
}

/// Samples of a half or of the pilot.
struct Trace {
    job: Job,
    part: FilmPart,
    /// Samples of the part when the job was started.
    before: u32,
}

impl Trace {
    /// Samples that are recorded.
    fn recorded(&self) -> u32 {
        self.part.samples().count()
    }

    /// Samples that are done, with a fraction for one that is begun.
    fn samples_done(&self) -> f64 {
        f64::from(self.before) + self.job.samples_done()
    }

    /// Renders a slice of the work towards the end of a chunk of samples, and records them once they are done.
    fn advance(&mut self, chunk: [u32; 2]) -> Result<(), RenderError> {
        // Samples that follow on a chunk that was interrupted are added one by one, as they would have been.
        let recorded = self.recorded();
        let goal = if recorded == chunk[0] { chunk[1] } else { recorded + 1 };
        self.job.advance(goal - self.before)?;
        if self.samples_done() >= f64::from(goal) {
            self.record(chunk[1])?;
        }
        Ok(())
    }

    /// Records samples that are done, of a chunk with this end.
    fn record(&mut self, end: u32) -> Result<(), RenderError> {
        self.job.put_samples(&mut ChunkRecorder { part: &mut self.part, end })
    }

    /// Finishes samples that are begun, and records them.
    fn finish(&mut self, end: u32) -> Result<(), RenderError> {
        while !self.job.is_whole() {
            self.job.advance(self.job.samples_done() as u32 + 1)?;
        }
        self.record(end)
    }
}

/// Records the samples of a chunk.
struct ChunkRecorder<'a> {
    part: &'a mut FilmPart,
    end: u32,
}

impl SampleRecorder for ChunkRecorder<'_> {
    fn end_of_sum(&self, _first: u32) -> u32 {
        self.end
    }

    fn record(&mut self, first: u32, film: Film) {
        self.part.record_in_block(first, film, self.end);
    }
}

/// Index of the pilot among the traces.
const PILOT_TRACE: usize = 2;

/// Part of the work.
struct Step {
    /// Index of the trace.
    trace: usize,
    /// Samples of the trace at the beginning and at the end.
    samples: [u32; 2],
    /// Pixels.
    rects: Vec<Rect>,
}

impl Step {
    fn pixels(&self) -> usize {
        self.rects.iter().map(Rect::pixels).sum()
    }

    /// Samples, summed over pixels.
    fn work(&self) -> f64 {
        self.pixels() as f64 * f64::from(self.samples[1] - self.samples[0])
    }

    /// Chunk of samples that this one is in, in a picture of so many pixels.
    fn chunk(&self, sample: u32, pixels: usize) -> [u32; 2] {
        /// Samples of a chunk of all pixels; chunks of fewer pixels have more, so that their films cost little.
        const LENGTH: usize = 16;
        let length = (LENGTH * pixels / self.pixels().max(1)).clamp(LENGTH, 1 << 20) as u32;
        let [begin, end] = self.samples;
        let start = begin + (sample - begin) / length * length;
        [start, end.min(start + length)]
    }
}

/// Animation whose moments are the samples of a picture with motion blur.
type Motion<'a> = (&'a Arc<Mutex<Animation>>, Shutter);

impl Renderer {
    /// Starts a picture of one moment in which every tile of 32 by 32 pixels has an estimated relative error below `noise`. The
    /// settings' `samples` are the largest number for a pixel, `first_sample`, `splitting`, `light_samples`,
    /// `indirect_samples`, `path_reuse` and `emitter_edges` are ignored.
    ///
    /// # Errors
    /// Those of [`start`](Self::start), and [`RenderError::Settings`] if the mode is not [`Mode::Path`] or `noise` is not from
    /// [`MIN_NOISE`] to [`MAX_NOISE`].
    pub fn start_adaptive(&self, scene: &Scene, settings: &Settings, noise: f32) -> Result<AdaptiveJob, RenderError> {
        self.adaptive(None, scene, settings, noise, None)
    }

    /// Starts a picture as [`start_adaptive`](Self::start_adaptive), with motion blur as
    /// [`start_motion_blur`](Self::start_motion_blur). It goes on from the [parts](AdaptiveJob::parts) of a job with the same
    /// arguments on the same backend, if they are given.
    ///
    /// # Errors
    /// Those of both, and [`RenderError::Settings`] if the parts are not those of such a job.
    pub fn start_adaptive_motion_blur(
        &self,
        animation: &Arc<Mutex<Animation>>,
        scene: &Scene,
        settings: &Settings,
        shutter: Shutter,
        noise: f32,
        parts: Option<[FilmPart; 3]>,
    ) -> Result<AdaptiveJob, RenderError> {
        let motion = shutter.blurs(scene, settings).then_some((animation, shutter));
        self.adaptive(motion, scene, settings, noise, parts)
    }

    fn adaptive(
        &self,
        motion: Option<Motion>,
        scene: &Scene,
        settings: &Settings,
        noise: f32,
        parts: Option<[FilmPart; 3]>,
    ) -> Result<AdaptiveJob, RenderError> {
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
            light_samples: Some(1),
            indirect_samples: Some(1),
            light_paths: settings.light_paths.or(Some(default_path_count(settings.size))),
            path_reuse: Some(false),
            emitter_edges: Some(false),
            samples: most,
            ..settings.clone()
        };
        let rect = whole.rect();
        let parts = parts.unwrap_or_else(|| std::array::from_fn(|_| FilmPart::new(rect)));
        let renderer = self.settled(scene, &whole);
        let start = |change: u32, mode, samples: u32, part: FilmPart| {
            let before = part.samples().count();
            if part.rect() != rect || before > samples {
                return Err(RenderError::Settings("the parts are those of another picture".to_owned()));
            }
            let samples = (samples - before).max(1);
            let settings = Settings { seed: whole.seed ^ change, mode, samples, first_sample: before, ..whole.clone() };
            let job = renderer.start_part(motion, scene, &settings)?;
            Ok(Trace { job, part, before })
        };
        let [first, second, pilot] = parts;
        let traces = [
            start(0, Mode::Path, most, first)?,
            start(SEEDS[0], Mode::Path, most, second)?,
            start(SEEDS[1], Mode::Variance, PILOT, pilot)?,
        ];
        let least = LEAST.min(most);
        let step = |trace, end| Step { trace, samples: [0, end], rects: vec![rect] };
        let mut steps = VecDeque::from([step(0, least / 2), step(1, least / 2)]);
        let needs_pilot = most > LEAST;
        steps.extend(needs_pilot.then(|| step(PILOT_TRACE, PILOT)));
        let planned = steps.iter().map(Step::work).sum();
        let tiles = tiles(rect).into_iter().map(|tile| (tile, least)).collect();
        let is_planned = !needs_pilot;
        let mut job =
            AdaptiveJob { noise, most, rect, traces, tiles, steps, is_planned, restricted: false, done: 0.0, planned };
        job.end_steps();
        Ok(job)
    }

    /// Starts a half or a pilot.
    fn start_part(&self, motion: Option<Motion>, scene: &Scene, settings: &Settings) -> Result<Job, RenderError> {
        let Some((animation, shutter)) = motion else { return self.start(scene, settings) };
        settings.check(scene)?;
        let blur = MotionBlur::new(self.clone(), animation.clone(), settings, shutter);
        Ok(Job { work: Work::Moving(Box::new(blur)), settings: settings.clone(), backend: self.backend(), taken: 0 })
    }
}

impl AdaptiveJob {
    /// Backend that renders it.
    pub fn backend(&self) -> &BackendInfo {
        self.traces[0].job.backend()
    }

    /// Backend and adapter, as films record them.
    pub fn engine(&self) -> String {
        self.traces[0].job.engine()
    }

    /// What its films show: a job goes on from the parts of another with the same identity.
    pub fn identity(&self, scene: &Scene, shutter: Shutter) -> Identity {
        let mut identity = self.traces[0].job.identity(scene, shutter);
        identity.0.insert("noise".to_owned(), format!("{} with up to {} samples", self.noise, self.most));
        identity
    }

    /// Largest number of samples of a pixel.
    pub fn most_samples(&self) -> u32 {
        self.most
    }

    /// Renders until every tile has its samples or `stop` returns true, but not before each pixel has a sample; calls `progress`
    /// after each slice of the work.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn run(&mut self, stop: impl Fn() -> bool, mut progress: impl FnMut(&Self)) -> Result<(), RenderError> {
        while !(self.is_done() || stop() && self.traces[0].samples_done() >= 1.0) {
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
        let trace = &mut self.traces[step.trace];
        if !self.restricted {
            trace.job.restrict(step.rects.clone());
            self.restricted = true;
        }
        let chunk = step.chunk(trace.recorded(), self.rect.pixels());
        trace.advance(chunk)?;
        self.end_steps();
        Ok(())
    }

    /// Ends the steps whose samples are recorded.
    fn end_steps(&mut self) {
        while let Some(step) = self.steps.front().filter(|step| self.traces[step.trace].recorded() >= step.samples[1]) {
            self.done += step.work();
            self.restricted = false;
            let is_pilot = step.trace == PILOT_TRACE;
            self.steps.pop_front();
            if is_pilot {
                self.plan(&self.traces[PILOT_TRACE].part.film());
            }
        }
    }

    /// True if every tile has its samples.
    pub fn is_done(&self) -> bool {
        self.steps.is_empty()
    }

    /// True once the number of samples of each tile is known, and with it the time that is left.
    pub fn is_planned(&self) -> bool {
        self.is_planned
    }

    /// Share of the planned work that is done, 0 to 1. Before [`is_planned`](Self::is_planned), of the pilot and what precedes it.
    pub fn share_done(&self) -> f64 {
        let current = self.steps.front().map_or(0.0, |step| {
            let [start, end] = step.samples.map(f64::from);
            let done = (self.traces[step.trace].samples_done() - start) / (end - start);
            step.work() * done.clamp(0.0, 1.0)
        });
        (self.done + current) / self.planned.max(1.0)
    }

    /// All samples so far, of both halves and of the pilot, from which
    /// [`start_adaptive_motion_blur`](Renderer::start_adaptive_motion_blur) goes on.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn parts(&mut self) -> Result<[FilmPart; 3], RenderError> {
        if let Some(step) = self.steps.front() {
            let trace = &mut self.traces[step.trace];
            let [_, end] = step.chunk(trace.recorded(), self.rect.pixels());
            trace.finish(end)?;
            self.end_steps();
        }
        Ok(self.traces.each_ref().map(|trace| trace.part.clone()))
    }

    /// Film so far, and its tiles. Pixels have different numbers of samples ([`Film::sample_counts`]).
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn film(&mut self) -> Result<(Film, Vec<AdaptiveTile>), RenderError> {
        let (halves, tiles) = self.halves()?;
        Ok((halves.film().clone(), tiles))
    }

    /// Films of both halves so far, for a [denoiser](crate::denoise::Denoiser), and tiles. The errors of the tiles are those
    /// of the film that is not denoised.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn halves(&mut self) -> Result<(HalfFilms, Vec<AdaptiveTile>), RenderError> {
        let [first, second, _] = self.parts()?;
        let mut films = [first.film(), second.film()];
        for film in &mut films {
            for (tile, samples) in &self.tiles {
                let skipped = film.samples.saturating_sub(samples / 2);
                pixels(self.rect, *tile).for_each(|pixel| film.count_skipped(pixel, skipped));
            }
        }
        let tiles = reached(self.rect, &self.tiles, &films);
        let mut whole = films[0].clone();
        whole.add(&films[1]).map_err(|error| RenderError::Settings(error.to_string()))?;
        Ok((HalfFilms::new(self.rect, films, whole), tiles))
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
                self.steps.push_back(Step { trace: half, samples, rects: rects.clone() });
            }
            before = level;
        }
        self.planned = self.done + self.steps.iter().map(Step::work).sum::<f64>();
        self.is_planned = true;
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
