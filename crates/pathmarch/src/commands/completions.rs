//! `pathmarch completions` and `pathmarch man`: shell completions and manual pages.
//!
//! Both are generated from the definitions that parse the command line.

use clap::Command;
use clap_complete::Shell;
use pathmarch_cli::{DONE, Failure};
use std::io::{ErrorKind, Write};

#[derive(clap::Args)]
pub struct Arguments {
    /// Shell
    shell: Shell,
}

pub fn run(arguments: &Arguments, mut command: Command) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "pathmarch", &mut script);
    print(&script)
}

/// Prints one page for each command; `man` shows them as one document.
pub fn run_man(mut command: Command) -> Result<u8, Failure> {
    command.build();
    let mut pages = Vec::new();
    let of_subcommands = command.get_subcommands().cloned();
    for page in std::iter::once(command.clone()).chain(of_subcommands) {
        clap_mangen::Man::new(page).render(&mut pages).map_err(Failure::other)?;
    }
    print(&pages)
}

/// Writes to standard output; a closed pipe is not an error.
fn print(bytes: &[u8]) -> Result<u8, Failure> {
    match std::io::stdout().write_all(bytes) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::other(error)),
        _ => Ok(DONE),
    }
}
