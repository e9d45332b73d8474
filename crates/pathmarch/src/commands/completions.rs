//! `pathmarch completions` and `pathmarch man`: the command line described to shells and to `man`.
//!
//! Both are made of the definitions that parse the command line, so that they cannot differ from it.

use clap::CommandFactory;
use clap_complete::Shell;
use pathmarch_cli::{DONE, Failure};
use std::io::{ErrorKind, Write};

#[derive(clap::Args)]
pub struct Arguments {
    /// The shell
    shell: Shell,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Arguments::command(), "pathmarch", &mut script);
    print(&script)
}

/// Prints a page for each command, one behind the other; `man` shows them as one.
pub fn run_man() -> Result<u8, Failure> {
    let mut command = crate::Arguments::command();
    command.build();
    let mut pages = Vec::new();
    let of_subcommands = command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help").cloned();
    for page in std::iter::once(command.clone()).chain(of_subcommands) {
        clap_mangen::Man::new(page).render(&mut pages).map_err(Failure::other)?;
    }
    print(&pages)
}

/// Writes to standard output, whose reader may have seen enough.
fn print(bytes: &[u8]) -> Result<u8, Failure> {
    match std::io::stdout().write_all(bytes) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::other(error)),
        _ => Ok(DONE),
    }
}
