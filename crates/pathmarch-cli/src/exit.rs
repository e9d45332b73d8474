//! Start and end of a program: exit codes, failures, checks at start-up.

use crate::instruction_set::{check_instruction_set, run_best_build};
use crate::{note, threads};
use pathmarch_render::pathmarch_scene::SceneError;
use std::io::Write;
use std::process::ExitCode;

/// Success.
pub const DONE: u8 = 0;
/// Failure of a device, a file, or a limit given to `compare`.
pub const FAILED: u8 = 1;
/// Error in a scene or on the command line.
pub const USAGE: u8 = 2;
/// Interrupted by Ctrl-C.
pub const INTERRUPTED: u8 = 130;

/// Reason why a command ends early.
#[derive(Debug)]
pub enum Failure {
    /// A scene with errors; prints each with its place.
    Scene(Box<SceneError>),
    /// An error on the command line.
    Usage(String),
    /// Ctrl-C.
    Interrupted,
    /// Any other failure.
    Other(String),
}

impl Failure {
    /// Creates a failure that is not a usage error.
    pub fn other(error: impl ToString) -> Self {
        Self::Other(error.to_string())
    }
    /// Message of the failure, without the places in a scene.
    pub fn message(&self) -> String {
        match self {
            Self::Scene(error) => error.to_string(),
            Self::Interrupted => "interrupted".to_owned(),
            Self::Usage(message) | Self::Other(message) => message.clone(),
        }
    }
    /// Exit code of the process.
    pub fn code(&self) -> u8 {
        match self {
            Self::Scene(_) | Self::Usage(_) => USAGE,
            Self::Interrupted => INTERRUPTED,
            Self::Other(_) => FAILED,
        }
    }
    /// Prints the failure to standard error.
    pub fn print(&self) {
        match self {
            Self::Scene(error) => print_report(&**error),
            Self::Interrupted => note!("pathmarch: interrupted"),
            Self::Usage(message) | Self::Other(message) => note!("pathmarch: {message}"),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

/// Ends the program quietly when a pipe that it prints to is closed, as in `pathmarch shapes | head`. Not for programs with a
/// window, which would end with it.
pub fn end_on_closed_pipe() {
    sigpipe::reset();
}

/// Prints every error of a scene, or one warning, with the source underlined.
pub fn print_report(report: &dyn miette::Diagnostic) {
    let mut text = String::new();
    match miette::GraphicalReportHandler::new().render_report(&mut text, report) {
        Ok(()) => note!("{}", text.trim_end_matches('\n')),
        Err(_) => note!("pathmarch: {report}"),
    }
}

/// Runs a program and returns its exit code: looks for the best build for the processor, silences drivers, starts the threads,
/// prints a failure.
pub fn run(program: impl FnOnce() -> Result<u8, Failure>) -> ExitCode {
    // Nothing but texts of the program until the processor is known to have its instructions.
    if let Err(missing) = check_instruction_set() {
        for text in ["pathmarch: ", missing, "\n"] {
            let _ = std::io::stderr().write_all(text.as_bytes());
        }
        return ExitCode::from(FAILED);
    }
    run_best_build();
    start(program)
}

#[inline(never)]
fn start(program: impl FnOnce() -> Result<u8, Failure>) -> ExitCode {
    quiet_drivers();
    report_file_limits();
    if let Some(note) = threads::start() {
        note!("note: {note}");
    }
    match program() {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            failure.print();
            ExitCode::from(failure.code())
        }
    }
}

/// Makes a write beyond the limit of file sizes fail, instead of ending the program with what it has written left behind.
fn report_file_limits() {
    #[cfg(unix)]
    // SAFETY: the handler is the system's own.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Silences Mesa's device-select layer, which prints errors without a desktop session. It only asks the desktop for the
/// preferred GPU, so nothing is lost.
fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: this is the start of `main`; no other thread runs.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
