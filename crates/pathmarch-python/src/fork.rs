//! Refusal to compute in a forked process.
//!
//! The threads that compute do not exist in a process that was forked after they started; it would wait for them
//! forever.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::OnceLock;

/// Process in which the threads are.
static PROCESS: OnceLock<u32> = OnceLock::new();

/// Checks that this process may compute.
///
/// # Errors
/// `RuntimeError` in a process that was forked from one that has computed.
pub fn check() -> PyResult<()> {
    if *PROCESS.get_or_init(std::process::id) == std::process::id() {
        return Ok(());
    }
    Err(PyRuntimeError::new_err(
        "pathmarch was used before this process was forked, and its threads did not come along; start processes with \
         multiprocessing.get_context(\"spawn\")",
    ))
}
