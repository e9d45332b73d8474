//! Errors and warnings of readers.

use crate::import::Warning;
use std::collections::HashMap;
use std::path::PathBuf;

/// Failure of reading a mesh file. Every message names the file and place, and suggests a remedy.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The extension is not that of a mesh format.
    #[error("{path}: the extension of a mesh must be .glb, .gltf, .obj, .stl, .ply or .npy; convert or rename the file", path = path.display())]
    UnknownExtension {
        /// Path of the file.
        path: PathBuf,
    },
    /// The file cannot be read.
    #[error("{path}: cannot be read: {source}; check the name and permissions", path = path.display())]
    Open {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is larger than [`super::ReadOptions::max_file_bytes`].
    #[error("{path}: is larger than {limit} bytes; split it, or raise the limit", path = path.display())]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// The limit.
        limit: u64,
    },
    /// The contents cannot be read.
    #[error("{path}: {mistake}", path = path.display())]
    Contents {
        /// Path of the file.
        path: PathBuf,
        /// The mistake.
        mistake: Mistake,
    },
}

/// Mistake in a file, or a feature without which it cannot be shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}; {remedy}")]
pub struct Mistake {
    /// Place in the file, such as a line or an accessor.
    pub place: String,
    /// The problem.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl Mistake {
    /// Mistake that the program which wrote the file made.
    pub fn new(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::with_remedy(place, problem, "correct the file or export it again")
    }
    /// Mistake with a remedy of its own.
    pub fn with_remedy(place: impl Into<String>, problem: impl Into<String>, remedy: &str) -> Self {
        Self { place: place.into(), problem: problem.into(), remedy: remedy.into() }
    }
}

/// Most different warnings of a file; further ones are only counted.
const MAX_WARNINGS: usize = 100;

/// Warnings so far. Equal messages become one with a count, so that a file cannot fill the memory with them.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    list: Vec<Warning>,
    by_message: HashMap<String, usize>,
    further: usize,
}

impl Warnings {
    /// Adds a warning: the feature or mistake, and what is shown instead.
    pub fn add(&mut self, place: impl Into<String>, message: impl Into<String>) {
        let message = message.into();
        if let Some(&index) = self.by_message.get(&message) {
            self.list[index].count += 1;
            return;
        }
        if self.list.len() >= MAX_WARNINGS {
            self.further += 1;
            return;
        }
        self.by_message.insert(message.clone(), self.list.len());
        self.list.push(Warning { place: place.into(), message, count: 1 });
    }

    pub fn into_list(mut self) -> Vec<Warning> {
        if self.further > 0 {
            let message = "further warnings are left out".to_string();
            self.list.push(Warning { place: "file".to_string(), message, count: self.further });
        }
        self.list
    }
}
