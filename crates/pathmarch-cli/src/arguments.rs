//! Arguments shared by several commands.

use crate::Failure;
use clap::ValueEnum;
use pathmarch_render::{Backend, image};
use std::path::Path;

/// Values of `--backend`.
#[derive(Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum BackendArgument {
    /// GPU if one works and is not slower software, otherwise the CPU
    #[default]
    Auto,
    /// GPU only
    Gpu,
    /// CPU
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

/// Checks that an output file can be written, before long work rather than after it: that its directory exists, and that it is
/// a file if there is something of its name.
///
/// # Errors
/// Fails if it cannot.
pub fn check_output(output: &Path) -> Result<(), Failure> {
    check_directory(output)?;
    image::check_writable(output).map_err(Failure::other)
}

/// Checks that the directory of an output file exists.
///
/// # Errors
/// Fails if it does not exist.
pub fn check_directory(output: &Path) -> Result<(), Failure> {
    let directory = output.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !directory.is_dir() {
        return Err(Failure::Other(format!("there is no directory {}; create it first", directory.display())));
    }
    Ok(())
}
