//! Picture sizes that can be rendered in a given time.
//!
//! The cost of a pixel is measured while rendering. While something moves, the size fits the frame time. Once nothing moves,
//! the size doubles with each level until it is the full one, so that a slow scene appears at once and is then refined. All
//! levels before the last together cost a third of the last.

use std::time::Duration;

/// Least length of the shorter side, pixels, unless the full size is smaller.
const MIN_SIDE: u32 = 48;
/// Time of a full-size sample below which all smaller levels are skipped, seconds.
const SKIP_LEVELS_BELOW: f64 = 0.25;
/// Time of a pixel before the first measurement, seconds: that of a slow scene on two cores, so that a picture appears soon.
const INITIAL_SECONDS_PER_PIXEL: f64 = 5e-6;

/// Measured time of a sample of one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    seconds_per_pixel: Option<f64>,
}

impl Pace {
    /// Updates the pace: samples of `pixels` pixels took this long.
    pub(super) fn learn(&mut self, pixels: f64, took: Duration) {
        if pixels > 0.0 {
            let new = took.as_secs_f64() / pixels;
            // Averages with the last measurement, so that the picture's size does not jump.
            self.seconds_per_pixel = Some(self.seconds_per_pixel.map_or(new, |old| 0.5 * (old + new)));
        }
    }

    /// Time of a sample of every pixel of a picture, seconds.
    pub(super) fn seconds(&self, [width, height]: [u32; 2]) -> f64 {
        self.seconds_per_pixel.unwrap_or(INITIAL_SECONDS_PER_PIXEL) * f64::from(width) * f64::from(height)
    }

    /// Largest size of the aspect ratio of `full` that renders within `time`.
    pub(super) fn size_within(&self, full: [u32; 2], time: Duration) -> [u32; 2] {
        let factor = (time.as_secs_f64() / self.seconds(full)).sqrt();
        // Steps of an eighth of an octave, so that the size does not change with every frame.
        let factor = if factor < 1.0 { ((factor.log2() * 8.0).floor() / 8.0).exp2() } else { 1.0 };
        scaled(full, factor)
    }

    /// Size of the level after `level` once nothing moves.
    pub(super) fn next_level(&self, level: [u32; 2], full: [u32; 2]) -> [u32; 2] {
        let doubled = f64::from(level[0]) * 2.0 / f64::from(full[0]);
        if self.seconds(full) <= SKIP_LEVELS_BELOW || doubled > 0.75 { full } else { scaled(full, doubled) }
    }
}

/// Scales `full`, but not below the least side.
fn scaled(full: [u32; 2], factor: f64) -> [u32; 2] {
    let shorter = full[0].min(full[1]);
    let least = (f64::from(MIN_SIDE) / f64::from(shorter)).min(1.0);
    let factor = factor.clamp(least, 1.0);
    full.map(|side| ((f64::from(side) * factor).round() as u32).clamp(1, side))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: [u32; 2] = [1280, 720];

    fn pace(seconds_for_full: f64) -> Pace {
        let mut pace = Pace::default();
        pace.learn(1280.0 * 720.0, Duration::from_secs_f64(seconds_for_full));
        pace
    }

    #[test]
    fn a_fast_scene_has_its_full_size_and_a_slow_one_a_size_that_fits() {
        assert_eq!(pace(0.01).size_within(FULL, Duration::from_millis(30)), FULL);
        for seconds in [0.05, 0.3, 1.0, 4.0] {
            let size = pace(seconds).size_within(FULL, Duration::from_millis(30));
            let time = pace(seconds).seconds(size);
            assert!(time <= 0.0301 && time > 0.02, "{seconds}: {size:?} in {time}");
        }
        // The size has a lower limit.
        assert_eq!(pace(1000.0).size_within(FULL, Duration::from_millis(30)), [85, 48]);
        assert_eq!(pace(1000.0).size_within([20, 10], Duration::from_millis(1)), [20, 10]);
    }

    #[test]
    fn levels_double_up_to_the_full_size() {
        let (slow, mut level, mut levels) = (pace(4.0), [85, 48], Vec::new());
        while level != FULL {
            level = slow.next_level(level, FULL);
            levels.push(level);
            assert!(levels.len() < 8, "{levels:?}");
        }
        let cost: f64 = levels.iter().map(|&level| slow.seconds(level)).sum();
        assert!(cost < 4.0 * 1.6, "{levels:?}: {cost} s");
        assert_eq!(pace(0.2).next_level([85, 48], FULL), FULL);
    }
}
