//! Toasts: messages that disappear after a few seconds.

use super::App;
use std::time::{Duration, Instant};

/// Duration of a message. In tests it stays until closed, so that no test depends on its own speed.
const MESSAGE_SECONDS: f32 = if cfg!(test) { 1e5 } else { 4.0 };
/// Duration of an error message: longer, as there is more to read.
const ERROR_SECONDS: f32 = if cfg!(test) { 1e5 } else { 10.0 };

/// A message with its end.
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
