//! Timings on standard error, for `view --timings`: start-up milestones and frame times.

use super::App;
use std::time::Duration;

impl App {
    /// Prints the time since start-up, once for each milestone.
    pub(crate) fn log_milestone(&mut self, what: &'static str, detail: &str) {
        if self.options.timings && !self.milestones.contains(&what) {
            self.milestones.push(what);
            eprintln!("{:8.1} ms  {what} {detail}", self.started.elapsed().as_secs_f64() * 1e3);
        }
    }

    /// Records the duration of a frame, and the milestones it reaches.
    pub(crate) fn frame_drawn(&mut self, took: Duration) {
        if !self.options.timings {
            return;
        }
        self.frame_times.push(took.as_secs_f64() * 1e3);
        self.log_milestone("window drawn", "");
        let whole = self.ordered.as_ref().map(|order| order.settings.size);
        if let Some((_, _, size)) = self.open.as_ref().and_then(|open| open.view.picture.as_ref()) {
            let size = *size;
            self.log_milestone("first picture", &format!("of {}x{} pixels", size[0], size[1]));
            if Some(size) == whole {
                self.log_milestone("whole picture", &format!("of {}x{} pixels", size[0], size[1]));
                if self.live.status().resting {
                    self.log_milestone("all samples", "");
                }
            }
        }
    }

    /// Prints statistics of the frame times.
    pub(super) fn report_frame_times(&mut self) {
        self.frame_times.sort_by(f64::total_cmp);
        if let (Some(longest), count) = (self.frame_times.last(), self.frame_times.len()) {
            let at = |share: f64| self.frame_times[((count - 1) as f64 * share) as usize];
            eprintln!(
                "{count} frames of the window: median {:.1} ms, 95 % below {:.1} ms, longest {longest:.1} ms",
                at(0.5),
                at(0.95)
            );
        }
    }
}
