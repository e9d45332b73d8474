//! `pathmarch view` in a program built without the feature `window`: explains how to get one.

use pathmarch_cli::{Failure, note};
use std::ffi::OsString;

#[derive(clap::Args)]
pub struct Arguments {
    /// Arguments of `view`, ignored
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    given: Option<Vec<OsString>>,
}

/// Prints the help of the whole program, then fails.
pub fn run_without_command(mut command: clap::Command) -> Result<u8, Failure> {
    note!("{}", command.render_help());
    Err(no_window())
}

pub fn run(arguments: Arguments) -> Result<u8, Failure> {
    drop(arguments.given);
    Err(no_window())
}

fn no_window() -> Failure {
    Failure::Usage(
        "this program was built without a window; build it without --no-default-features, or render a picture with \
         `pathmarch render SCENE`"
            .to_owned(),
    )
}
