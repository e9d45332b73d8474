//! State of the reader of nodes.

use crate::assets::Assets;
use crate::language::diagnostics::report::{Report, draft};
use crate::language::formulas::scope::Scope;
use crate::language::tree::{Entry, Span};
use pathmarch_mesh::files;
use std::path::{Path, PathBuf};

/// Diagnostics so far, and the names that formulas may use.
pub(crate) struct Context {
    pub(crate) report: Report,
    pub(crate) scope: Scope,
    /// Colours that are written as such, in the order in which they are read.
    pub(crate) colours: Vec<WrittenColour>,
    /// Folder outside of which no file is read; `None` for no limit.
    pub(crate) folder: Option<PathBuf>,
}

/// A colour in a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WrittenColour {
    /// Span of its numbers, or of its string.
    pub(crate) span: Span,
    /// Linear Rec. 709.
    pub(crate) value: [f32; 3],
}

/// Folder of the scene file `scene`, without detours.
pub(crate) fn folder_of(scene: &str) -> PathBuf {
    let folder = Path::new(scene).parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    files::canonicalize(folder).unwrap_or_else(|_| folder.to_owned())
}

impl Context {
    /// Reports a file that must not be read, and returns true.
    pub(crate) fn refuses(&mut self, path: &Path, entry: &Entry) -> bool {
        let Some(folder) = &self.folder else { return false };
        // A file that is missing is reported when it is read.
        let Ok(whole) = files::canonicalize(path) else { return false };
        if whole.starts_with(folder) {
            return false;
        }
        let mistake = draft("pathmarch::outside", entry.value_span, "This file is outside the folder of the scene.");
        let help = "Copy it there; or, if you trust the scene, allow it: with --allow-files, in the window with File, Allow other files.";
        self.report.add(mistake.label("not read").help(help));
        true
    }
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
