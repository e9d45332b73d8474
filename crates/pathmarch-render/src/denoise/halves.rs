//! Half buffers: the samples of a picture in two halves with independent noise.
//!
//! **Idea.** The samples form blocks, which go to the halves in turn. The first blocks are single samples, so that few samples
//! have two halves as well; later ones are longer, about an eighth of all samples before them. So paths that share a camera ray stay
//! in one half, and the samples of a half are as evenly spread as all are: the difference of the halves would else exceed the noise. Each
//! half is a part of a film, so that its sums do not depend on where a render was interrupted.
//!
//! **Source.** Rousselle, Knaus, Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", section 4.

use crate::output::film::Film;
use crate::output::half_films::HalfFilms;
use crate::output::parts::{FilmPart, Rect, SampleRecorder};
use crate::settings::Settings;

/// First sample of each stage, and the length of its blocks. A stage has an even number of blocks.
const STAGES: [[u32; 2]; 7] = [[0, 1], [8, 2], [16, 8], [128, 16], [256, 32], [512, 64], [1024, 128]];

/// Samples of a picture in two halves.
#[derive(Clone, Debug)]
pub struct HalfBuffers {
    first_sample: u32,
    parts: [FilmPart; 2],
}

impl From<&HalfBuffers> for HalfFilms {
    fn from(buffers: &HalfBuffers) -> Self {
        Self::new(buffers.rect(), buffers.parts.each_ref().map(FilmPart::film), buffers.film())
    }
}

/// Samples that go to one half.
struct Block {
    half: usize,
    start: u32,
    end: u32,
}

impl HalfBuffers {
    /// Buffers without samples.
    pub fn new(settings: &Settings) -> Self {
        let part = FilmPart::new(settings.rect());
        Self::of([part.clone(), part], settings)
    }

    /// Buffers with the samples that [`parts`](Self::parts) had in an earlier render with these settings.
    pub fn of(parts: [FilmPart; 2], settings: &Settings) -> Self {
        Self { first_sample: settings.first_sample, parts }
    }

    /// Both halves.
    pub fn parts(&self) -> &[FilmPart; 2] {
        &self.parts
    }

    /// Pixels.
    pub fn rect(&self) -> Rect {
        self.parts[0].rect()
    }

    /// Number of samples.
    pub fn samples(&self) -> u32 {
        self.parts.iter().map(|part| part.samples().count()).sum()
    }

    /// All samples.
    pub fn film(&self) -> Film {
        let [first, second] = self.parts.clone();
        let mut whole = first;
        whole.absorb(second);
        whole.film()
    }

    /// Block of a sample.
    fn block(&self, sample: u32) -> Block {
        let offset = sample - self.first_sample;
        let [begin, length] = STAGES.into_iter().rfind(|[begin, _]| *begin <= offset).unwrap_or(STAGES[0]);
        let index = (offset - begin) / length;
        let start = self.first_sample + begin + index * length;
        Block { half: index as usize % 2, start, end: start.saturating_add(length) }
    }
}

impl SampleRecorder for HalfBuffers {
    fn end_of_sum(&self, first: u32) -> u32 {
        let Block { start, end, .. } = self.block(first);
        if start == first { end } else { first + 1 }
    }

    fn record(&mut self, first: u32, film: Film) {
        let Block { half, end, .. } = self.block(first);
        self.parts[half].record_in_block(first, film, end);
    }
}
