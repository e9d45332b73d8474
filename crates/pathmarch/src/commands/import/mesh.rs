//! Scenes of mesh files, with their objects, lights and cameras.

use super::Import;
use pathmarch_cli::{Failure, note};
use pathmarch_render::pathmarch_scene::document::mesh_import::{import_mesh, scene_text};
use std::path::{Path, PathBuf};

/// Scene of a mesh file, to be written to this folder.
pub(super) fn import(file: &Path, folder: &Path) -> Result<Import, Failure> {
    let written = path_from(folder, file);
    let import = import_mesh(file, &written).map_err(|error| Failure::Usage(error.to_string()))?;
    for warning in &import.warnings {
        note!("warning: {warning}");
    }
    Ok(Import { text: scene_text(&import), summary: format!("{} nodes", import.nodes.len()) })
}

/// Path of a file as a scene in this folder names it: relative if it is in the folder, else absolute.
pub fn path_from(folder: &Path, file: &Path) -> String {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (folder, file) =
        (absolute(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }), absolute(file));
    // A trailing `.` would be no prefix.
    let folder: PathBuf = folder.components().collect();
    let path = file.strip_prefix(&folder).unwrap_or(&file);
    path.to_string_lossy().replace('\\', "/")
}
