//! Render settings: size of the picture, quality, estimator.
//!
//! The rows of [`RENDER`] below are the one place that knows a render setting: the field of [`RenderSettings`], its
//! default, its range, its unit and its help. Scene files, the window and the command line follow from them. What remains
//! for a new setting is its use in the renderer and its line in docs/scene-language.md, which a test compares.

use super::{Range, Setting, SettingKind, SettingValue, setting};

/// Width and height of a picture, pixels: smallest and largest.
pub const SIDE: (u32, u32) = (1, 16_384);
/// Samples for each pixel: fewest and most.
pub const SAMPLES: (u32, u32) = (1, 1_000_000);
/// Scattering events after the first hit: fewest and most.
pub const BOUNCES: (u32, u32) = (0, 1000);
/// Largest radiance of a contribution of light that bounced, W/(m² sr).
pub const CLAMP: Range = Range::POSITIVE;
/// Distance from a surface at which a ray ends, pixels as seen.
pub const DETAIL: Range = Range::from_to(0.001, 10.0);
/// Frames in a second.
pub const FPS: Range = Range { max: 1000.0, ..Range::POSITIVE };
/// Fraction of a frame's time for which the shutter is open.
pub const SHUTTER: Range = Range::from_to(0.0, 1.0);

/// Declares [`RenderSettings`] and its table [`RENDER`], a row for each field:
/// `field: Type = default => { kind, unit, example, doc }`.
macro_rules! render_settings {
    ($($field:ident: $type:ty = $default:expr => {
        kind: $kind:ident($($argument:expr),*),
        unit: $unit:literal,
        example: $example:literal,
        doc: $doc:literal,
        $(label: $label:literal,)?
    })*) => {
        /// Size of the picture and quality. Options of the command line override those of a scene.
        #[derive(Clone, Debug, PartialEq)]
        pub struct RenderSettings {
            $(#[doc = $doc] pub $field: $type,)*
        }

        impl RenderSettings {
            /// The settings of a scene without `render`.
            pub const DEFAULT: Self = Self { $($field: $default,)* };

            /// Value of the setting of this name.
            pub fn get(&self, name: &str) -> Option<SettingValue> {
                match name {
                    $(stringify!($field) => Some(self.$field.into_value()),)*
                    _ => None,
                }
            }
            /// Sets the setting of this name. Returns false, and changes nothing, for an unknown name and a value that the
            /// setting does not accept.
            pub fn set(&mut self, name: &str, value: SettingValue) -> bool {
                let accepted = RENDER.iter().any(|setting| setting.name == name && setting.kind.accepts(value));
                match name {
                    $(stringify!($field) if accepted => {
                        Field::from_value(value).map(|value| self.$field = value).is_some()
                    })*
                    _ => false,
                }
            }
        }

        /// The render settings: in scene files in the braces of `render`, on the command line options of the same names.
        pub const RENDER: &[Setting] = &[$(
            setting(
                stringify!($field),
                kind::$kind($($argument,)* RenderSettings::DEFAULT.$field),
                $unit,
                $example,
                $doc,
            )$(.labelled($label))?,
        )*];
    };
}

render_settings! {
    size: (u32, u32) = (1280, 720) => {
        kind: size(SIDE),
        unit: "px",
        example: "size 1280 720",
        doc: "Width and height of the picture.",
    }
    samples: u32 = 256 => {
        kind: whole(SAMPLES),
        unit: "",
        example: "samples 256",
        doc: "Paths for each pixel.",
    }
    bounces: u32 = 4 => {
        kind: whole(BOUNCES),
        unit: "",
        example: "bounces 4",
        doc: "Scattering events after the first hit; 0 is emitted and direct light only.",
    }
    tonemap: Tonemap = Tonemap::Agx => {
        kind: choice("tone mapping", Tonemap::names),
        unit: "",
        example: "tonemap \"agx\"",
        doc: "Tone curve of the screen, PNG and JPEG; never applied to EXR.",
        label: "tone mapping",
    }
    sampler: Sampler = Sampler::Sobol => {
        kind: choice("sampler", Sampler::names),
        unit: "",
        example: "sampler \"sobol\"",
        doc: "Random numbers: evenly spread, or each independent of the others, to compare with.",
    }
    caustics: Caustics = Caustics::Sampled => {
        kind: choice("kind of caustics", Caustics::names),
        unit: "",
        example: "caustics \"traced\"",
        doc: "Light over mirrors and clear glass: found by camera paths (sampled), by paths from the lights (traced), or \
              passed straight on through glass by shadow rays (fast), which is biased.",
    }
    estimator: DirectLighting = DirectLighting::Mis => {
        kind: choice("estimator of direct light", DirectLighting::names),
        unit: "",
        example: "estimator \"mis\"",
        doc: "Direct light: by sampling lights and BSDFs (mis), or one of both alone (light, bsdf), to compare with.",
    }
    clamp: Option<f32> = None => {
        kind: optional(CLAMP),
        unit: "W/(m² sr)",
        example: "clamp 10",
        doc: "Largest channel of a contribution of light that bounced, against fireflies; darkens.",
    }
    detail: f32 = 0.1 => {
        kind: number(DETAIL),
        unit: "px",
        example: "detail 0.1",
        doc: "Distance from a surface at which a ray ends, as it is seen: smaller shows finer detail, and costs steps.",
    }
    fps: f32 = 24.0 => {
        kind: number(FPS),
        unit: "/s",
        example: "fps 24",
        doc: "Frames of an animation in a second.",
    }
    shutter: f32 = 0.0 => {
        kind: number(SHUTTER),
        unit: "",
        example: "shutter 0.5",
        doc: "Fraction of a frame's time for which the shutter is open: motion blur; 0 is none.",
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Kinds of render settings, each with the default as its last argument.
mod kind {
    use super::{Range, SettingKind};

    pub(super) const fn size(range: (u32, u32), default: (u32, u32)) -> SettingKind {
        SettingKind::Size { range, default }
    }
    pub(super) const fn whole(range: (u32, u32), default: u32) -> SettingKind {
        SettingKind::Whole { range, default }
    }
    pub(super) const fn number(range: Range, default: f32) -> SettingKind {
        SettingKind::Number { range, default: Some(default) }
    }
    pub(super) const fn optional(range: Range, default: Option<f32>) -> SettingKind {
        SettingKind::Number { range, default }
    }
    /// The default is the first name.
    pub(super) const fn choice<T: Copy>(noun: &'static str, names: fn() -> Vec<&'static str>, _: T) -> SettingKind {
        SettingKind::Choice { noun, names }
    }
}

/// A type of a render setting.
trait Field: Copy {
    fn into_value(self) -> SettingValue;
    fn from_value(value: SettingValue) -> Option<Self>;
}

impl Field for u32 {
    fn into_value(self) -> SettingValue {
        SettingValue::Whole(self)
    }
    fn from_value(value: SettingValue) -> Option<Self> {
        if let SettingValue::Whole(number) = value { Some(number) } else { None }
    }
}

impl Field for (u32, u32) {
    fn into_value(self) -> SettingValue {
        SettingValue::Size(self)
    }
    fn from_value(value: SettingValue) -> Option<Self> {
        if let SettingValue::Size(size) = value { Some(size) } else { None }
    }
}

impl Field for f32 {
    fn into_value(self) -> SettingValue {
        SettingValue::Number(self)
    }
    fn from_value(value: SettingValue) -> Option<Self> {
        if let SettingValue::Number(number) = value { Some(number) } else { None }
    }
}

impl Field for Option<f32> {
    fn into_value(self) -> SettingValue {
        self.map_or(SettingValue::Absent, SettingValue::Number)
    }
    fn from_value(value: SettingValue) -> Option<Self> {
        match value {
            SettingValue::Absent => Some(None),
            SettingValue::Number(number) => Some(Some(number)),
            _ => None,
        }
    }
}

/// Names the variants of an enum in the scene language, the default first.
macro_rules! named {
    ($type:ident { $($variant:ident = $name:literal),+ $(,)? }) => {
        impl $type {
            /// All variants, the default first.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Name in the scene language.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }
            /// Names of all variants.
            pub fn names() -> Vec<&'static str> {
                Self::ALL.map(Self::name).to_vec()
            }
            /// The variant of this name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|one| one.name() == name)
            }
        }

        impl Field for $type {
            fn into_value(self) -> SettingValue {
                SettingValue::Choice(self.name())
            }
            fn from_value(value: SettingValue) -> Option<Self> {
                if let SettingValue::Choice(name) = value { Self::from_name(name) } else { None }
            }
        }
    };
}

/// Tone curve from radiance to the colours of a display.
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

/// Source of random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Owen-scrambled Sobol' points: the samples of a pixel are spread evenly (Burley 2020).
    #[default]
    Sobol,
    /// Independent numbers: noisier, and the baseline to measure the other by.
    Independent,
}

