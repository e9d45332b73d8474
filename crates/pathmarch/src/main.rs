//! `pathmarch`: path-traced distance fields, in a window and from the command line.
//!
//! No rendering logic: that is in the libraries below. Exit codes: 0 done, 1 failed, 2 bad scene or
//! usage, 130 interrupted.

mod commands;
mod exit;
mod frames;
mod measure;
mod picture;
mod threads;
mod window;

use clap::{Parser, Subcommand};
use commands::{bench, check, compare, devices, export, render, shapes, study, view};
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
    /// Measure how long a sample of a picture takes, and what quality costs, for each scene and backend.
    Bench(bench::Arguments),
    /// Repeat the evaluation of the thesis: tables, plots and pictures.
    Study(study::Arguments),
}

/// Mesa's device-select layer complains on standard error where there is no desktop session; nothing is lost without it
/// there, since it asks the desktop which GPU to prefer.
fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this is the start of `main`; no other thread runs.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

fn main() -> ExitCode {
    if let Err(missing) = exit::processor_has_what_we_were_built_for() {
        eprintln!("pathmarch: {missing}");
        return ExitCode::from(exit::FAILED);
    }
    quiet_drivers();
    let command = Arguments::parse().command.unwrap_or_else(|| Command::View(view::Arguments::default()));
    if let Some(note) = threads::start() {
        eprintln!("note: {note}");
    }
    let result = match command {
        Command::View(arguments) => view::run(arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Devices => devices::run(),
        Command::Shapes(arguments) => shapes::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Study(arguments) => study::run(&arguments),
    };
    match result {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}
