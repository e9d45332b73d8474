//! Peers: other renderers that render the same scenes, as programs of their own.
//!
//! Their scripts are part of this program, so that it runs anywhere; they need Python and the peer.

mod cycles;
mod described_scene;
mod mitsuba;
mod thesis;

pub use cycles::Cycles;
pub use described_scene::DescribedScene;
pub use mitsuba::Mitsuba;
pub use thesis::{ThesisFrame, ThesisProgram};

use pathmarch_cli::Failure;
use pathmarch_render::image::{self, Picture};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Options with which Blender runs a script without a window, and ends with its failure.
const BLENDER: [&str; 4] = ["-b", "--factory-startup", "--python-exit-code", "1"];

/// Python interpreter with the modules of the peers, or Blender, which has `bpy` and is one.
#[derive(Clone, Debug)]
pub struct Python(PathBuf);

impl Python {
    /// An interpreter, `python3` by default.
    pub fn new(path: Option<&Path>) -> Self {
        Self(path.map_or_else(|| PathBuf::from("python3"), Path::to_owned))
    }

    fn is_blender(&self) -> bool {
        self.0.file_stem().is_some_and(|name| name == "blender")
    }

    /// Reports whether it imports a module.
    pub fn has(&self, module: &str) -> bool {
        let import = format!("import {module}");
        let output = if self.is_blender() {
            Command::new(&self.0).args(BLENDER).args(["--python-expr", &import]).output()
        } else {
            Command::new(&self.0).args(["-c", &import]).output()
        };
        output.is_ok_and(|output| output.status.success())
    }

    /// Runs a script, and returns what its output has after the word `RESULT`, line by line.
    ///
    /// # Errors
    /// [`Failure::Other`] with the end of its error output.
    fn run(&self, name: &str, script: &str, arguments: &[String]) -> Result<Vec<String>, Failure> {
        let directory = tempfile::tempdir().map_err(Failure::other)?;
        let path = directory.path().join(name);
        std::fs::write(&path, script).map_err(Failure::other)?;
        let mut command = Command::new(&self.0);
        if self.is_blender() {
            command.args(BLENDER).arg("--python").arg(&path).arg("--");
        } else {
            command.arg(&path);
        }
        let output = command.args(arguments).output();
        let output = output.map_err(|error| Failure::Other(format!("{}: {error}", self.0.display())))?;
        if !output.status.success() {
            let errors = String::from_utf8_lossy(&output.stderr);
            let last: Vec<&str> = errors.lines().rev().take(4).collect();
            let reason: Vec<&str> = last.into_iter().rev().collect();
            return Err(Failure::Other(format!("{name} ended with {}: {}", output.status, reason.join("; "))));
        }
        let text = String::from_utf8_lossy(&output.stdout);
        // Warnings may leave control codes of the terminal before a line.
        let result = |line: &str| Some(line.split_once("RESULT ")?.1.to_owned());
        Ok(text.lines().filter_map(result).collect())
    }
}

/// A picture by a peer.
pub struct PeerPicture {
    /// Samples of each pixel.
    pub samples: u32,
    /// Time of the render, seconds.
    pub seconds: f64,
    /// Rise of resident memory by the first render of the run, MB, where it is known.
    pub megabytes: Option<f64>,
    /// Mean of the samples.
    pub picture: Picture,
}

impl PeerPicture {
    /// Reads a line of a script's results, and the picture that it names.
    fn parsed(line: &str) -> Result<Self, Failure> {
        #[derive(serde::Deserialize)]
        struct Line {
            samples: u32,
            seconds: f64,
            megabytes: Option<f64>,
            picture: String,
        }
        let Line { samples, seconds, megabytes, picture } = parsed(line)?;
        let picture = image::load(Path::new(&picture)).map_err(Failure::other)?.picture;
        Ok(Self { samples, seconds, megabytes, picture })
    }
}

/// Parses a line of a script's results.
fn parsed<T: serde::de::DeserializeOwned>(line: &str) -> Result<T, Failure> {
    serde_json::from_str(line).map_err(|error| Failure::Other(format!("{line}: {error}")))
}
