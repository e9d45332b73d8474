//! Ranges of numbers.

/// The numbers that a parameter or setting accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end; `f32::MIN` without a limit.
    pub min: f32,
    /// True if `min` itself is allowed.
    pub min_allowed: bool,
    /// Upper end; `f32::MAX` without a limit.
    pub max: f32,
    /// True if `max` itself is allowed.
    pub max_allowed: bool,
}

impl Range {
    /// Every finite number.
    pub const ANY: Self = Self::from_to(f32::MIN, f32::MAX);
    /// Zero or more.
    pub const NOT_NEGATIVE: Self = Self::from_to(0.0, f32::MAX);
    /// More than zero.
    pub const POSITIVE: Self = Self { min_allowed: false, ..Self::NOT_NEGATIVE };

    /// Range that includes both ends.
    pub const fn from_to(min: f32, max: f32) -> Self {
        Self { min, min_allowed: true, max, max_allowed: true }
    }
    /// Range that excludes both ends.
    pub const fn between(min: f32, max: f32) -> Self {
        Self { min, min_allowed: false, max, max_allowed: false }
    }
    /// True if the number is in the range; false for NaN and infinities.
    pub fn accepts(self, value: f32) -> bool {
        (value > self.min || self.min_allowed && value == self.min)
            && (value < self.max || self.max_allowed && value == self.max)
    }
    /// The range in words, as in "must be …".
    pub fn in_words(self) -> String {
        let Self { min, max, .. } = self;
        match (min > f32::MIN, max < f32::MAX) {
            (true, true) if self.min_allowed => format!("from {min} to {max}"),
            (true, true) if self.max_allowed => format!("above {min} and at most {max}"),
            (true, true) => format!("above {min} and below {max}"),
            (true, false) if self.min_allowed => format!("{min} or more"),
            (true, false) => format!("above {min}"),
            (false, true) => format!("at most {max}"),
            (false, false) => "a finite number".to_owned(),
        }
    }
}
