//! `pathmarch`: a path tracer for distance fields, with a window and a command line.
//!
//! Rendering is in the libraries. Exit codes: 0 success, 1 failure, 2 error in scene or usage, 130 interrupted.

mod atomic_file;
mod commands;
mod film_notes;
mod frames;
mod picture;
mod video;
#[cfg(feature = "window")]
mod window;

use clap::{CommandFactory, Parser, Subcommand};
use commands::{
    check, compare, completions, devices, export, fmt, help, import, lsp, merge, reference, render, shapes,
    video as video_command, view,
};
use pathmarch_cli::{AppDirs, Failure};
use pathmarch_render::pathmarch_scene::{set_mesh_cache, set_mesh_progress};
use std::process::ExitCode;

/// A path tracer for signed distance fields.
///
/// Without a command it opens a window with a gallery of example scenes.
///
/// Exit codes: 0 success, 1 failure, 2 error in scene or usage, 130 interrupted.
#[derive(Parser)]
#[command(version, propagate_version = true, disable_help_subcommand = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Open a window to view and edit a scene.
    View(view::Arguments),
    /// Render scenes to pictures.
    Render(Box<render::Arguments>),
    /// Merge films that were rendered in parts.
    Merge(merge::Arguments),
    /// Make a video of pictures.
    Video(video_command::Arguments),
    /// Export objects of a scene as a mesh or as a volume of distances.
    Export(export::Arguments),
    /// Make a scene of a mesh file, with its objects, lights and cameras.
    Import(import::Arguments),
    /// Read scenes and report every error in them.
    Check(check::Arguments),
    /// Format scene files.
    Fmt(fmt::Arguments),
    /// Language server for text editors, over standard input and output.
    Lsp(lsp::Arguments),
    /// Compare a picture with a reference.
    Compare(compare::Arguments),
    /// List the devices that can render.
    Devices(devices::Arguments),
    /// Reference of shapes and operators.
    Shapes(shapes::Arguments),
    /// Print every word of the scene language, as Markdown.
    Reference(reference::Arguments),
    /// Help on a command, or on a word of the scene language.
    Help(help::Arguments),
    /// Print shell completions.
    Completions(completions::Arguments),
    /// Print the manual pages.
    Man,
}

fn main() -> ExitCode {
    pathmarch_cli::run(|| match Arguments::parse().command {
        Some(command) => run(command),
        None => view::run_without_command(Arguments::command()),
    })
}

fn run(command: Command) -> Result<u8, Failure> {
    if let Some(dirs) = AppDirs::of_user() {
        set_mesh_cache(dirs.meshes);
    }
    if !matches!(command, Command::View(_)) {
        pathmarch_cli::end_on_closed_pipe();
        set_mesh_progress(commands::mesh_progress());
    }
    match command {
        Command::View(arguments) => view::run(arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Video(arguments) => video_command::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Fmt(arguments) => fmt::run(&arguments),
        Command::Lsp(arguments) => lsp::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Shapes(arguments) => shapes::run(&arguments),
        Command::Reference(arguments) => reference::run(&arguments),
        Command::Help(arguments) => help::run(&arguments, Arguments::command()),
        Command::Completions(arguments) => completions::run(&arguments, Arguments::command()),
        Command::Man => completions::run_man(Arguments::command()),
    }
}
