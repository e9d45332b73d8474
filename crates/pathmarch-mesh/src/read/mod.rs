//! Readers of mesh files.
//!
//! **Idea.** [`read`] chooses the reader by the extension. A reader either understands a file as its format means, or returns an
//! error that names the place; what it leaves out is a [`Warning`](crate::import::Warning).
//!
//! | Format | Contents that are read |
//! |---|---|
//! | glTF 2.0 | meshes, nodes, materials, images, punctual lights, cameras |
//! | OBJ | polygons, colours, materials of MTL files |
//! | STL | triangles |
//! | PLY | polygons and strips, colours, texture coordinates |
//! | NPY | volumes of distances, whose surface becomes triangles |
//!
//! **Limits.** Memory is at most a constant times the size of the file and those it names, whatever they contain; time is
//! proportional to it but for concave polygons (`polygon.rs`). Other files must be at relative paths. **Differences.** The parsers
//! are our own: those of `gltf`, `tobj`, `stl_io` and `ply-rs-bw` panic, reserve what a header declares, or name no
//! place. The tests compare with them.

mod error;
mod files;
mod gltf;
mod mtl;
mod npy;
mod obj;
mod ply;
mod polygon;
mod stl;
mod text;

pub use error::{Mistake, ReadError};

use crate::import::Imported;
use crate::material::Material;
use crate::triangle_mesh::TriangleMesh;
use error::Warnings;
use files::Companions;
use glam::Vec3;
use std::path::Path;

/// Settings of [`read`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Largest size of each file, bytes.
    pub max_file_bytes: u64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { max_file_bytes: 4 << 30 }
    }
}

/// Extensions of mesh files, without the dot.
pub const EXTENSIONS: [&str; 6] = ["glb", "gltf", "obj", "stl", "ply", "npy"];

/// Reads a mesh file, and the files that it names.
///
/// # Errors
/// [`ReadError`]: an unknown extension, a file that cannot be opened or is too large, or a mistake in it.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Imported, ReadError> {
    let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    let unknown = || ReadError::UnknownExtension { path: path.to_owned() };
    let extension = extension.filter(|extension| EXTENSIONS.contains(&extension.as_str())).ok_or_else(unknown)?;
    let bytes = files::read_file(path, options)?;
    read_bytes(&bytes, &extension, path, options)
}

/// Reads the contents of a mesh file with an extension of [`EXTENSIONS`]. Files that it names are relative to `path`.
///
/// # Errors
/// [`ReadError`].
pub fn read_bytes(bytes: &[u8], extension: &str, path: &Path, options: &ReadOptions) -> Result<Imported, ReadError> {
    let companions = Companions::new(path, options);
    let mut warnings = Warnings::default();
    let of_mesh = |mesh: TriangleMesh| {
        let plain = Material::plain();
        let base_colour = if mesh.colours.is_empty() { plain.base_colour } else { Vec3::ONE };
        Imported::of_mesh(mesh, vec![Material { base_colour, ..plain }])
    };
    let imported = match extension {
        "glb" | "gltf" => gltf::read(bytes, &companions, &mut warnings),
        "obj" => obj::read(bytes, &companions, &mut warnings),
        "stl" => stl::read(bytes, &mut warnings).map(of_mesh),
        "ply" => ply::read(bytes, &mut warnings).map(of_mesh),
        "npy" => npy::read(bytes, &mut warnings).map(of_mesh),
        _ => return Err(ReadError::UnknownExtension { path: path.to_owned() }),
    };
    let checked = imported.and_then(|imported| drop_unusable(imported, &mut warnings));
    let mut imported = checked.map_err(|mistake| ReadError::Contents { path: path.to_owned(), mistake })?;
    imported.warnings = warnings.into_list();
    Ok(imported)
}

/// Leaves out triangles whose coordinates are not finite. An error if no triangle is left.
fn drop_unusable(mut imported: Imported, warnings: &mut Warnings) -> Result<Imported, Mistake> {
    let mut total = 0;
    for (index, mesh) in imported.meshes.iter_mut().enumerate() {
        let dropped = mesh.drop_unusable().not_finite;
        total += dropped;
        if dropped > 0 {
            let message = format!("{dropped} triangles with infinite or huge coordinates are left out");
            warnings.add(format!("mesh {index}"), message);
        }
    }
    if imported.meshes.iter().all(|mesh| mesh.triangles.is_empty()) {
        let problem = match total {
            0 => "there are no triangles".to_string(),
            _ => format!("all {total} triangles have infinite or huge coordinates"),
        };
        return Err(Mistake::with_remedy("file", problem, "export a surface of triangles"));
    }
    Ok(imported)
}
