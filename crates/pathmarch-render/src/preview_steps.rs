//! Steps of the preview, which can be left out one by one: those of Carvalho 2020, section 3.3.

use crate::wgsl::shared_constants;

/// Step of the preview.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreviewStep {
    /// Colours of the surfaces.
    Albedo,
    /// Diffuse light.
    Diffuse,
    /// Highlights of lights, and ambient light that surfaces reflect.
    Specular,
    /// Shadows of lights.
    Shadows,
    /// Occlusion of ambient light.
    Occlusion,
    /// Mirror images.
    Reflection,
}

impl PreviewStep {
    /// All steps, in the order in which the thesis adds them.
    pub const ALL: [Self; 6] =
        [Self::Albedo, Self::Diffuse, Self::Specular, Self::Shadows, Self::Occlusion, Self::Reflection];

    /// Name, as the command line and windows show it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
            Self::Shadows => "shadows",
            Self::Occlusion => "occlusion",
            Self::Reflection => "reflection",
        }
    }

    /// What the preview shows with this step and without it.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Albedo => "Colours of the surfaces; without it, all are light grey.",
            Self::Diffuse => "Diffuse light; without it, colours are flat.",
            Self::Specular => "Highlights of lights, and ambient light that surfaces reflect.",
            Self::Shadows => "Shadows of the strongest lights.",
            Self::Occlusion => "Occlusion of ambient light near other surfaces.",
            Self::Reflection => "Mirror images; without it, mirrors reflect ambient light.",
        }
    }

    const fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// Set of steps of the preview. The default has all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PreviewSteps(u32);

impl Default for PreviewSteps {
    fn default() -> Self {
        Self((1 << PreviewStep::ALL.len()) - 1)
    }
}

impl PreviewSteps {
    /// True if the set contains a step.
    pub fn has(self, step: PreviewStep) -> bool {
        self.0 & step.bit() != 0
    }

    /// Adds a step or removes it.
    pub fn set(&mut self, step: PreviewStep, is_on: bool) {
        self.0 = if is_on { self.0 | step.bit() } else { self.0 & !step.bit() };
    }

    /// The set without a step.
    pub fn without(mut self, step: PreviewStep) -> Self {
        self.set(step, false);
        self
    }

    /// The set as bits of `FrameUniforms::preview_steps`.
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    /// The set of these bits.
    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

shared_constants! {
    /// Albedo of all surfaces if the preview leaves out their colours.
    pub(crate) const GREY_ALBEDO: f32 = 0.8;
    /// Bit of the step.
    const STEP_ALBEDO: u32 = PreviewStep::Albedo.bit();
    /// Bit of the step.
    const STEP_DIFFUSE: u32 = PreviewStep::Diffuse.bit();
    /// Bit of the step.
    const STEP_SPECULAR: u32 = PreviewStep::Specular.bit();
    /// Bit of the step.
    const STEP_SHADOWS: u32 = PreviewStep::Shadows.bit();
    /// Bit of the step.
    const STEP_OCCLUSION: u32 = PreviewStep::Occlusion.bit();
    /// Bit of the step.
    const STEP_REFLECTION: u32 = PreviewStep::Reflection.bit();
}
