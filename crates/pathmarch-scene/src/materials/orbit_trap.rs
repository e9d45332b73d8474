//! Orbit traps: a colour by what the orbit of a fractal's point comes near to (Pickover and Khorasani 1985; for solids
//! Quilez 2009, "Mandelbulb"). The orbit is followed once, where a ray has hit; the march knows nothing of it.

use crate::textures::Ramp;

/// Geometry that traps orbits: the numbers of [`Field::orbit`](pathmarch_field::Field::orbit), in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trap {
    /// The centre: least distance.
    Point,
    /// The line through the centre along y: least distance.
    Line,
    /// The plane through the centre across y: least distance.
    Plane,
    /// The sphere of radius one about the centre: least distance.
    Sphere,
    /// The centre: largest distance.
    Farthest,
    /// Not a trap: fraction of all iterations after which the orbit escaped, 0 to 1.
    Iterations,
}

impl Trap {
    /// All of them, in the order of the orbit's numbers.
    pub const ALL: [Self; 6] = [Self::Point, Self::Line, Self::Plane, Self::Sphere, Self::Farthest, Self::Iterations];

    /// Name in the scene language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Line => "line",
            Self::Plane => "plane",
            Self::Sphere => "sphere",
            Self::Farthest => "farthest",
            Self::Iterations => "iterations",
        }
    }
}

/// The colour of a fractal's surface by its orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitTrap {
    /// Geometry of the trap.
    pub trap: Trap,
    /// Centre of the trap, in the local coordinates of the fractal.
    pub centre: [f32; 3],
    /// Values of the trap at the first and the last colour.
    pub range: [f32; 2],
    /// Colours over the range.
    pub ramp: Ramp,
}

impl OrbitTrap {
    /// Position of an orbit's value in the range, 0 to 1.
    pub fn place(&self, orbit: &[f32]) -> f32 {
        let value = orbit.get(self.trap as usize).copied().unwrap_or_default();
        let [from, to] = self.range;
        // Equal ends are a step.
        let span = if from == to { 1e-20 } else { to - from };
        ((value - from) / span).clamp(0.0, 1.0)
    }

    /// The colour for the numbers of an orbit.
    pub fn colour(&self, orbit: &[f32]) -> [f32; 3] {
        self.ramp.colour(self.place(orbit))
    }
}

#[cfg(test)]
mod tests {
    use super::{OrbitTrap, Ramp, Trap};

    #[test]
    fn colours_are_evenly_spaced_and_end_at_both_ends() {
        let mut trap = OrbitTrap {
            trap: Trap::Line,
            centre: [0.0; 3],
            range: [1.0, 3.0],
            ramp: Ramp::even(vec![[0.0; 3], [1.0, 0.5, 0.0], [1.0; 3]]),
        };
        for (value, colour) in [
            (-9.0, [0.0; 3]),
            (1.5, [0.5, 0.25, 0.0]),
            (2.0, [1.0, 0.5, 0.0]),
            (2.5, [1.0, 0.75, 0.5]),
            (9.0, [1.0; 3]),
        ] {
            assert_eq!(trap.colour(&[7.0, value, 7.0, 7.0, 7.0]), colour, "{value}");
        }
        trap.range = [3.0, 1.0];
        assert_eq!(trap.colour(&[7.0, 2.5, 7.0, 7.0, 7.0]), [0.5, 0.25, 0.0]);
        trap.ramp.colours.truncate(1);
        assert_eq!(trap.colour(&[7.0, 2.5, 7.0, 7.0, 7.0]), [0.0; 3]);
    }
}
