//! Timings on standard error, for `view --timings`: milestones of the start, and times of frames.

use super::App;
use std::time::Duration;

impl App {
    /// Says how long it took from the start to something that happens once.
    pub(crate) fn milestone(&mut self, what: &'static str, detail: &str) {
        if self.options.timings && !self.milestones.contains(&what) {
            self.milestones.push(what);
            eprintln!("{:8.1} ms  {what} {detail}", self.started.elapsed().as_secs_f64() * 1e3);
        }
    }

    /// A frame is on the screen, after this long.
    pub(crate) fn painted(&mut self, took: Duration) {
        if !self.options.timings {
            return;
        }
        self.frames.push(took.as_secs_f64() * 1e3);
        self.milestone("window drawn", "");
        let whole = self.ordered.as_ref().map(|order| order.settings.size);
        if let Some((_, _, size)) = self.open.as_ref().and_then(|open| open.view.picture.as_ref()) {
            let size = *size;
            self.milestone("first picture", &format!("of {}x{} pixels", size[0], size[1]));
            if Some(size) == whole {
                self.milestone("whole picture", &format!("of {}x{} pixels", size[0], size[1]));
                if self.live.status().resting {
                    self.milestone("all samples", "");
                }
            }
        }
    }

    /// Says how long frames of the window took.
    pub(super) fn report_frames(&mut self) {
        self.frames.sort_by(f64::total_cmp);
        if let (Some(longest), count) = (self.frames.last(), self.frames.len()) {
            let at = |share: f64| self.frames[((count - 1) as f64 * share) as usize];
            eprintln!(
                "{count} frames of the window: median {:.1} ms, 95 % below {:.1} ms, longest {longest:.1} ms",
                at(0.5),
                at(0.95)
            );
        }
    }
}
