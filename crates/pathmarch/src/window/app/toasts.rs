//! Toasts: messages that go away by themselves.

use super::App;
use std::time::{Duration, Instant};

/// Messages stay for so long; in tests until they are closed, for no test may depend on how fast it runs.
const MESSAGE_SECONDS: f32 = if cfg!(test) { 1e5 } else { 4.0 };
/// Complaints stay longer, for there is more to read.
const ERROR_SECONDS: f32 = if cfg!(test) { 1e5 } else { 10.0 };

/// A message that goes away by itself.
pub(crate) struct Toast {
    pub(crate) text: String,
    pub(crate) is_error: bool,
    pub(crate) until: Instant,
}

impl App {
    pub(crate) fn show_message(&mut self, text: &str) {
        self.toast(text, false, MESSAGE_SECONDS);
    }
    pub(crate) fn show_error(&mut self, text: &str) {
        self.toast(text, true, ERROR_SECONDS);
    }
    fn toast(&mut self, text: &str, is_error: bool, seconds: f32) {
        let until = Instant::now() + Duration::from_secs_f32(seconds);
        self.toasts.retain(|toast| toast.text != text);
        self.toasts.push(Toast { text: text.to_owned(), is_error, until });
        let extra = self.toasts.len().saturating_sub(4);
        self.toasts.drain(..extra);
    }
}
