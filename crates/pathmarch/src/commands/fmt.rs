//! `pathmarch fmt`: formats scene files.

use super::scene_source::{STANDARD_INPUT, read_standard_input};
use crate::atomic_file::write_atomically;
use pathmarch_cli::{DONE, FAILED, Failure, note, out, outln};
use pathmarch_render::pathmarch_scene::{formatter, read_text};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene files; `-` formats standard input to standard output
    #[arg(required_unless_present = "stdin")]
    files: Vec<PathBuf>,
    /// Write nothing: list the files that would change, and exit with 1 if there are any
    #[arg(long)]
    check: bool,
    /// Format standard input to standard output, as `-` does
    #[arg(long, conflicts_with = "files")]
    stdin: bool,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let standard_input = arguments.stdin.then(|| PathBuf::from("-"));
    let mut code = DONE;
    for file in arguments.files.iter().chain(&standard_input) {
        let result = format(file, arguments.check);
        code = code.max(result.unwrap_or_else(|failure| {
            failure.print();
            failure.code()
        }));
    }
    Ok(code)
}

/// Formats a file, or lists it if it would change; returns the exit code.
fn format(file: &Path, check: bool) -> Result<u8, Failure> {
    let is_standard_input = file == Path::new("-");
    let (name, text) = match is_standard_input {
        true => (STANDARD_INPUT.to_owned(), read_standard_input()?),
        false => (file.display().to_string(), read_text(file)?),
    };
    let formatted = formatter::format(&name, &text)?;
    let changes = formatted != text;
    if check {
        if changes {
            outln!("{name}");
        }
        return Ok(if changes { FAILED } else { DONE });
    }
    if is_standard_input {
        out!("{formatted}");
    } else if changes {
        write_atomically(file, formatted.as_bytes()).map_err(Failure::other)?;
        note!("formatted {name}");
    }
    Ok(DONE)
}
