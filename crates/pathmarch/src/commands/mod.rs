//! Commands, one file each.

pub mod check;
pub mod compare;
pub mod completions;
pub mod devices;
pub mod export;
pub mod fmt;
pub mod help;
pub mod import;
pub mod lsp;
pub mod merge;
mod printing;
pub mod reference;
pub mod render;
mod scene_source;
pub mod shapes;
pub mod video;
#[cfg_attr(not(feature = "window"), path = "no_window.rs")]
pub mod view;

use indicatif::{ProgressBar, ProgressStyle};
use pathmarch_render::pathmarch_scene::MeshProgress;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

/// Quoted names, separated by commas.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// Number with its noun, as in "1 sample" and "2 samples".
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Progress bar on standard error, if that is a terminal, with a message and the time left.
pub fn progress_bar(total: u64) -> ProgressBar {
    let bar = ProgressBar::new(total);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}, {eta} left") {
        bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
    }
    bar
}

/// Progress of distance fields of meshes, on standard error if that is a terminal.
pub fn mesh_progress() -> Box<MeshProgress> {
    let bar: Mutex<Option<ProgressBar>> = Mutex::default();
    Box::new(move |share| {
        let mut bar = bar.lock().unwrap_or_else(PoisonError::into_inner);
        if share >= 1.0 {
            bar.take().inspect(ProgressBar::finish_and_clear);
        } else {
            let bar = bar.get_or_insert_with(|| progress_bar(1000));
            bar.set_position((share * 1000.0) as u64);
            bar.set_message(format!("distance field of a mesh: {:.0} %", share * 100.0));
        }
        ControlFlow::Continue(())
    })
}
