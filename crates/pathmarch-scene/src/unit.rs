//! Unit of length of a scene.

/// Unit of the lengths of a scene, by which reports and exports convert them. Pictures do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetre.
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    #[default]
    M,
    /// Inch.
    In,
}

impl LengthUnit {
    /// All units, the default first.
    pub const ALL: [Self; 4] = [Self::M, Self::Cm, Self::Mm, Self::In];

    /// Name in scenes, and symbol in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::In => "in",
        }
    }

    /// Metres in a unit.
    pub fn metres(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::Cm => 0.01,
            Self::M => 1.0,
            Self::In => 0.0254,
        }
    }

    /// Unit of this name.
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }
}
