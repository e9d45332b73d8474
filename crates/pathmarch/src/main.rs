//! `pathmarch`: path-traced distance fields, in a window and from the command line.
//!
//! No rendering logic: that is in the libraries below. Exit codes: 0 done, 1 failed, 2 bad scene or
//! usage, 130 interrupted.

mod commands;
mod frames;
mod picture;
#[cfg(feature = "window")]
mod window;

use clap::{Parser, Subcommand};
use commands::{check, compare, completions, devices, export, render, shapes, view};
use std::process::ExitCode;

/// A path tracer for distance fields: scenes as text, light that is right.
///
/// Without a command it opens a window with a gallery to start from.
///
/// Exit codes: 0 done, 1 failed, 2 bad scene or usage, 130 interrupted.
#[derive(Parser)]
#[command(version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Open a window: see a scene, move through it, change it.
    View(view::Arguments),
    /// Render a scene to a picture.
    Render(render::Arguments),
    /// Make a mesh of a scene's objects: .stl, .ply, .obj or .glb.
    Export(export::Arguments),
    /// Read scenes and report every mistake in them.
    Check(check::Arguments),
    /// Compare a picture with a reference.
    Compare(compare::Arguments),
    /// List what this machine can render on.
    Devices,
    /// The reference of shapes and operators.
    Shapes(shapes::Arguments),
    /// Print what completes this command line in a shell.
    Completions(completions::Arguments),
    /// Print the pages for man.
    Man,
}

fn main() -> ExitCode {
    pathmarch_cli::run(|| {
        let command = Arguments::parse().command.unwrap_or_else(|| Command::View(view::Arguments::default()));
        match command {
            Command::View(arguments) => view::run(arguments),
            Command::Render(arguments) => render::run(&arguments),
            Command::Export(arguments) => export::run(&arguments),
            Command::Check(arguments) => check::run(&arguments),
            Command::Compare(arguments) => compare::run(&arguments),
            Command::Devices => devices::run(),
            Command::Shapes(arguments) => shapes::run(&arguments),
            Command::Completions(arguments) => completions::run(&arguments),
            Command::Man => completions::run_man(),
        }
    })
}
