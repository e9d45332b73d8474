//! What a person may change of a node: values, controls, and what may be added.

use crate::settings::Range;
use std::borrow::Cow;

/// The value of a control.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Not given, and nothing stands for it: no limit, no material of its own.
    None,
    /// One number.
    Number(f32),
    /// A position, a direction, or angles about three axes.
    Triple([f32; 3]),
    /// Linear Rec. 709.
    Colour([f32; 3]),
    /// Width and height, pixels.
    Size([u32; 2]),
    /// A name, a path, or one of a list of words.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// Numbers of which one at least is a formula, each as text: one for a number, two for a size, three for a triple, one
    /// or three for a colour. [`Control::present`] says what they are worth. A text that is a number becomes one.
    Formulas(Vec<String>),
}

/// What a control holds, and which values it takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ControlKind {
    /// A [`Value::Number`].
    Number(NumberRange),
    /// A [`Value::Triple`] of any finite numbers.
    Triple {
        /// Whether it is a direction, which may have any length but zero.
        direction: bool,
    },
    /// A [`Value::Colour`], each channel from 0 to `max`; `f32::MAX` for radiance.
    Colour {
        /// The largest value of a channel.
        max: f32,
    },
    /// A [`Value::Text`], one of these.
    Choice(Vec<Cow<'static, str>>),
    /// A [`Value::Text`] that is not empty.
    Text,
    /// A [`Value::Text`]: the path of a `.hdr` or `.exr` file, relative to the scene file.
    Picture,
    /// A [`Value::Flag`].
    Flag,
    /// A [`Value::Text`], the name of one of these materials; or [`Value::None`] for that of what it stands in.
    Material(Vec<String>),
    /// A [`Value::Size`].
    Size {
        /// The smallest width and height.
        min: u32,
        /// The largest width and height.
        max: u32,
    },
}

/// The numbers that are allowed, and those that a slider should cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberRange {
    /// Smallest value; `f32::MIN` where there is no limit.
    pub min: f32,
    /// Whether `min` itself is allowed.
    pub min_allowed: bool,
    /// Largest value; `f32::MAX` where there is no limit.
    pub max: f32,
    /// Whether `max` itself is allowed.
    pub max_allowed: bool,
    /// Whether only whole numbers are allowed.
    pub whole: bool,
    /// Smallest and largest value of a slider: within the limits, wide enough for most scenes.
    pub soft: (f32, f32),
    /// Whether a slider is better logarithmic: sizes and intensities.
    pub logarithmic: bool,
}

/// One parameter of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Names the parameter to [`Document::set`](super::Document::set); unlike every other key of the node.
    pub key: Cow<'static, str>,
    /// Name for people.
    pub label: Cow<'static, str>,
    /// One sentence: what it does.
    pub doc: Cow<'static, str>,
    /// As printed after a number; empty without unit.
    pub unit: &'static str,
    /// What it holds.
    pub kind: ControlKind,
    /// The present value: that in the text, else the default.
    pub value: Value,
    /// The value without formulas: what it is worth now. The default where that is not known.
    pub present: Value,
    /// The value when the text has none; [`Value::None`] where nothing stands for it.
    pub default: Value,
    /// What to set when it is switched on: the default where there is one.
    pub initial: Value,
    /// Whether it stands in the text.
    pub given: bool,
    /// Whether it must stand in the text, so that it cannot be reset.
    pub required: bool,
}

impl NumberRange {
    fn range(&self) -> Range {
        let Self { min, min_allowed, max, max_allowed, .. } = *self;
        Range { min, min_allowed, max, max_allowed }
    }
    /// Whether `value` is finite and within the range.
    pub fn accepts(&self, value: f32) -> bool {
        value.is_finite() && self.range().accepts(value) && (!self.whole || value.fract() == 0.0)
    }
    /// The range in words, as in "must be above 0".
    pub fn in_words(&self) -> String {
        format!("{}{}", if self.whole { "a whole number " } else { "" }, self.range().in_words())
    }
}

impl Control {
    /// A control without unit, whose value is the default.
    pub(super) fn new(
        key: impl Into<Cow<'static, str>>,
        label: impl Into<Cow<'static, str>>,
        doc: impl Into<Cow<'static, str>>,
        kind: ControlKind,
        default: Value,
    ) -> Self {
        let [value, present, initial] = std::array::from_fn(|_| default.clone());
        let (key, label, doc) = (key.into(), label.into(), doc.into());
        Self { key, label, doc, unit: "", kind, value, present, default, initial, given: false, required: false }
    }
    pub(super) fn required(self) -> Self {
        Self { required: true, ..self }
    }
}

/// What an addition, or a group of them in a menu, is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// An object that consists of a shape.
    Object,
    /// A shape, in an object or an operator.
    Shape,
    /// An operator, in an object or an operator.
    Operator,
    /// A material.
    Material,
    /// A sun or a point.
    Light,
    /// What surrounds the scene.
    Sky,
    /// A camera.
    Camera,
    /// Picture size and quality.
    Render,
    /// A number with a name, which formulas use.
    Param,
}

impl Group {
    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "Object",
            Self::Shape => "Shape",
            Self::Operator => "Operator",
            Self::Material => "Material",
            Self::Light => "Light",
            Self::Sky => "Sky",
            Self::Camera => "Camera",
            Self::Render => "Render",
            Self::Param => "Parameter",
        }
    }
}

/// Something that may be added to a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Addition {
    /// What it is.
    pub group: Group,
    /// Its name in the scene language: of the shape, operator, kind of material or of sky, or of the node.
    pub name: Cow<'static, str>,
    /// One sentence for people.
    pub doc: Cow<'static, str>,
}
