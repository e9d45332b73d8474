//! CPU backend: tiles on all cores, eight rays in SIMD lanes. It needs no driver or adapter and is always available.

use super::RenderInput;
use crate::integrator::guides::{FILM_SAMPLES, Guide};
use crate::integrator::splitting;
use crate::mode::{Mode, uncertainty_of};
use crate::output::film::{Film, is_kept, kept};
use crate::output::parts::Rect;
use crate::output::tonemap::Display;
use crate::ray_stats::RayCounters;
use crate::scene::{KernelConfig, PhotonMap, TraceContext};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// Edge length of a tile, pixels: enough paths to fill eight lanes for most bounces, and few enough for the caches.
const TILE: u32 = 16;

/// Picture being rendered on the CPU.
pub(crate) struct CpuJob {
    input: RenderInput,
    stats: Option<Arc<RayCounters>>,
    /// Pixels of the film.
    rect: Rect,
    tiles: Vec<Tile>,
    film: Film,
    /// Number of finished tiles of the current samples.
    done: usize,
    /// Number of current samples, which share a camera ray.
    begun: u32,
    first_sample: u32,
    /// Photons of the current samples, with traced caustics.
    photons: Option<PhotonMap>,
    /// Guides of the first samples; `None` if they are not recorded.
    guides: Option<Arc<Vec<Guide>>>,
}

/// Rectangle of pixels: start and end of its columns `x` and its rows `y`.
#[derive(Clone, Copy)]
struct Tile {
    x: [u32; 2],
    y: [u32; 2],
}

impl Tile {
    fn columns(self) -> Range<u32> {
        self.x[0]..self.x[1]
    }
    fn rows(self) -> Range<u32> {
        self.y[0]..self.y[1]
    }
    fn pixels(self) -> Vec<(u32, u32)> {
        self.rows().flat_map(|y| self.columns().map(move |x| (x, y))).collect()
    }
}

/// Adds a value to the sum of a pixel.
fn add_to(sum: &mut [f32; 3], value: Vec3) {
    *sum = (Vec3::from(*sum) + value).into();
}

fn tiles(rect: Rect) -> Vec<Tile> {
    let starts = |start: u32, end: u32| (start..end).step_by(TILE as usize).map(move |at| [at, (at + TILE).min(end)]);
    let rows = starts(rect.y, rect.bottom());
    rows.flat_map(|y| starts(rect.x, rect.right()).map(move |x| Tile { x, y })).collect()
}

impl CpuJob {
    pub(crate) fn new(input: RenderInput, first_sample: u32) -> Self {
        let rect = Rect::of(input.frame.size());
        let (tiles, film) = (tiles(rect), Film::new(rect.width, rect.height));
        let guides = input.records_guides().then(Arc::default);
        Self { input, stats: None, rect, tiles, film, done: 0, begun: 0, first_sample, photons: None, guides }
    }

    /// Renders only some pixels; the film has only these.
    pub(crate) fn cropped(self, rect: Rect) -> Self {
        Self { rect, tiles: tiles(rect), film: Film::new(rect.width, rect.height), ..self }
    }

    /// Takes further samples only in these rectangles, whose corners are multiples of [`TILE`] from that of the film. The caller
    /// ensures that no sample is half done.
    pub(crate) fn restrict(&mut self, rects: &[Rect]) {
        self.tiles = rects.iter().flat_map(|rect| tiles(*rect)).collect();
    }

    /// Returns the film so far and starts a new one at the next sample. The caller ensures that no sample is half done.
    pub(crate) fn take(&mut self) -> Film {
        self.first_sample += self.film.samples;
        let empty = Film::new(self.film.width, self.film.height);
        std::mem::replace(&mut self.film, empty)
    }

    /// Configuration of its estimator.
    pub(crate) fn config(&self) -> &KernelConfig {
        &self.input.config
    }

    /// True if edges of emitters have further camera rays.
    pub(crate) fn traces_edges(&self) -> bool {
        self.input.edges.is_some()
    }

    /// Number of light paths of each sample, with traced caustics.
    pub(crate) fn light_paths(&self) -> Option<u32> {
        self.input.light_paths()
    }

    /// Index of the film's first sample.
    pub(crate) fn first_sample(&self) -> u32 {
        self.first_sample
    }

    /// Guides, if they are recorded.
    pub(crate) fn guides(&self) -> Option<Arc<Vec<Guide>>> {
        self.guides.clone()
    }

    /// Counts its rays in `stats`.
    pub(crate) fn with_stats(self, stats: Arc<RayCounters>) -> Self {
        Self { stats: Some(stats), ..self }
    }

    /// Starts again with the frame of `input`, see [`RenderInput::reframe`], from this sample on.
    pub(crate) fn reframe(&mut self, input: &RenderInput, first_sample: u32) {
        let (width, height) = (input.frame.width, input.frame.height);
        if (width, height) != (self.film.width, self.film.height) {
            self.rect = Rect::of([width, height]);
            self.tiles = tiles(self.rect);
        }
        (self.input.frame, self.input.edges, self.first_sample) = (input.frame, None, first_sample);
        self.film = Film::new(width, height);
        self.guides = self.guides.as_ref().map(|_| Arc::default());
        self.done = 0;
    }

    /// Finishes the samples that are begun, or renders one more of every pixel; several if they share a camera ray, but never
    /// beyond `upto`.
    pub(crate) fn advance(&mut self, upto: u32) {
        self.trace(self.tiles.len() - self.done, upto);
    }