named!(Sampler { Sobol = "sobol", Independent = "independent" });

/// Treatment of light that mirrors and clear glass throw on other surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Caustics {
    /// Found by camera paths that hit the light by chance: that of a light without size is not found.
    #[default]
    Sampled,
    /// Found by paths from the lights, which are aimed at mirrors and clear glass. Its blur of a few pixels vanishes as samples add
    /// up.
    Traced,
    /// Shadow rays pass straight through clear glass, weighted by Fresnel's law, its tint and its absorption: free of noise,
    /// but biased, because nothing is refracted.
    Fast,
}

named!(Caustics { Sampled = "sampled", Traced = "traced", Fast = "fast" });

/// Estimator of direct light from lights that a path can hit, that is from all but points and suns without size. All
/// estimators converge to the same picture; those other than [`Mis`](Self::Mis) are for comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DirectLighting {
    /// Light and BSDF sampling, combined by multiple importance sampling.
    #[default]
    Mis,
    /// Light sampling alone (next-event estimation), at every surface whose BSDF is not a delta distribution.
    LightSampling,
    /// BSDF sampling alone: paths hit lights by chance.
    BsdfSampling,
}

named!(DirectLighting { Mis = "mis", LightSampling = "light", BsdfSampling = "bsdf" });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_accepts_its_own_default() {
        for setting in RENDER {
            let value = RenderSettings::DEFAULT.get(setting.name).expect("a field");
            assert!(setting.kind.accepts(value), "{}", setting.name);
            let mut settings = RenderSettings::DEFAULT;
            assert!(settings.set(setting.name, value) && settings == RenderSettings::DEFAULT, "{}", setting.name);
        }
    }

    #[test]
    fn a_value_out_of_range_or_of_another_kind_is_refused() {
        let mut settings = RenderSettings::DEFAULT;
        assert!(settings.set("samples", SettingValue::Whole(7)) && settings.samples == 7);
        assert!(settings.set("clamp", SettingValue::Number(2.0)) && settings.clamp == Some(2.0));
        assert!(settings.set("tonemap", SettingValue::Choice("srgb")) && settings.tonemap == Tonemap::Srgb);
        for (name, value) in [
            ("samples", SettingValue::Whole(0)),
            ("samples", SettingValue::Number(1.0)),
            ("detail", SettingValue::Absent),
            ("detail", SettingValue::Number(f32::NAN)),
            ("tonemap", SettingValue::Choice("film")),
            ("size", SettingValue::Size((0, 5))),
            ("speed", SettingValue::Whole(1)),
        ] {
            let before = settings.clone();
            assert!(!settings.set(name, value) && settings == before, "{name} {value:?}");
        }
    }
}
