//! Sources of scenes: texts and files.

use crate::failure::Failure;
use pathmarch_render::pathmarch_scene::{Animation, read_text};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::path::{Path, PathBuf};

/// Name of a text without a file; files that it names are relative to its folder.
const TEXT_NAME: &str = "scene.kdl";

/// Name and text of a scene.
#[derive(Clone)]
pub struct Source {
    /// Path of the file, or of the file that the text would be.
    pub name: String,
    /// The text.
    pub text: String,
    /// True if it may read files outside its folder.
    pub allow_files: bool,
}

impl Source {
    /// Source of a Python value: a path, or a text, which has a line break or a brace. `folder` is that of a text.
    ///
    /// # Errors
    /// `TypeError` for values that are neither, `SceneError` for files that cannot be read.
    pub fn of(value: &Bound<PyAny>, folder: Option<PathBuf>, allow_files: bool) -> PyResult<Self> {
        match value.cast::<PyString>().ok().map(|text| text.extract::<String>()).transpose()? {
            Some(text) if text.contains(['\n', '{']) => Ok(Self::of_text(text, folder, allow_files)),
            _ => Self::of_file(&path(value)?, allow_files),
        }
    }

    fn of_text(text: String, folder: Option<PathBuf>, allow_files: bool) -> Self {
        let name = folder.unwrap_or_default().join(TEXT_NAME).display().to_string();
        Self { name, text, allow_files }
    }

    fn of_file(path: &Path, allow_files: bool) -> PyResult<Self> {
        let text = read_text(path).map_err(Failure::from)?;
        Ok(Self { name: path.display().to_string(), text, allow_files })
    }

    /// The scene at all moments.
    pub fn animation(&self) -> Animation {
        let animation = Animation::new(self.name.clone(), self.text.clone());
        if self.allow_files { animation } else { animation.confined() }
    }
}

fn path(value: &Bound<PyAny>) -> PyResult<PathBuf> {
    value.extract().map_err(|_| {
        let kind = value.get_type().name().map_or_else(|_| "this".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!("expected the text of a scene or the path of a file, not {kind}"))
    })
}