    /// Renders further tiles of the next sample until `budget` is spent.
    pub(crate) fn advance_for(&mut self, budget: Duration) {
        let started = Instant::now();
        // Enough tiles to keep every core busy to the end.
        let batch = 4 * rayon::current_num_threads();
        loop {
            self.trace(batch, self.film.samples + 1);
            if started.elapsed() >= budget || self.done == 0 {
                return;
            }
        }
    }

    /// Renders the next tiles of samples towards `upto`, at most `count`.
    fn trace(&mut self, count: usize, upto: u32) {
        let sample = self.first_sample + self.film.samples;
        if self.is_whole() {
            let left = upto.saturating_sub(self.film.samples);
            self.begun = splitting::samples_sharing_ray(sample, self.input.config.splitting, left);
            self.photons = self.input.photon_map(sample);
        }
        let begun = self.begun;
        let tiles = &self.tiles[self.done..self.tiles.len().min(self.done + count)];
        let Rect { x: left, y: top, width, .. } = self.rect;
        // Films of more samples are shown as they are.
        let records_guides = self.guides.is_some() && self.film.samples < FILM_SAMPLES;
        let index = self.film.samples;
        let mut guides = self.guides.as_mut().filter(|_| records_guides).map(Arc::make_mut);
        if let Some(guides) = guides.as_mut().filter(|guides| guides.is_empty()) {
            **guides = rayon::iter::repeat_n(Guide::NONE, self.film.sums.len()).collect();
        }
        // All tiles of a row share its rows of pixels.
        let row_length = (TILE * width) as usize;
        let sums: Vec<_> = self.film.sums.chunks_mut(row_length).map(Mutex::new).collect();
        let guides = guides.map(Vec::as_mut_slice).unwrap_or_default();
        let guides: Vec<_> = guides.chunks_mut(row_length).map(Mutex::new).collect();
        let ctx = TraceContext { photons: self.photons.as_ref(), ..self.input.context(self.stats.as_deref()) };
        let add = |tile: &Tile| -> Vec<usize> {
            let pixels = tile.pixels();
            let row = (tile.y[0] - top) / TILE;
            let position = |(x, y): (u32, u32)| ((y - top - row * TILE) * width + x - left) as usize;
            let values = if records_guides {
                let (values, samples) = self.input.sample_with_guides(&ctx, &pixels, sample);
                let mut guides = guides[row as usize].lock().unwrap_or_else(PoisonError::into_inner);
                for ((&pixel, value), guide) in pixels.iter().zip(&values).zip(samples) {
                    let guide = guide.of_sample(kept(*value));
                    match (index, &mut guides[position(pixel)]) {
                        (0, first) => *first = guide,
                        (index, means) => means.add(&guide, index),
                    }
                }
                values
            } else {
                self.input.samples_of(&ctx, &pixels, sample, begun)
            };
            let edges = self.input.edges.as_ref();
            let at_edges = edges.map_or(Vec::new(), |edges| edges.within(tile.columns(), tile.rows()));
            let corrections = edges.map_or(Vec::new(), |edges| edges.corrections(&ctx, &at_edges, sample, begun));
            let mut rejected = Vec::new();
            let mut sums = sums[row as usize].lock().unwrap_or_else(PoisonError::into_inner);
            for (&pixel, values) in pixels.iter().zip(values.chunks(begun as usize)) {
                for value in values {
                    if is_kept(*value) {
                        add_to(&mut sums[position(pixel)], *value);
                    } else {
                        rejected.push(position(pixel) + row as usize * row_length);
                    }
                }
            }
            for (pixel, correction) in at_edges.into_iter().zip(corrections) {
                add_to(&mut sums[position(pixel)], correction);
            }
            rejected
        };
        let rejected: Vec<usize> = tiles.par_iter().flat_map_iter(add).collect();
        self.done += tiles.len();
        for pixel in rejected {
            self.film.count_rejected(pixel, 1);
        }
        if self.done == self.tiles.len() {
            self.done = 0;
            self.film.samples += begun;
        }
    }

    /// Samples of every pixel, with a fraction for one that is begun.
    pub(crate) fn samples_done(&self) -> f64 {
        f64::from(self.film.samples) + f64::from(self.begun) * self.done as f64 / self.tiles.len() as f64
    }

    /// True if every pixel has the same number of samples.
    pub(crate) fn is_whole(&self) -> bool {
        self.done == 0
    }

    /// Film so far; the caller ensures that no sample is half done.
    pub(crate) fn film(&self) -> &Film {
        &self.film
    }

    /// Number of samples in the sum of each pixel, those of a sample that is begun included.
    fn counts(&self) -> Vec<u32> {
        let mut counts = self.film.sample_counts();
        for tile in &self.tiles[..self.done] {
            for (x, y) in tile.pixels() {
                counts[((y - self.rect.y) * self.film.width + x - self.rect.x) as usize] += self.begun;
            }
        }
        counts
    }

    /// Mean of each pixel so far.
    pub(crate) fn means(&self) -> Vec<Vec3> {
        let sums = self.film.sums.par_iter().zip(self.counts());
        sums.map(|(sum, count)| Vec3::from(*sum) / count.max(1) as f32).collect()
    }

    /// Tone-maps the film so far to 8-bit codes: red, green, blue and 255 for each pixel.
    pub(crate) fn show(&self, display: &Display, mode: Mode) -> Vec<u8> {
        if mode != Mode::Variance {
            return display.encode_rgba(&self.means());
        }
        let uncertainty =
            |([sum, square, _], count): (&[f32; 3], u32)| Vec3::from(uncertainty_of(*sum, *square, count as f32));
        let colours: Vec<Vec3> = self.film.sums.par_iter().zip(self.counts()).map(uncertainty).collect();
        display.encode_rgba(&colours)
    }
}
