//! Mistakes and warnings of scenes, with their places in the text.

use crate::exceptions::{class, exception};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use pathmarch_render::pathmarch_scene::{Mistake, SceneError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// `SceneError` with the report of every mistake as its text.
pub fn scene_error(py: Python, error: &SceneError) -> PyErr {
    match diagnostics(py, error.mistakes()) {
        Ok(diagnostics) => exception(py, "SceneError", (report(error), diagnostics)),
        Err(error) => error,
    }
}

/// A tuple of `Diagnostic`.
pub fn diagnostics<'py>(py: Python<'py>, mistakes: &[Mistake]) -> PyResult<Bound<'py, PyTuple>> {
    let class = class(py, "Diagnostic")?;
    let made: Vec<_> = mistakes.iter().map(|mistake| diagnostic(&class, mistake)).collect::<PyResult<_>>()?;
    PyTuple::new(py, made)
}

fn diagnostic<'py>(class: &Bound<'py, PyAny>, mistake: &Mistake) -> PyResult<Bound<'py, PyAny>> {
    let (line, column, length) = place(mistake);
    let fields = PyDict::new(class.py());
    fields.set_item("message", &mistake.message)?;
    fields.set_item("line", line)?;
    fields.set_item("column", column)?;
    fields.set_item("length", length)?;
    fields.set_item("file", mistake.source_code.name())?;
    fields.set_item("code", mistake.code)?;
    fields.set_item("label", &mistake.label)?;
    fields.set_item("help", mistake.help.as_ref())?;
    class.call((), Some(&fields))
}

/// Line and column of the start of a mistake, from 1, and its length; columns and lengths are in characters.
fn place(mistake: &Mistake) -> (usize, usize, usize) {
    let text = mistake.source_code.inner();
    let (start, end) = (mistake.span.offset(), mistake.span.offset() + mistake.span.len());
    let before = text.get(..start).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |end| end + 1);
    let length = text.get(start..end).map_or(0, |marked| marked.chars().count());
    (1 + before.matches('\n').count(), 1 + before[line_start..].chars().count(), length)
}

/// A diagnostic as text, with the source underlined, without colours.
pub fn report(diagnostic: &dyn Diagnostic) -> String {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor());
    match handler.with_width(100).render_report(&mut text, diagnostic) {
        Ok(()) => text.trim_end().to_owned(),
        Err(_) => diagnostic.to_string(),
    }
}
