//! `pathmarch view`: the window.

use crate::window::{self, Drawing, Options};
use pathmarch_cli::{BackendArgument, Failure};
use std::path::PathBuf;

#[derive(clap::Args, Default)]
pub struct Arguments {
    /// The scene file [default: a gallery to choose from]
    scene: Option<PathBuf>,
    /// What to render on; auto takes a GPU, but none that is software: the CPU is faster than that
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
    /// The GPU adapter whose name contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// What the window itself is drawn on
    #[arg(long, value_enum, default_value = "auto", value_name = "WHAT")]
    drawing: Drawing,
    /// Say on standard error how long it took to the first picture, the whole one and all samples, and, at the end, how
    /// long frames of the window took
    #[arg(long)]
    timings: bool,
}

pub fn run(arguments: Arguments) -> Result<u8, Failure> {
    let Arguments { scene, backend, adapter, drawing, timings } = arguments;
    if let Some(scene) = scene.as_ref().filter(|scene| !scene.is_file()) {
        let why = if scene.is_dir() { "it is a directory; name a .kdl file in it" } else { "there is no such file" };
        return Err(Failure::Usage(format!("cannot open {}: {why}", scene.display())));
    }
    window::run(Options { scene, backend: backend.into(), adapter, timings }, drawing)
}
