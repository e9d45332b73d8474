//! Parameter specification: name, unit, default, range and documentation of one number of a shape or operator.
//!
//! The parser, the reference page, the window's controls and the tests read the same [`Param`].

/// What a number of a shape measures.
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
    /// As printed after a number.
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

/// One number of a shape or operator.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// Name in the scene language.
    pub name: &'static str,
    /// What it measures.
    pub unit: Unit,
    /// Value when not given.
    pub default: f32,
    /// Smallest allowed value.
    pub min: f32,
    /// Whether `min` itself is allowed.
    pub min_allowed: bool,
    /// Largest allowed value.
    pub max: f32,
    /// One line for people.
    pub doc: &'static str,
}

impl Param {
    /// A length above zero, metres.
    pub const fn length(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Metres, default, min: 0.0, min_allowed: false, max: f32::MAX, doc }
    }
    /// A length of zero or more, metres.
    pub const fn length_or_zero(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { min_allowed: true, ..Self::length(name, default, doc) }
    }
    /// A component of a direction or position: any number.
    pub const fn any(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Ratio, default, min: f32::MIN, min_allowed: true, max: f32::MAX, doc }
    }
    /// A number from `min` to `max`.
    pub const fn between(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Ratio, default, min, min_allowed: true, max, doc }
    }
    /// A whole number from `min` to `max`.
    pub const fn count(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self { unit: Unit::Count, ..Self::between(name, default, min, max, doc) }
    }
    /// An axis.
    pub const fn axis(name: &'static str, doc: &'static str) -> Self {
        Self { unit: Unit::Axis, ..Self::between(name, 0.0, 0.0, 2.0, doc) }
    }
    /// Whether `value` is finite and within the range.
    pub fn accepts(&self, value: f32) -> bool {
        value.is_finite() && (value > self.min || self.min_allowed && value == self.min) && value <= self.max
    }
    /// The range in words, as in "must be above 0".
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
