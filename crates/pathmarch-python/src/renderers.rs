//! Opened backends, kept for the pictures to come.
//!
//! A device takes a tenth of a second and more to open, and it keeps the kernels that it has compiled.

use crate::failure::Failure;
use crate::fork;
use pathmarch_render::{Backend, Renderer, adapters};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

type Key = (Backend, Option<String>);

/// The renderer that was opened last, and what was asked for.
static LATEST: Mutex<Option<(Key, Renderer)>> = Mutex::new(None);

/// A renderer on this backend; `adapter` is a part of the name of a GPU adapter.
///
/// # Errors
/// [`Failure::Render`] if there is no such backend.
pub fn renderer(backend: Backend, adapter: Option<String>) -> Result<Renderer, Failure> {
    let key = (backend, adapter);
    let mut latest = LATEST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, renderer)) = latest.as_ref().filter(|(known, _)| *known == key) {
        return Ok(renderer.clone());
    }
    let renderer = Renderer::open(backend, key.1.as_deref())?;
    *latest = Some((key, renderer.clone()));
    Ok(renderer)
}

/// Forgets the renderer, because its device may be lost.
pub fn forget() {
    *LATEST.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// GPU adapters that can render, as in "llvmpipe (Vulkan)". The CPU always can.
#[pyfunction]
pub fn devices(py: Python) -> PyResult<Vec<String>> {
    fork::check()?;
    let found = py.detach(adapters);
    let usable = found.iter().filter(|adapter| adapter.unusable.is_none());
    Ok(usable.map(|adapter| format!("{} ({})", adapter.name, adapter.backend)).collect())
}
