//! What to render of a scene, and how well.

use pathmarch_scene::Scene;

/// The largest number of bounces a path may have.
pub const MAX_BOUNCES: u32 = 64;

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampler {
    /// Owen-scrambled Sobol' points: stratified over the samples and the pixels around.
    #[default]
    Sobol,
    /// Independent numbers: plain Monte Carlo, to compare with.
    Independent,
}

impl Sampler {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Sobol, Self::Independent];

    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
        }
    }

    /// The sampler of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|sampler| sampler.name() == name)
    }
}

/// Size, samples and limits of one picture. A picture is a pure function of the scene and these on one adapter.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples for each pixel.
    pub samples: u32,
    /// Index of the first sample: ranges rendered apart add up to the whole.
    pub first_sample: u32,
    /// Scattering events after the first hit; 0 is emitted and direct light only.
    pub bounces: u32,
    /// Pictures of different seeds have independent noise.
    pub seed: u32,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// Index into the scene's cameras.
    pub camera: usize,
}

impl Settings {
    /// What the scene itself asks for, seen by its first camera, seed 0.
    pub fn of(scene: &Scene) -> Self {
        Self {
            size: [scene.render.size.0, scene.render.size.1],
            samples: scene.render.samples,
            first_sample: 0,
            bounces: scene.render.bounces,
            seed: 0,
            sampler: Sampler::default(),
            camera: 0,
        }
    }
}
