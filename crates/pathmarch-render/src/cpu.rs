//! The CPU backend: tiles over all cores, eight rays to a march. No driver, no adapter; always there.

use crate::film::Film;
use crate::frame::Prepared;
use crate::transport::trace;
use glam::Vec3;
use rayon::prelude::*;

/// Pixels along a tile's edge: enough paths to keep eight lanes full for most bounces, few enough for the caches.
const TILE: u32 = 16;

/// A picture being rendered on the CPU.
pub(crate) struct CpuJob {
    prepared: Prepared,
    tiles: Vec<Vec<(u32, u32)>>,
    film: Film,
    first_sample: u32,
}

impl CpuJob {
    pub(crate) fn new(prepared: Prepared, first_sample: u32) -> Self {
        let (width, height) = (prepared.frame.width, prepared.frame.height);
        let tiles = (0..height)
            .step_by(TILE as usize)
            .flat_map(|y| (0..width).step_by(TILE as usize).map(move |x| (x, y)))
            .map(|(x0, y0)| {
                (y0..(y0 + TILE).min(height)).flat_map(|y| (x0..(x0 + TILE).min(width)).map(move |x| (x, y))).collect()
            })
            .collect();
        Self { prepared, tiles, film: Film::new(width, height), first_sample }
    }

    /// Renders one more sample of every pixel.
    pub(crate) fn advance(&mut self) {
        let sample = self.first_sample + self.film.samples;
        let trace = trace(self.prepared.mode);
        let rendered: Vec<_> = self.tiles.par_iter().map(|pixels| trace(&self.prepared, pixels, sample)).collect();
        for (pixels, values) in self.tiles.iter().zip(rendered) {
            for (&(x, y), value) in pixels.iter().zip(values) {
                let pixel = (y * self.film.width + x) as usize;
                // As the kernel, so that both leave out the same samples; comparisons with NaN are false.
                if value.cmpge(Vec3::ZERO).all() && value.cmplt(Vec3::splat(1e30)).all() {
                    for (sum, value) in self.film.sums[pixel].iter_mut().zip(value.to_array()) {
                        *sum += value;
                    }
                } else {
                    self.film.leave_out(pixel, 1);
                }
            }
        }
        self.film.samples += 1;
    }

    pub(crate) fn film(&self) -> &Film {
        &self.film
    }
}
