//! `pathmarch import`: makes a scene of a mesh file, with its objects, lights and cameras.

use pathmarch_cli::{DONE, Failure, check_output, note};
use pathmarch_render::pathmarch_scene::document::mesh_import::{import_mesh, scene_text};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Mesh file: .glb, .gltf, .obj, .stl, .ply or .npy
    file: PathBuf,
    /// Scene file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    check_output(&arguments.output)?;
    let folder = arguments.output.parent().unwrap_or(Path::new(""));
    let written = path_from(folder, &arguments.file);
    let import = import_mesh(&arguments.file, &written).map_err(|error| Failure::Usage(error.to_string()))?;
    for warning in &import.warnings {
        note!("warning: {warning}");
    }
    let failed = |error: std::io::Error| Failure::Other(format!("{}: {error}", arguments.output.display()));
    std::fs::write(&arguments.output, scene_text(&import)).map_err(failed)?;
    note!("wrote {}: {} nodes", arguments.output.display(), import.nodes.len());
    Ok(DONE)
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
