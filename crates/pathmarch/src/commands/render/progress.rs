//! Progress of a render: a bar on a terminal, lines in a log, JSON lines for other programs.

use crate::commands::progress_bar;
use indicatif::ProgressBar;
use pathmarch_cli::{note, outln};
use pathmarch_render::Settings;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two lines in a log.
const LOG_INTERVAL: Duration = Duration::from_secs(30);
/// Time between two lines of JSON.
const JSON_INTERVAL: Duration = Duration::from_secs(1);
/// Steps of the bar.
const STEPS: f64 = 10_000.0;

/// Progress of a command.
pub(super) struct Progress {
    json: bool,
    bar: ProgressBar,
    started: Instant,
    /// Time limit of a picture, seconds.
    limit: Option<f64>,
    said: Mutex<Option<Instant>>,
    /// Estimates of the pictures that are being rendered, by their index.
    errors: Mutex<HashMap<usize, ErrorEstimate>>,
}

/// Work on one picture among others.
#[derive(Clone, Copy)]
pub(super) struct Picture {
    /// Its index among all pictures, and their number.
    pub(super) index: usize,
    pub(super) count: usize,
    pub(super) frame: Option<u32>,
    pub(super) started: Instant,
    /// Samples that were done before this run.
    pub(super) before: u32,
    pub(super) samples: u32,
}

impl Progress {
    pub(super) fn new(json: bool, limit: Option<f64>) -> Self {
        let bar = if json { ProgressBar::hidden() } else { progress_bar(STEPS as u64) };
        let (said, errors) = (Mutex::default(), Mutex::default());
        Self { json, bar, started: Instant::now(), limit, said, errors }
    }

    /// Says that the scene is being prepared, which takes long with many textures.
    pub(super) fn preparing(&self, scene: &str) {
        self.bar.set_message(format!("preparing {scene}"));
        self.bar.enable_steady_tick(Duration::from_millis(200));
        self.event("preparing", [("scene", json!(scene))]);
    }

    /// Prints an event as a line of JSON, if that was asked for.
    pub(super) fn event<const N: usize>(&self, event: &str, values: [(&str, Value); N]) {
        self.print(event, values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect());
    }

    fn print(&self, event: &str, values: Map<String, Value>) {
        if self.json {
            let mut line = Map::from_iter([("event".to_owned(), json!(event))]);
            line.extend(values);
            outln!("{}", Value::Object(line));
        }
    }

