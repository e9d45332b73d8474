//! `pathmarch view`: opens the window.

use crate::window::{self, Drawing, Options};
use pathmarch_cli::{BackendArgument, Failure};
use std::path::PathBuf;

#[derive(clap::Args, Default)]
pub struct Arguments {
    /// Scene file [default: start with the gallery]
    scene: Option<PathBuf>,
    /// Render backend; auto takes a hardware GPU, otherwise the CPU, which is faster than software GPUs
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Backend that draws the window itself
    #[arg(long, value_enum, default_value = "auto", value_name = "WHAT")]
    drawing: Drawing,
    /// Allow scenes to read files outside their folder
    #[arg(long)]
    allow_files: bool,
    /// Print timings to standard error: start-up, first picture, full resolution, all samples, and frame times at the
    /// end
    #[arg(long)]
    timings: bool,
}

/// Opens the window with the gallery.
pub fn run_without_command(_: clap::Command) -> Result<u8, Failure> {
    run(Arguments::default())
}

pub fn run(arguments: Arguments) -> Result<u8, Failure> {
    let Arguments { scene, backend, adapter, drawing, allow_files, timings } = arguments;
    if let Some(scene) = scene.as_ref().filter(|scene| !scene.is_file()) {
        let why = if scene.is_dir() { "it is a directory; name a .kdl file in it" } else { "there is no such file" };
        return Err(Failure::Usage(format!("cannot open {}: {why}", scene.display())));
    }
    window::run(Options { scene, backend: backend.into(), adapter, allow_files, timings }, drawing)
}
