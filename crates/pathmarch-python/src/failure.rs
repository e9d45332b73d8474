//! Failures of the library as exceptions of Python.

use crate::diagnostics;
use crate::exceptions::exception;
use pathmarch_render::RenderError;
use pathmarch_render::pathmarch_scene::SceneError;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyValueError};
use pyo3::prelude::*;

/// Failure of work that runs without the interpreter.
#[derive(Debug)]
pub enum Failure {
    /// A text that is no scene: `SceneError`.
    Scene(Box<SceneError>),
    /// A backend that failed: `RenderError`.
    Render(String),
    /// A value out of range: `ValueError`.
    Value(String),
    /// A file that cannot be written: `OSError`.
    File(String),
    /// A picture that does not fit into memory: `MemoryError`.
    Memory(String),
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Scene(error) => error.into(),
            RenderError::Settings(message) => Self::Value(message),
            other => Self::Render(other.to_string()),
        }
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Scene(error) => Python::attach(|py| diagnostics::scene_error(py, &error)),
            Failure::Render(message) => Python::attach(|py| exception(py, "RenderError", (message,))),
            Failure::Value(message) => PyValueError::new_err(message),
            Failure::File(message) => PyOSError::new_err(message),
            Failure::Memory(message) => PyMemoryError::new_err(message),
        }
    }
}
