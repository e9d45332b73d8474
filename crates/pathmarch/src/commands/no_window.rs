//! `pathmarch view` of a program that was built without the feature `window`: says so, and what to do.

use clap::CommandFactory;
use pathmarch_cli::Failure;
use std::ffi::OsString;

#[derive(clap::Args, Default)]
pub struct Arguments {
    /// Whatever `view` takes elsewhere; `None` is the program without a command
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true, default_value = "")]
    given: Option<Vec<OsString>>,
}

pub fn run(arguments: Arguments) -> Result<u8, Failure> {
    if arguments.given.is_none() {
        eprintln!("{}", crate::Arguments::command().render_help());
    }
    Err(Failure::Usage(
        "this program was built without a window; build it without --no-default-features to have one, or make a \
         picture with `pathmarch render SCENE`"
            .to_owned(),
    ))
}
