//! Failures of the library as exceptions of Python.

use crate::diagnostics;
use pathmarch_render::RenderError;
use pathmarch_render::pathmarch_scene::SceneError;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// Module of the exception classes.
const CLASSES: &str = "pathmarch._types";

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

/// Exception of a class that is written in Python.
pub fn exception<'py>(py: Python<'py>, class: &str, arguments: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = py.import(CLASSES).and_then(|module| module.getattr(class)).and_then(|class| class.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Error of a mistake in this program.
pub fn internal(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("{what}; this is a mistake in pathmarch, please report it"))
}
