//! Parts of a film: sums of samples that merge to the same bits in any order and grouping.
//!
//! **Idea.** Sums of floats depend on their order. Here the order is fixed where it matters, and does not matter elsewhere. The
//! samples of a pixel form blocks of [`BLOCK`], which start at multiples of it. Within a block they are added one after the
//! other, as a backend does it; the sums of blocks are added exactly (`exact_sums`). A part that starts within a block keeps the samples up to
//! the end of that block one by one, so that they can follow those of another part. So every way to divide a picture, into ranges of
//! samples, tiles or both, gives the picture of one render, to the last bit, if one backend renders all parts.
//!
//! **Cost.** 49 bytes a pixel once a block is complete, and 12 for the block that is not, or for each sample before the first
//! complete block. Parts that start at multiples of 16 are the smallest.

mod exact_sums;
mod file;
mod identity;
mod merge;
mod sample_set;

use crate::output::film::Film;
use exact_sums::ExactSums;
pub use file::{FilmFile, FilmFileError, FilmHeader, Region, save};
pub use identity::Identity;
pub use merge::{MergeError, merge};
pub use sample_set::SampleSet;
use std::collections::BTreeMap;

/// Number of samples that are added one after the other.
pub const BLOCK: u32 = 16;

/// Receiver of the samples that a job renders.
pub trait SampleRecorder {
    /// End of the samples from `first` on that may be recorded as one sum.
    fn end_of_sum(&self, first: u32) -> u32;
    /// Records the sums of consecutive samples from `first` on, up to [`end_of_sum`](Self::end_of_sum).
    fn record(&mut self, first: u32, film: Film);
}

/// Rectangle of pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Rect {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// Rectangle of a whole picture.
    pub fn of([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
    /// Column after the last.
    pub fn right(&self) -> u32 {
        self.x.saturating_add(self.width)
    }
    /// Row after the last.
    pub fn bottom(&self) -> u32 {
        self.y.saturating_add(self.height)
    }
    /// True if it contains all pixels of another.
    pub fn contains(&self, other: &Self) -> bool {
        self.x <= other.x && self.y <= other.y && other.right() <= self.right() && other.bottom() <= self.bottom()
    }
    /// Pixels of both; `None` if there are none.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let (right, bottom) = (self.right().min(other.right()), self.bottom().min(other.bottom()));
        (x < right && y < bottom).then(|| Self { x, y, width: right - x, height: bottom - y })
    }
}

impl std::fmt::Display for Rect {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}x{}+{}+{}", self.width, self.height, self.x, self.y)
    }
}

/// Consecutive samples of one block.
#[derive(Clone, Debug, PartialEq)]
struct Layer {
    samples: u32,
    sums: Vec<[f32; 3]>,
}

impl Layer {
    /// Adds samples that follow.
    fn append(&mut self, next: &Self) {
        add(&mut self.sums, &next.sums);
        self.samples += next.samples;
    }
}

/// Samples of the pixels of a rectangle.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmPart {
    rect: Rect,
    /// Samples of complete blocks, and their sums.
    blocks: SampleSet,
    sums: ExactSums,
    /// Samples of incomplete blocks by their first: several that a block starts with, or single ones behind a gap.
    layers: BTreeMap<u32, Layer>,
    /// Number of rejected samples of each pixel; empty if no sample was rejected.
    rejected: Vec<u32>,
}

impl FilmPart {
    /// Part without samples.
    pub fn new(rect: Rect) -> Self {
        let (sums, rejected) = (ExactSums::default(), Vec::new());
        Self { rect, blocks: SampleSet::default(), sums, layers: BTreeMap::new(), rejected }
    }

    /// Pixels.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Indices of its samples.
    pub fn samples(&self) -> SampleSet {
        let mut samples = self.blocks.clone();
        self.layers.iter().for_each(|(first, layer)| samples.insert(*first..first + layer.samples));
        samples
    }

    /// Counts the rejected samples of a film.
    fn count_rejected(&mut self, film: &Film) {
        if film.non_finite() > 0 {
            let counts = film.sample_counts().into_iter().map(|count| film.samples - count);
            self.rejected.resize(self.rect.pixels(), 0);
            self.rejected.iter_mut().zip(counts).for_each(|(rejected, more)| *rejected += more);
        }
    }

    /// Records the sums of samples from `first` on, which belong to a block of any length that ends at `end`. Its samples have to
    /// come in their order, and no other block may be begun before it is complete.
    pub(crate) fn record_in_block(&mut self, first: u32, film: Film, end: u32) {
        debug_assert!(film.sums.len() == self.rect.pixels() && first + film.samples <= end);
        if film.samples == 0 {
            return;
        }
        self.count_rejected(&film);
        let more = Layer { samples: film.samples, sums: film.sums };
        let (start, layer) = match self.layers.pop_first() {
            Some((start, mut layer)) => {
                debug_assert!(start + layer.samples == first);
                layer.append(&more);
                (start, layer)
            }
            None => (first, more),
        };
        if start + layer.samples == end {
            self.sums.add(&layer.sums);
            self.blocks.insert(start..end);
        } else {
            self.layers.insert(start, layer);
        }
    }

    /// Adds samples that follow the start of a block to it, and a complete block to the sums.
    fn complete(&mut self, block: u32) {
        let start = block * BLOCK;
        let Some(mut layer) = self.layers.remove(&start) else { return };
        while layer.samples < BLOCK {
            let Some(next) = self.layers.remove(&(start + layer.samples)) else { break };
            layer.append(&next);
        }
        if layer.samples == BLOCK {
            self.sums.add(&layer.sums);
            self.blocks.insert(start..start + BLOCK);
        } else {
            self.layers.insert(start, layer);
        }
    }

