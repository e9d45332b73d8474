//! Exceptions whose classes are written in Python.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Module of the classes.
const CLASSES: &str = "pathmarch._types";

/// A class of the Python part of the package.
///
/// # Errors
/// Errors of the import.
pub fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import(CLASSES)?.getattr(name)
}

/// Exception of a class that is written in Python.
pub fn exception<'py>(py: Python<'py>, class: &str, arguments: impl pyo3::call::PyCallArgs<'py>) -> PyErr {
    let made = self::class(py, class).and_then(|class| class.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Error of a mistake in this program.
pub fn internal(what: &str) -> PyErr {
    PyRuntimeError::new_err(format!("{what}; this is a mistake in pathmarch, please report it"))
}
