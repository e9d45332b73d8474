//! How large a picture can be to be ready in time.
//!
//! The cost of a pixel is learnt from what was traced. While things move, the size is what fits the time of a frame;
//! once they rest it doubles until the whole size is reached, so that a slow scene is seen at once and sharpens: the
//! levels before the last cost a third of it together.

use std::time::Duration;

/// The shorter side is never below this many pixels, or the picture's own.
const LEAST_SIDE: u32 = 48;
/// A picture of the whole size that is ready within this time is shown at once.
const AT_ONCE: f64 = 0.25;
/// A pixel's time until one is known, seconds: that of a slow scene on two cores, so that there soon is some picture.
const GUESS: f64 = 5e-6;

/// What a sample of a pixel costs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    seconds_per_pixel: Option<f64>,
}

impl Pace {
    /// Learns that samples of so many pixels took this long.
    pub(super) fn learn(&mut self, pixels: f64, took: Duration) {
        if pixels > 0.0 {
            let new = took.as_secs_f64() / pixels;
            // Half of the old: one odd measurement does not make the picture jump.
            self.seconds_per_pixel = Some(self.seconds_per_pixel.map_or(new, |old| 0.5 * (old + new)));
        }
    }

    /// Seconds that a sample of a picture takes.
    pub(super) fn seconds(&self, [width, height]: [u32; 2]) -> f64 {
        self.seconds_per_pixel.unwrap_or(GUESS) * f64::from(width) * f64::from(height)
    }

    /// The largest size of the shape of `whole` that is traced within `time`.
    pub(super) fn size_within(&self, whole: [u32; 2], time: Duration) -> [u32; 2] {
        let factor = (time.as_secs_f64() / self.seconds(whole)).sqrt();
        // In steps of an eighth of an octave, so that the size does not change with every frame.
        let factor = if factor < 1.0 { ((factor.log2() * 8.0).floor() / 8.0).exp2() } else { 1.0 };
        scaled(whole, factor)
    }

    /// The size that follows `level` once nothing moves.
    pub(super) fn next_level(&self, level: [u32; 2], whole: [u32; 2]) -> [u32; 2] {
        let doubled = f64::from(level[0]) * 2.0 / f64::from(whole[0]);
        if self.seconds(whole) <= AT_ONCE || doubled > 0.75 { whole } else { scaled(whole, doubled) }
    }
}

/// A size of the shape of `whole`, within limits.
fn scaled(whole: [u32; 2], factor: f64) -> [u32; 2] {
    let shorter = whole[0].min(whole[1]);
    let least = (f64::from(LEAST_SIDE) / f64::from(shorter)).min(1.0);
    let factor = factor.clamp(least, 1.0);
    whole.map(|side| ((f64::from(side) * factor).round() as u32).clamp(1, side))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: [u32; 2] = [1280, 720];

    fn pace(seconds_for_whole: f64) -> Pace {
        let mut pace = Pace::default();
        pace.learn(1280.0 * 720.0, Duration::from_secs_f64(seconds_for_whole));
        pace
    }

    #[test]
    fn a_fast_scene_has_its_whole_size_and_a_slow_one_what_fits() {
        assert_eq!(pace(0.01).size_within(WHOLE, Duration::from_millis(30)), WHOLE);
        for seconds in [0.05, 0.3, 1.0, 4.0] {
            let size = pace(seconds).size_within(WHOLE, Duration::from_millis(30));
            let time = pace(seconds).seconds(size);
            assert!(time <= 0.0301 && time > 0.02, "{seconds}: {size:?} in {time}");
        }
        // Never so small that nothing can be made out.
        assert_eq!(pace(1000.0).size_within(WHOLE, Duration::from_millis(30)), [85, 48]);
        assert_eq!(pace(1000.0).size_within([20, 10], Duration::from_millis(1)), [20, 10]);
    }

    #[test]
    fn levels_double_to_the_whole_and_stop_there() {
        let (slow, mut level, mut levels) = (pace(4.0), [85, 48], Vec::new());
        while level != WHOLE {
            level = slow.next_level(level, WHOLE);
            levels.push(level);
            assert!(levels.len() < 8, "{levels:?}");
        }
        let cost: f64 = levels.iter().map(|&level| slow.seconds(level)).sum();
        assert!(cost < 4.0 * 1.6, "{levels:?}: {cost} s");
        assert_eq!(pace(0.2).next_level([85, 48], WHOLE), WHOLE);
    }
}
