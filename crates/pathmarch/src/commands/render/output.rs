//! Outputs of a render: a picture, a film, or standard output.

use crate::film_notes::is_film;
use pathmarch_cli::{Failure, check_output};
use pathmarch_render::image::ImageFormat;
use std::path::{Path, PathBuf};

/// File that a render writes, or standard output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Output {
    /// Picture.
    Picture(PathBuf),
    /// Film of a part of a picture, to be merged.
    Film(PathBuf),
    /// PNG on standard output.
    Standard,
}

impl Output {
    /// Output of a name; `-` is standard output.
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self::Standard);
        }
        if is_film(path) {
            return Ok(Self::Film(path.to_owned()));
        }
        ImageFormat::from_path(path).map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Self::Picture(path.to_owned()))
    }

    /// Path of the file; `None` for standard output.
    pub(super) fn file(&self) -> Option<&Path> {
        match self {
            Self::Picture(file) | Self::Film(file) => Some(file),
            Self::Standard => None,
        }
    }

    /// Checks that it can be written.
    pub(super) fn check(&self) -> Result<(), Failure> {
        self.file().map_or(Ok(()), check_output)
    }

    pub(super) fn name(&self) -> String {
        self.file().map_or_else(|| "standard output".to_owned(), |file| file.display().to_string())
    }
}
