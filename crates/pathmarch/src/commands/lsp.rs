//! `pathmarch lsp`: language server for text editors.

use pathmarch_cli::{DONE, Failure};

#[derive(clap::Args)]
pub struct Arguments {
    /// Ignored: messages always go over standard input and output. Some editors add it
    #[arg(long = "stdio")]
    _stdio: bool,
}

pub fn run(_: &Arguments) -> Result<u8, Failure> {
    pathmarch_lsp::serve_stdio().map_err(Failure::other)?;
    Ok(DONE)
}
