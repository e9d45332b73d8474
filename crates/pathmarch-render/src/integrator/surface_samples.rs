//! Random numbers of paths at their surfaces.

use super::path_state::Path;
use crate::sampling::sobol::{PixelSampler, pair};
use crate::scene::TraceContext;

/// Random numbers of paths at their surfaces, in the order of the paths.
pub(super) struct SurfaceSamples {
    /// Number of light samples at each surface.
    pub(super) light_samples: u32,
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
    pub(super) light_samples: u32,
    pub(super) choice: [f32; 2],
    pub(super) light: [f32; 2],
    pub(super) scatter: [f32; 2],
    pub(super) lobe: [f32; 2],
}

impl SurfaceSamples {
    pub(super) fn of(&self, path: usize) -> SurfaceSample {
        let (choice, light, scatter) = (self.choice[path], self.light[path], self.scatter[path]);
        let lobe = self.lobe.get(path).copied().unwrap_or_default();
        SurfaceSample { light_samples: self.light_samples, choice, light, scatter, lobe }
    }

    /// Random numbers of these paths, for the rays that leave their surfaces as number `part` of several. Lights are sampled with
    /// the first of them.
    pub(super) fn new(ctx: &TraceContext, paths: &[Path], surface_index: u32, part: u32) -> Self {
        let mut samplers: Vec<PixelSampler> = paths.iter().map(|path| path.sampler).collect();
        let samples_of = |samplers: &[PixelSampler], pair: u32| {
            PixelSampler::samples_2d(samplers, pair::PAIR_SURFACE + pair::PAIRS_PER_SURFACE * surface_index + pair)
        };
        let light_samples = match (surface_index, part) {
            (0, 0) => ctx.config.light_samples,
            (_, 0) => 1,
            _ => 0,
        };
        let [choice, light] = [pair::PAIR_CHOICE, pair::PAIR_LIGHT].map(|pair| match light_samples {
            // Russian roulette does not end paths at first surfaces.
            0 => vec![[0.0; 2]; paths.len()],
            _ => samples_of(&samplers, pair),
        });
        let parts = if surface_index == 0 { ctx.config.indirect_samples } else { 1 };
        if parts > 1 {
            samplers.iter_mut().for_each(|sampler| *sampler = sampler.part(part, parts));
        }
        let scatter = samples_of(&samplers, pair::PAIR_SCATTER);
        let lobe = if ctx.config.chooses_lobes { samples_of(&samplers, pair::PAIR_LOBE) } else { Vec::new() };
        Self { light_samples, choice, light, scatter, lobe }
    }
}
