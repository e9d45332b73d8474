//! `pathmarch-measure`: measures speed, memory and error of pathmarch, for its developers.
//!
//! A separate program, so that `pathmarch` contains neither plots nor tables.

mod bench;
mod denoise;
mod edits;
mod flights;
mod fuzz;
mod hybrid;
mod measure;
mod peers;
mod rays;
mod study;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Measures pathmarch: time, error, memory, and the evaluation of the thesis.
///
/// Exit codes: 0 success, 1 failure, 2 error in scene or usage, 130 interrupted.
#[derive(Parser)]
#[command(version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Measure time per sample and error, for each scene and backend.
    Bench(bench::Arguments),
    /// Measure time and error of denoised pictures.
    Denoise(denoise::Arguments),
    /// Measure the time from a changed number to the first picture of the changed scene.
    Edits(edits::Arguments),
    /// Measure the error of reconstructed sequences against converged ones.
    Flights(flights::Arguments),
    /// Try random inputs on everything that reads files.
    Fuzz(fuzz::Arguments),
    /// Time camera rays by rasteriser and by hierarchy, on GPUs.
    Hybrid(hybrid::Arguments),
    /// Trace rays through meshes, and compare each with a test of every triangle in 64 bits.
    Rays(rays::Arguments),
    /// Repeat the evaluation of the thesis: tables, plots and pictures.
    Study(study::Arguments),
}

fn main() -> ExitCode {
    pathmarch_cli::end_on_closed_pipe();
    pathmarch_cli::run(|| match Arguments::parse().command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Denoise(arguments) => denoise::run(&arguments),
        Command::Edits(arguments) => edits::run(&arguments),
        Command::Flights(arguments) => flights::run(&arguments),
        Command::Fuzz(arguments) => fuzz::run(&arguments),
        Command::Hybrid(arguments) => hybrid::run(&arguments),
        Command::Rays(arguments) => rays::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
    })
}