    /// Adds the samples of another part of the same pixels; they must not overlap.
    pub(crate) fn absorb(&mut self, other: Self) {
        if !other.sums.is_empty() {
            self.sums.merge(&other.sums);
        }
        self.blocks = self.blocks.union(&other.blocks);
        if !other.rejected.is_empty() {
            self.rejected.resize(self.rect.pixels(), 0);
            self.rejected.iter_mut().zip(&other.rejected).for_each(|(rejected, more)| *rejected += more);
        }
        self.layers.extend(other.layers);
        let blocks: Vec<u32> = self.layers.keys().map(|first| first / BLOCK).collect();
        blocks.into_iter().for_each(|block| self.complete(block));
    }

    /// Film of all samples.
    pub fn film(&self) -> Film {
        let mut sums = self.sums.clone();
        if sums.is_empty() {
            sums = ExactSums::new(self.rect.pixels());
        }
        let mut layers = self.layers.iter().peekable();
        while let Some((first, layer)) = layers.next() {
            let (mut run, mut end) = (layer.sums.clone(), first + layer.samples);
            // Consecutive samples of a block are added in their order.
            while let Some((_, next)) = layers.next_if(|(next, _)| **next == end && *next % BLOCK != 0) {
                add(&mut run, &next.sums);
                end += next.samples;
            }
            sums.add(&run);
        }
        let mut film = Film::new(self.rect.width, self.rect.height);
        (film.samples, film.sums) = (self.samples().count(), sums.values());
        self.rejected.iter().enumerate().for_each(|(pixel, rejected)| film.count_rejected(pixel, *rejected));
        film
    }

    /// The samples of some of its pixels.
    fn crop(&self, rect: Rect) -> Self {
        if rect == self.rect {
            return self.clone();
        }
        let layers = self.layers.iter().map(|(first, layer)| {
            let sums = self.cropped(&layer.sums, rect);
            (*first, Layer { samples: layer.samples, sums })
        });
        Self {
            rect,
            blocks: self.blocks.clone(),
            sums: ExactSums { tops: self.cropped(&self.sums.tops, rect), bins: self.cropped(&self.sums.bins, rect) },
            layers: layers.collect(),
            rejected: self.cropped(&self.rejected, rect),
        }
    }

    fn cropped<T: Copy>(&self, values: &[T], rect: Rect) -> Vec<T> {
        if values.is_empty() {
            return Vec::new();
        }
        let start = |y: u32| (y - self.rect.y) as usize * self.rect.width as usize + (rect.x - self.rect.x) as usize;
        (rect.y..rect.bottom()).flat_map(|y| values[start(y)..][..rect.width as usize].iter().copied()).collect()
    }

    /// Part of other pixels with the same samples, all zero, to be filled by [`paste`](Self::paste).
    fn blank(&self, rect: Rect) -> Self {
        let pixels = rect.pixels();
        let layers = self
            .layers
            .iter()
            .map(|(first, layer)| (*first, Layer { samples: layer.samples, sums: vec![[0.0; 3]; pixels] }));
        let sums = if self.sums.is_empty() { ExactSums::default() } else { ExactSums::new(pixels) };
        Self { rect, blocks: self.blocks.clone(), sums, layers: layers.collect(), rejected: Vec::new() }
    }

    /// Sets the pixels that another part with the same samples has.
    fn paste(&mut self, part: &Self) {
        let pixels = self.rect.pixels();
        if !part.rejected.is_empty() {
            self.rejected.resize(pixels, 0);
        }
        let width = part.rect.width as usize;
        for y in part.rect.y..part.rect.bottom() {
            let from = (y - part.rect.y) as usize * width;
            let to = (y - self.rect.y) as usize * self.rect.width as usize + (part.rect.x - self.rect.x) as usize;
            let copy = [from..from + width, to..to + width];
            set(&mut self.sums.tops, &part.sums.tops, &copy);
            set(&mut self.sums.bins, &part.sums.bins, &copy);
            set(&mut self.rejected, &part.rejected, &copy);
            for (layer, other) in self.layers.values_mut().zip(part.layers.values()) {
                set(&mut layer.sums, &other.sums, &copy);
            }
        }
    }
}

impl SampleRecorder for FilmPart {
    fn end_of_sum(&self, first: u32) -> u32 {
        if first.is_multiple_of(BLOCK) { first.saturating_add(BLOCK) } else { first + 1 }
    }

    fn record(&mut self, first: u32, film: Film) {
        debug_assert!(film.sums.len() == self.rect.pixels() && first + film.samples <= self.end_of_sum(first));
        if film.samples == 0 {
            return;
        }
        self.count_rejected(&film);
        self.layers.insert(first, Layer { samples: film.samples, sums: film.sums });
        self.complete(first / BLOCK);
    }
}

/// Copies a range of `from` to one of `to`, unless `from` is empty.
fn set<T: Copy>(to: &mut [T], from: &[T], [source, target]: &[std::ops::Range<usize>; 2]) {
    if !from.is_empty() {
        to[target.clone()].copy_from_slice(&from[source.clone()]);
    }
}

fn add(sums: &mut [[f32; 3]], more: &[[f32; 3]]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum = std::array::from_fn(|k| sum[k] + more[k]);
    }
}
