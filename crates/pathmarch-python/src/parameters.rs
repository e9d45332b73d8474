//! Parameters of a scene, which its text declares by `param`.

use crate::exceptions::class;
use crate::failure::Failure;
use crate::names::message;
use crate::source::Source;
use pathmarch_render::pathmarch_scene::Parameter;
use pathmarch_render::pathmarch_scene::document::{Document, ItemKind, Path, Value, key};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// A name, and a number or a formula as text.
pub type Given = (String, String);

/// A tuple of `Parameter`.
pub fn listed<'py>(py: Python<'py>, parameters: &[Parameter]) -> PyResult<Bound<'py, PyTuple>> {
    let class = class(py, "Parameter")?;
    let made = parameters.iter().map(|Parameter { name, value, range, doc, animated }| {
        let range = (range.0.map(decimal), range.1.map(decimal));
        class.call1((name, decimal(*value), range, doc.as_deref(), *animated))
    });
    PyTuple::new(py, made.collect::<PyResult<Vec<_>>>()?)
}

/// The double with the shortest decimals: 0.1 instead of 0.10000000149.
pub fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// Values of a dictionary, each a number or a formula.
///
/// # Errors
/// `TypeError` for others.
pub fn values(values: &Bound<PyDict>) -> PyResult<Vec<Given>> {
    values.iter().map(|(name, value)| Ok((name.extract()?, text(&name, &value)?))).collect()
}

fn text(name: &Bound<PyAny>, value: &Bound<PyAny>) -> PyResult<String> {
    if let Ok(number) = value.extract::<f64>() {
        return Ok(number.to_string());
    }
    value.extract().map_err(|_| PyTypeError::new_err(format!("params: {name} must be a number or a formula as text")))
}

/// A source with other values of its parameters.
///
/// # Errors
/// [`Failure::Value`] for parameters that it has not, and for values that they cannot have.
pub fn replaced(source: Source, values: &[Given]) -> Result<Source, Failure> {
    let Source { name, text, allow_files } = source;
    let mut document = Document::confined(name, text);
    if allow_files {
        document.allow_files();
    }
    for (name, value) in values {
        let path = path_of(&document, name)?;
        let set = document.set(&path, key::VALUE, Value::Formulas(vec![value.clone()]), None);
        set.map_err(|error| Failure::Value(format!("params: {name}={value}: {error}")))?;
    }
    Ok(Source { name: document.name().to_owned(), text: document.text().to_owned(), allow_files })
}

fn path_of(document: &Document, name: &str) -> Result<Path, Failure> {
    let declared = || document.outline().iter().filter(|item| item.kind == ItemKind::Param);
    if let Some(item) = declared().find(|item| item.title() == name) {
        return Ok(item.path.clone());
    }
    let is_included =
        |scene: &pathmarch_render::pathmarch_scene::Scene| scene.params.iter().any(|one| one.name == name);
    if document.scene().is_ok_and(|scene| is_included(scene)) {
        return Err(Failure::Value(format!("params: {name} is declared by an included file; change it there")));
    }
    let names: Vec<&str> = declared().map(|item| item.title()).collect();
    Err(Failure::Value(message("params", name, &names)))
}
