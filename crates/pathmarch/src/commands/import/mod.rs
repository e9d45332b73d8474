//! `pathmarch import`: makes a scene of a mesh file or of a shader.

mod mesh;
mod shader;

use pathmarch_cli::{DONE, Failure, check_output, note};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Mesh file (.glb, .gltf, .obj, .stl, .ply or .npy), or a shader in GLSL with a distance function (.frag, .glsl, .fs or .txt)
    file: PathBuf,
    /// Scene file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Distance function of a shader [default: map, DE or another usual name]
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
}

/// Extensions of shaders.
const SHADERS: [&str; 4] = ["frag", "glsl", "fs", "txt"];

/// Text of a scene, and a few words on it.
struct Import {
    text: String,
    summary: String,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Arguments { file, output, entry } = arguments;
    check_output(output)?;
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let import = if extension.is_some_and(|extension| SHADERS.contains(&&*extension)) {
        shader::import(file, entry.as_deref())?
    } else if entry.is_some() {
        let extensions = SHADERS.map(|extension| format!(".{extension}")).join(", ");
        return Err(Failure::Usage(format!("--entry is for shaders ({extensions}); {} is none", file.display())));
    } else {
        mesh::import(file, output.parent().unwrap_or(Path::new("")))?
    };
    let failed = |error: std::io::Error| Failure::Other(format!("{}: {error}", output.display()));
    std::fs::write(output, import.text).map_err(failed)?;
    note!("wrote {}: {}", output.display(), import.summary);
    Ok(DONE)
}

#[cfg(feature = "window")]
pub use mesh::path_from;
