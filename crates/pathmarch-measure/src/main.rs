//! `pathmarch-measure`: what pathmarch costs and how good its pictures are, for those who develop it.
//!
//! A program of its own, so that `pathmarch` carries neither plots nor tables.

mod bench;
mod measure;
mod study;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Measures pathmarch: times, errors, memory, and the evaluation of the thesis.
///
/// Exit codes: 0 done, 1 failed, 2 bad scene or usage, 130 interrupted.
#[derive(Parser)]
#[command(version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure how long a sample of a picture takes, and what quality costs, for each scene and backend.
    Bench(bench::Arguments),
    /// Repeat the evaluation of the thesis: tables, plots and pictures.
    Study(study::Arguments),
}

fn main() -> ExitCode {
    pathmarch_cli::run(|| match Arguments::parse().command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
    })
}
