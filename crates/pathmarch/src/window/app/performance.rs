//! History of frame times and sample rates, for the plots.

use pathmarch_render::live::LiveImage;
use std::collections::VecDeque;
use std::time::Instant;

/// Number of pictures in the history.
const REMEMBERED: usize = 240;

/// Frame times and sample rates of recent pictures.
#[derive(Default)]
pub(crate) struct PerformanceHistory {
    /// Milliseconds since the previous picture, and samples of the whole picture per second.
    pub(crate) history: VecDeque<(f64, f64)>,
    last: Option<Instant>,
}

impl PerformanceHistory {
    pub(crate) fn picture(&mut self, shown: &LiveImage, samples_per_second: f64) {
        if let Some(last) = self.last {
            let milliseconds = shown.at.duration_since(last).as_secs_f64() * 1e3;
            self.history.push_back((milliseconds, samples_per_second));
            while self.history.len() > REMEMBERED {
                self.history.pop_front();
            }
        }
        self.last = Some(shown.at);
    }
}
