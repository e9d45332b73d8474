//! Printing that never panics: a full disk or a closed terminal behind standard output or standard error is no reason to lose
//! a picture.

use crate::exit::FAILED;
use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// Prints to standard output, as `print!`. If that fails, the program reports it and ends.
#[macro_export]
macro_rules! out {
    ($($text:tt)*) => { $crate::print_out(format_args!($($text)*), "") };
}

/// Prints a line to standard output, as `println!`. If that fails, the program reports it and ends.
#[macro_export]
macro_rules! outln {
    ($($text:tt)*) => { $crate::print_out(format_args!($($text)*), "\n") };
}

/// Prints a line to standard error, as `eprintln!`. What cannot be printed there is lost.
#[macro_export]
macro_rules! note {
    ($($text:tt)*) => { $crate::print_note(format_args!($($text)*)) };
}

/// Prints to standard output; ends the program if that fails.
pub fn print_out(text: Arguments, end: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = write!(out, "{text}{end}").and_then(|()| out.flush()) {
        if error.kind() != ErrorKind::BrokenPipe {
            print_note(format_args!("pathmarch: standard output: {error}"));
        }
        std::process::exit(i32::from(FAILED));
    }
}

/// Prints a line to standard error, in one piece.
pub fn print_note(text: Arguments) {
    let _ = std::io::stderr().lock().write_all(format!("{text}\n").as_bytes());
}
