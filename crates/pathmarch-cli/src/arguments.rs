//! Arguments shared by several commands.

use crate::Failure;
use clap::ValueEnum;
use pathmarch_render::Backend;
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

/// Checks that the directory of an output file exists, before long work rather than after it.
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
