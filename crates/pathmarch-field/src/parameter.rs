//! Parameter specification: name, unit, default, range and documentation of one number of a shape or operator.
//!
//! The parser, the reference page, the window's controls and the tests read the same [`Param`].

use std::borrow::Cow;

/// Unit of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Metres,
    /// Degrees.
    Degrees,
    /// A whole number.
    Count,
    /// One of the axes x, y and z, as 0, 1 and 2.
    Axis,
    /// A number without unit.
    Ratio,
}

impl Unit {
    /// Text printed after a value.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Degrees => "°",
            Self::Count => "count",
            Self::Axis => "axis",
            Self::Ratio => "",
        }
    }
}

/// Specification of one parameter of a shape, operator or texture.
#[derive(Clone, Debug)]
pub struct Param {
    /// Name in the scene language.
    pub name: Cow<'static, str>,
    /// Unit of its values.
    pub unit: Unit,
    /// Value used when none is given.
    pub default: f32,
    /// Smallest allowed value.
    pub min: f32,
    /// True if `min` itself is allowed.
    pub min_allowed: bool,
    /// Largest allowed value.
    pub max: f32,
    /// One line of documentation.
    pub doc: Cow<'static, str>,
}

impl Param {
    /// Specification of a length above zero, metres.
    pub const fn length(name: &'static str, default: f32, doc: &'static str) -> Self {
        let (name, doc) = (Cow::Borrowed(name), Cow::Borrowed(doc));
        Self { name, unit: Unit::Metres, default, min: 0.0, min_allowed: false, max: f32::MAX, doc }
    }
    /// Specification of a length of zero or more, metres.
    pub const fn length_or_zero(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self::between(name, default, 0.0, f32::MAX, doc).with_unit(Unit::Metres)
    }
    /// Specification of any finite number, e.g. a component of a direction.
    pub const fn any(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self::between(name, default, f32::MIN, f32::MAX, doc)
    }
    /// Specification of a number from `min` to `max`.
    pub const fn between(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        let (name, doc) = (Cow::Borrowed(name), Cow::Borrowed(doc));
        Self { name, unit: Unit::Ratio, default, min, min_allowed: true, max, doc }
    }
    /// Specification of a whole number from `min` to `max`.
    pub const fn count(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self::between(name, default, min, max, doc).with_unit(Unit::Count)
    }
    /// Specification of an axis.
    pub const fn axis(name: &'static str, doc: &'static str) -> Self {
        Self::between(name, 0.0, 0.0, 2.0, doc).with_unit(Unit::Axis)
    }
    /// Sets the unit.
    pub const fn with_unit(mut self, unit: Unit) -> Self {
        self.unit = unit;
        self
    }
    /// Sets the default.
    pub const fn with_default(mut self, default: f32) -> Self {
        self.default = default;
        self
    }
    /// Reports whether `value` is finite and within the range.
    pub fn accepts(&self, value: f32) -> bool {
        value.is_finite() && (value > self.min || self.min_allowed && value == self.min) && value <= self.max
    }
    /// Description of the range, to follow "must be", e.g. "above 0".
    pub fn range_in_words(&self) -> String {
        let whole = if self.unit == Unit::Count { "a whole number " } else { "" };
        match (self.min > f32::MIN, self.max < f32::MAX) {
            (true, true) => format!("{whole}from {} to {}", self.min, self.max),
            (true, false) if self.min_allowed => format!("{whole}{} or more", self.min),
            (true, false) => format!("{whole}above {}", self.min),
            (false, true) => format!("{whole}at most {}", self.max),
            (false, false) => format!("{whole}any finite number"),
        }
    }
}
