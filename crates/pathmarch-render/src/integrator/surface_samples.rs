//! Random numbers of paths at their surfaces.

use super::path_state::Path;
use crate::sampling::sobol::{PixelSampler, pair};
use crate::scene::TraceContext;

/// Random numbers of paths at their surfaces, in the order of the paths.
pub(super) struct SurfaceSamples {
    /// Choice of the light (x) and Russian roulette (y).
    pub(super) choice: Vec<[f32; 2]>,
    /// Position on the light.
    pub(super) light: Vec<[f32; 2]>,
    /// Direction of the scattered ray.
    pub(super) scatter: Vec<[f32; 2]>,
    /// Choice of the lobe (x) and of the wavelength (y); empty if no BSDF chooses lobes.
    lobe: Vec<[f32; 2]>,
}

/// Random numbers of one path; see [`SurfaceSamples`].
pub(super) struct SurfaceSample {
    pub(super) choice: [f32; 2],
    pub(super) light: [f32; 2],
    pub(super) scatter: [f32; 2],
    pub(super) lobe: [f32; 2],
}

impl SurfaceSamples {
    pub(super) fn of(&self, path: usize) -> SurfaceSample {
        let (choice, light, scatter) = (self.choice[path], self.light[path], self.scatter[path]);
        SurfaceSample { choice, light, scatter, lobe: self.lobe.get(path).copied().unwrap_or_default() }
    }

    pub(super) fn new(ctx: &TraceContext, paths: &[Path], surface_index: u32) -> Self {
        let samplers: Vec<PixelSampler> = paths.iter().map(|path| path.sampler).collect();
        let samples_of = |pair: u32| {
            PixelSampler::samples_2d(&samplers, pair::PAIR_SURFACE + pair::PAIRS_PER_SURFACE * surface_index + pair)
        };
        Self {
            choice: samples_of(pair::PAIR_CHOICE),
            light: samples_of(pair::PAIR_LIGHT),
            scatter: samples_of(pair::PAIR_SCATTER),
            lobe: if ctx.config.chooses_lobes { samples_of(pair::PAIR_LOBE) } else { Vec::new() },
        }
    }
}
