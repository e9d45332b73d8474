//! Picture size, quality, and how light is followed.

/// Picture size and quality; the command line overrides them.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width and height, pixels, each 1 to 16,384.
    pub size: (u32, u32),
    /// Samples per pixel, 1 to 1,000,000.
    pub samples: u32,
    /// Scattering events after the first hit, 0 to 64.
    pub bounces: u32,
    /// How radiance becomes a display's colours.
    pub tonemap: Tonemap,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// What becomes of light that goes through clear glass.
    pub caustics: Caustics,
    /// The largest radiance that a contribution of light that bounced may have, W/(m² sr), above 0. Darkens what it
    /// limits; without it nothing is limited.
    pub clamp: Option<f32>,
    /// How near to a surface a ray ends, pixels as seen along the path so far, 0.001 to 10.
    pub detail: f32,
    /// Pictures of an animation in a second, above 0.
    pub fps: f32,
    /// For which part of a frame's time the shutter is open, 0 to 1; 0 is no motion blur.
    pub shutter: f32,
}

/// A tenth of a pixel: small against the half by which an edge may be off unnoticed.
pub const DETAIL: f32 = 0.1;

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            size: (1280, 720),
            samples: 256,
            bounces: 4,
            tonemap: Tonemap::default(),
            sampler: Sampler::default(),
            caustics: Caustics::default(),
            clamp: None,
            detail: DETAIL,
            fps: 24.0,
            shutter: 0.0,
        }
    }
}

/// Names the variants of an enum in the scene language, the default first.
macro_rules! named {
    ($type:ident { $($variant:ident = $name:literal),+ $(,)? }) => {
        impl $type {
            /// Every one, the default first.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Name in the scene language.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }
            /// The one of this name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| one.name() == name)
            }
        }
    };
}

/// How radiance becomes a display's colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tonemap {
    /// AgX: soft shoulder, bright colours fade to white.
    #[default]
    Agx,
    /// Khronos neutral: true colours until close to white.
    Neutral,
    /// Clipped and encoded, nothing else.
    Srgb,
}

named!(Tonemap { Agx = "agx", Neutral = "neutral", Srgb = "srgb" });

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Owen-scrambled Sobol' points: the samples of a pixel are spread evenly (Burley 2020).
    #[default]
    Sobol,
    /// Every number by itself: noisier, and the measure of the other.
    Independent,
}

named!(Sampler { Sobol = "sobol", Independent = "independent" });

/// What becomes of light that goes through clear glass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Caustics {
    /// Followed like all other light.
    #[default]
    Traced,
    /// Shadow rays go straight on through clear glass, weighed by Fresnel's law, its tint and what it absorbs: free of noise,
    /// and biased, for nothing is bent.
    Fast,
}

named!(Caustics { Traced = "traced", Fast = "fast" });
