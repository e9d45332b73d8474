//! Arguments that several commands take.

use crate::Failure;
use clap::ValueEnum;
use pathmarch_render::Backend;
use std::path::Path;

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

/// Checks that the directory of an output file exists: better said now than after an hour of work.
///
/// # Errors
/// If it does not.
pub fn check_directory(output: &Path) -> Result<(), Failure> {
    let directory = output.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !directory.is_dir() {
        return Err(Failure::Other(format!("there is no directory {}; make it first", directory.display())));
    }
    Ok(())
}
