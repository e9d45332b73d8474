//! The native part of the Python package `pathmarch`: scenes, pictures, distances and meshes as NumPy arrays.
//!
//! **Idea.** The package is written in two languages. This crate is the module `pathmarch._native`: it converts
//! arguments and results, and leaves all else to `pathmarch-render`. `python/pathmarch` is pure Python: exceptions, and
//! the functions that write scenes, which it makes from `registry.rs`'s description of the scene language. Long work
//! runs on a thread of its own without the interpreter's lock, see `interruptible.rs`.

mod arrays;
mod diagnostics;
mod display;
mod exceptions;
mod export;
mod failure;
mod field;
mod fork;
mod interruptible;
mod names;
mod parameters;
mod registry;
mod render;
mod renderers;
mod scene;
mod settings;
mod source;

use pathmarch_cli::{AppDirs, check_instruction_set};
use pathmarch_render::pathmarch_scene::set_mesh_cache;
use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

/// Scenes as text, path-traced to NumPy arrays.
#[pymodule]
fn _native(module: &Bound<PyModule>) -> PyResult<()> {
    check_instruction_set().map_err(PyImportError::new_err)?;
    if let Some(dirs) = AppDirs::of_user() {
        set_mesh_cache(dirs.meshes);
    }
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<scene::Scene>()?;
    module.add_function(wrap_pyfunction!(render::render, module)?)?;
    module.add_function(wrap_pyfunction!(display::tonemap, module)?)?;
    module.add_function(wrap_pyfunction!(display::encode, module)?)?;
    module.add_function(wrap_pyfunction!(display::save, module)?)?;
    module.add_function(wrap_pyfunction!(display::load, module)?)?;
    module.add_function(wrap_pyfunction!(renderers::devices, module)?)?;
    module.add_function(wrap_pyfunction!(registry::registry, module)?)
}
