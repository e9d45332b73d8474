//! State of the reader of nodes.

use crate::assets::Assets;
use crate::language::diagnostics::report::Report;
use crate::language::formulas::scope::Scope;
use std::path::{Path, PathBuf};

/// Diagnostics so far, and the names that formulas may use.
pub(crate) struct Context {
    pub(crate) report: Report,
    pub(crate) scope: Scope,
}

/// Files that a scene names.
pub(crate) struct Files<'f> {
    /// Path of the scene file, to which other paths are relative.
    pub(crate) scene: &'f str,
    pub(crate) assets: &'f mut Assets,
}

/// Path of a file that the scene file `scene` names.
pub(crate) fn relative_to(scene: &str, name: &str) -> PathBuf {
    Path::new(scene).parent().unwrap_or(Path::new("")).join(name)
}
