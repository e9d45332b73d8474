//! One file for each command.

pub mod bench;
pub mod check;
pub mod compare;
pub mod devices;
pub mod export;
mod numbers;
pub mod render;
pub mod shapes;
pub mod study;
pub mod view;

use crate::exit::{Failure, INTERRUPTED};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use pathmarch_render::Backend;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// `--backend`
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum BackendArgument {
    /// The GPU where one works, else the CPU
    #[default]
    Auto,
    /// The GPU, or fail
    Gpu,
    /// The CPU
    Cpu,
}

impl From<BackendArgument> for Backend {
    fn from(argument: BackendArgument) -> Self {
        match argument {
            BackendArgument::Auto => Self::Auto,
            BackendArgument::Gpu => Self::Gpu,
            BackendArgument::Cpu => Self::Cpu,
        }
    }
}

/// Names in quotation marks, with commas between.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// Whether the directory that a file will be written to is there: better said now than after an hour of work.
pub fn check_directory(output: &Path) -> Result<(), Failure> {
    let directory = output.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !directory.is_dir() {
        return Err(Failure::Other(format!("there is no directory {}; make it first", directory.display())));
    }
    Ok(())
}

/// A flag that Ctrl-C raises; a second Ctrl-C ends the program at once.
pub fn watch_interrupts() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })
    .map_err(Failure::other)?;
    Ok(flag)
}

/// A bar on standard error, where that is a terminal, with a message and the time left behind it.
pub fn progress_bar(total: u64) -> ProgressBar {
    let bar = ProgressBar::new(total);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {msg}, {eta} left") {
        bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
    }
    bar
}
