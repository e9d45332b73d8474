//! Colour ramps: the colours between which a value from 0 to 1 is interpolated linearly.

use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3};
use wide::f32x8;

/// Colours along values from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// Linear Rec. 709; at least one.
    pub colours: Vec<[f32; 3]>,
    /// Value of each colour, never falling; `None` if they are evenly spaced from 0 to 1. Two colours at one value make an
    /// edge.
    pub positions: Option<Vec<f32>>,
}

impl Ramp {
    /// Ramp of colours that are evenly spaced from 0 to 1; at least one.
    pub fn even(colours: Vec<[f32; 3]>) -> Self {
        Self { colours, positions: None }
    }

    /// All positions of a ramp: the first is 0 and the last is 1 unless given, and those between two given ones are evenly
    /// spaced. One that falls takes the place of the last one before it. Given positions are from 0 to 1.
    pub fn spaced(given: &[Option<f32>]) -> Vec<f32> {
        let last = given.len().saturating_sub(1);
        let mut highest = f32::MIN;
        let rising: Vec<Option<f32>> = given
            .iter()
            .map(|position| {
                highest = position.map_or(highest, |position| position.max(highest));
                position.map(|_| highest)
            })
            .collect();
        let known = |k: usize| match k {
            0 => Some(rising[0].unwrap_or(0.0)),
            _ if k == last => Some(rising[last].unwrap_or(1.0)),
            _ => rising[k],
        };
        let mut positions = Vec::with_capacity(given.len());
        let mut from = (0, 0.0);
        for k in 0..given.len() {
            if let Some(position) = known(k) {
                from = (k, position);
            }
            let next = (k..given.len()).find_map(|next| Some((next, known(next)?))).unwrap_or(from);
            let part = if next.0 == from.0 { 0.0 } else { (k - from.0) as f32 / (next.0 - from.0) as f32 };
            positions.push(from.1 + (next.1 - from.1) * part);
        }
        positions
    }

    /// Colour of a value; those outside of 0 to 1 have that of the nearer end.
    pub fn colour(&self, value: f32) -> [f32; 3] {
        let value = value.clamp(0.0, 1.0);
        let last = self.colours.len().saturating_sub(1);
        let (first, part) = match &self.positions {
            None => {
                let place = value * last as f32;
                let first = (place as usize).min(last.saturating_sub(1));
                (first, place - first as f32)
            }
            Some(positions) => {
                let above = positions.iter().take_while(|position| **position <= value).count();
                if above == 0 || above > last {
                    return self.colours[above.min(last)];
                }
                let [from, to] = [positions[above - 1], positions[above]];
                (above - 1, (value - from) / (to - from))
            }
        };
        let (a, b) = (self.colours[first], self.colours[(first + 1).min(last)]);
        std::array::from_fn(|k| a[k] + (b[k] - a[k]) * part)
    }

    /// Colours of eight values, as [`colour`](Self::colour).
    pub fn colours(&self, values: f32x8) -> FieldVec3<f32x8> {
        if let ([a, b], None) = (&self.colours[..], &self.positions) {
            let part = Real::clamp(values, f32x8::ZERO, f32x8::ONE);
            let [r, g, b] = [0, 1, 2].map(|k| f32x8::splat(a[k]) + part * (b[k] - a[k]));
            return FieldVec3::new(r, g, b);
        }
        let colours = values.to_array().map(|value| self.colour(value));
        let [r, g, b] = [0, 1, 2].map(|k| f32x8::from(colours.map(|colour| colour[k])));
        FieldVec3::new(r, g, b)
    }

    /// Average colour.
    pub fn mean(&self) -> [f32; 3] {
        let colours = self.colours.iter().map(|colour| Vec3::from(*colour));
        let Some(positions) = &self.positions else {
            return (colours.sum::<Vec3>() / self.colours.len().max(1) as f32).into();
        };
        let colours: Vec<Vec3> = colours.collect();
        let between = |k: usize| (colours[k] + colours[k + 1]) * (0.5 * (positions[k + 1] - positions[k]));
        let inside: Vec3 = (0..colours.len() - 1).map(between).sum();
        let ends = colours[0] * positions[0] + colours[colours.len() - 1] * (1.0 - positions[positions.len() - 1]);
        (inside + ends).into()
    }
}

#[cfg(test)]
mod tests {
    use super::Ramp;

    #[test]
    fn positions_that_are_not_given_are_evenly_spaced() {
        assert_eq!(Ramp::spaced(&[None, None, None]), [0.0, 0.5, 1.0]);
        let spaced = Ramp::spaced(&[Some(0.25), None, None, Some(0.625), None]);
        assert_eq!(spaced, [0.25, 0.375, 0.5, 0.625, 1.0]);
        assert_eq!(Ramp::spaced(&[Some(0.6), Some(0.4), None]), [0.6, 0.6, 1.0]);
        assert_eq!((Ramp::spaced(&[None]), Ramp::spaced(&[])), (vec![0.0], vec![]));
    }

    #[test]
    fn positions_at_even_spaces_change_nothing() {
        let colours = vec![[0.0; 3], [1.0, 0.5, 0.0], [1.0; 3], [0.2, 0.3, 0.4], [0.5; 3]];
        let even = Ramp::even(colours.clone());
        let positioned = Ramp { colours, positions: Some(vec![0.0, 0.25, 0.5, 0.75, 1.0]) };
        for k in -8..=40 {
            let value = k as f32 / 32.0;
            assert_eq!(even.colour(value), positioned.colour(value), "{value}");
        }
    }

    #[test]
    fn colours_beyond_the_ends_are_constant_and_two_at_a_value_are_an_edge() {
        let ramp =
            Ramp { colours: vec![[0.2; 3], [0.4; 3], [0.8; 3], [1.0; 3]], positions: Some(vec![0.25, 0.5, 0.5, 0.75]) };
        for (value, grey) in [(-1.0, 0.2), (0.1, 0.2), (0.375, 0.3), (0.499_999, 0.4), (0.5, 0.8), (0.625, 0.9)] {
            assert!((ramp.colour(value)[0] - grey).abs() < 1e-5, "{value}: {:?}", ramp.colour(value));
        }
        assert_eq!([0.75, 0.9, 7.0].map(|value| ramp.colour(value)), [[1.0; 3]; 3]);
        // Areas under the five pieces.
        let mean = 0.25 * 0.2 + 0.25 * 0.3 + 0.25 * 0.9 + 0.25 * 1.0;
        assert!((ramp.mean()[0] - mean).abs() < 1e-6, "{:?}", ramp.mean());
    }
}
