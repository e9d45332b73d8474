//! Names that Python gives: lists of them, and suggestions for misspelt ones.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The value of this name.
///
/// # Errors
/// `ValueError` with all names, and the nearest one.
pub fn find<T: Copy>(what: &str, asked: &str, all: impl IntoIterator<Item = (&'static str, T)>) -> PyResult<T> {
    let all: Vec<_> = all.into_iter().collect();
    let found = all.iter().find(|(name, _)| *name == asked).map(|(_, value)| *value);
    found.ok_or_else(|| unknown(what, asked, &all.iter().map(|(name, _)| *name).collect::<Vec<_>>()))
}

/// Error for a name that does not exist.
pub fn unknown(what: &str, asked: &str, names: &[&str]) -> PyErr {
    PyValueError::new_err(message(what, asked, names))
}

/// Message about a name that does not exist.
pub fn message(what: &str, asked: &str, names: &[&str]) -> String {
    let listed = names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    let known = if names.is_empty() { "there is none".to_owned() } else { format!("expected one of {listed}") };
    format!("{what}: there is no \"{asked}\"{}; {known}", hint(asked, names))
}

/// As in "; did you mean …?", if a name is near.
pub fn hint(asked: &str, names: &[&str]) -> String {
    let distance = |name: &str| strsim::damerau_levenshtein(name, asked);
    let nearest = names.iter().min_by_key(|name| distance(name)).filter(|name| distance(name) <= 1 + asked.len() / 3);
    nearest.map_or_else(String::new, |name| format!("; did you mean \"{name}\"?"))
}
