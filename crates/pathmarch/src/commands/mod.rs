//! Commands, one file each.

pub mod check;
pub mod compare;
pub mod completions;
pub mod devices;
pub mod export;
pub mod help;
pub mod merge;
pub mod render;
mod scene_source;
pub mod shapes;
pub mod video;
#[cfg_attr(not(feature = "window"), path = "no_window.rs")]
pub mod view;

use indicatif::{ProgressBar, ProgressStyle};

/// Quoted names, separated by commas.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// Progress bar on standard error, if that is a terminal, with a message and the time left.
pub fn progress_bar(total: u64) -> ProgressBar {
    let bar = ProgressBar::new(total);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}, {eta} left") {
        bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
    }
    bar
}