    /// Runs something that prints, without the bar in between.
    pub(super) fn suspend(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Shows progress: `done` samples of this run.
    pub(super) fn show(&self, picture: &Picture, done: f64, settings: &Settings) {
        let seconds = picture.started.elapsed().as_secs_f64();
        let to_do = f64::from(picture.samples - picture.before);
        let total_done = picture.before + done as u32;
        let rate = done / seconds.max(1e-9);
        let message = format!("{total_done}/{} samples, {rate:.2} samples/s", picture.samples);
        self.report(picture, done / to_do.max(1.0), &message, || {
            let errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
            let error = errors.get(&picture.index).and_then(|error| error.after(total_done, settings));
            let samples = f64::from(picture.before) + done;
            vec![("samples", json!(samples)), ("of", json!(picture.samples)), ("relative_error", json!(error))]
        });
    }

    /// Shows progress of adaptive sampling: the share of its work that is done, of all of it once that is known.
    pub(super) fn show_share(&self, picture: &Picture, share: f64, is_planned: bool) {
        let message = if is_planned { "samples where the noise is" } else { "pilot samples" };
        // The time that is left is unknown before.
        let share = if is_planned { share } else { 0.0 };
        self.report(picture, share, message, || vec![("share", json!(share))]);
    }

    /// Shows the share of a picture's work that is done, in a bar, a log, or as JSON with further `values`.
    fn report(
        &self,
        picture: &Picture,
        share: f64,
        message: &str,
        values: impl FnOnce() -> Vec<(&'static str, Value)>,
    ) {
        let seconds = picture.started.elapsed().as_secs_f64();
        let share = share.max(self.limit.map_or(0.0, |limit| seconds / limit)).clamp(0.0, 1.0);
        let all = (picture.index as f64 + share) / picture.count as f64;
        let total = self.started.elapsed().as_secs_f64();
        let left = (all > 0.0).then(|| total / all - total);
        self.bar.set_position((all * STEPS) as u64);
        let frame = picture.frame.map(|frame| format!("frame {frame} ({}/{}), ", picture.index + 1, picture.count));
        let message = format!("{}{message}", frame.unwrap_or_default());
        let interval = if self.json { JSON_INTERVAL } else { LOG_INTERVAL };
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        let due = said.unwrap_or(self.started).elapsed() >= interval;
        if due && self.json {
            let common = [("frame", json!(picture.frame)), ("seconds", json!(seconds)), ("seconds_left", json!(left))];
            let values = common.into_iter().chain(values());
            self.print("progress", values.map(|(name, value)| (name.to_owned(), value)).collect());
        } else if due && !std::io::stderr().is_terminal() {
            let left = left.map_or_else(String::new, |left| format!(", {left:.0} s left"));
            note!("{total:6.0} s: {message}{left}");
        }
        if due {
            *said = Some(Instant::now());
        }
        self.bar.set_message(message);
    }

    /// Records the means of a picture so far for the estimate of its error.
    pub(super) fn record(&self, picture: &Picture, samples: u32, means: &[[f32; 3]]) {
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        errors.entry(picture.index).or_default().record(samples, means);
    }

    /// Forgets the estimate of a picture that is complete.
    pub(super) fn completed(&self, picture: &Picture) {
        self.errors.lock().unwrap_or_else(PoisonError::into_inner).remove(&picture.index);
    }

    /// True if the estimate of the error needs the means.
    pub(super) fn estimates_error(&self) -> bool {
        self.json
    }
}

/// Estimate of the relative error of a picture: the means of n and of 2n samples differ by about the error of the latter.
#[derive(Default)]
struct ErrorEstimate {
    samples: u32,
    means: Vec<f64>,
    /// Relative error after `samples` samples.
    error: Option<f64>,
}

impl ErrorEstimate {
    /// Number of pixels that are compared, about.
    const PIXELS: usize = 20_000;
    /// Added to squared means, as in relMSE.
    const EPSILON: f64 = 0.01;

    fn record(&mut self, samples: u32, means: &[[f32; 3]]) {
        let step = means.len().div_ceil(Self::PIXELS).max(1);
        let means: Vec<f64> =
            means.iter().step_by(step).map(|pixel| pixel.iter().map(|v| f64::from(*v)).sum::<f64>() / 3.0).collect();
        if samples == 2 * self.samples && means.len() == self.means.len() {
            let pairs = means.iter().zip(&self.means);
            let squares = pairs.map(|(new, old)| (new - old).powi(2) / (new * new + Self::EPSILON));
            self.error = Some((squares.sum::<f64>() / means.len().max(1) as f64).sqrt());
        } else {
            self.error = None;
        }
        (self.samples, self.means) = (samples, means);
    }

    /// Estimate after a number of samples; `None` before there is one.
    fn after(&self, samples: u32, settings: &Settings) -> Option<f64> {
        let samples = samples.saturating_sub(settings.first_sample.min(samples)).max(1);
        self.error.map(|error| error * (f64::from(self.samples) / f64::from(samples.max(self.samples))).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_independent_halves() {
        let mut estimate = ErrorEstimate::default();
        estimate.record(16, &[[1.0; 3], [2.0; 3]]);
        assert_eq!(estimate.error, None);
        estimate.record(32, &[[1.1; 3], [2.0; 3]]);
        let expected = (0.01_f64 / (1.21 + 0.01) / 2.0).sqrt();
        assert!((estimate.error.expect("an estimate") - expected).abs() < 1e-4);
        estimate.record(48, &[[1.0; 3]]);
        assert_eq!(estimate.error, None);
    }
}
