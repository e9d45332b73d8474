//! Meshes of a scene's objects, and the files they are kept in.
//!
//! **Idea.** [`mesh`] makes triangles of objects and paints them with the colours of their materials; [`save`] writes
//! them in the format that the name of the file asks for, under a temporary name that is changed when all is there.
//!
//! | Format | What it holds |
//! |---|---|
//! | `.stl`, binary | triangles and their normals |
//! | `.ply`, binary | shared vertices with colours, sRGB in bytes, as its readers expect |
//! | `.obj`, text | shared vertices with colours after the coordinates, sRGB from 0 to 1 |
//! | `.glb` (glTF 2.0) | vertices with normals and linear colours; those at sharp edges stand once for each side |
//!
//! All are in metres, with y up.
//!
//! **Source.** STL (3D Systems 1989), PLY (Turk 1994), OBJ (Wavefront 1990), glTF 2.0 (Khronos 2021). The formats are so small
//! that writing them takes fewer lines than filling the structures of a crate; the tests read them with crates.
//!
//! **Cost.** A million triangles take about 0.1 s, as text 1 s.

mod glb;
mod obj;
mod ply;
mod stl;

use crate::output::atomic_file;
use crate::settings::Settings;
use crate::shading::textured_point::TexturedPoint;
use crate::views::{ViewScene, display_colour};
use pathmarch_field::mesh::{Fineness, MeshError, Progress};
use pathmarch_field::{Aabb, Field, Mesh};
use pathmarch_scene::{Object, Scene, Sky};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// The file formats that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Binary STL.
    Stl,
    /// Binary PLY.
    Ply,
    /// OBJ, text.
    Obj,
    /// Binary glTF 2.0.
    Glb,
}

impl MeshFormat {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Stl, Self::Ply, Self::Obj, Self::Glb];

    /// What the names of its files end in, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Glb => "glb",
        }
    }

    /// The format that the name of a file asks for; upper and lower case are the same.
    ///
    /// # Errors
    /// [`MeshFileError::UnknownExtension`], which names the accepted ones.
    pub fn from_path(path: &Path) -> Result<Self, MeshFileError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        let format = Self::ALL.into_iter().find(|format| Some(format.extension()) == extension.as_deref());
        format.ok_or_else(|| MeshFileError::UnknownExtension { path: path.to_owned() })
    }
}

/// What went wrong with a file of a mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The name does not say which format is meant.
    #[error("{path}: the name of a mesh ends in .stl, .ply, .obj or .glb; rename it to one of these", path = path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
    },
    /// The file could not be written.
    #[error("{path}: cannot be written: {source}; check that its directory is there, is writable and has room", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// The mesh of the union of `objects` of a scene, in the colours of their materials (albedo, linear Rec. 709, with textures and
/// orbit traps as they are at each vertex; of a lamp, its radiance clipped to 1). See [`Mesh::new`].
///
/// # Errors
/// [`MeshError`].
pub fn mesh(
    scene: &Scene,
    objects: &[&Object],
    fineness: Fineness,
    cut: Option<Aabb>,
    progress: Progress,
) -> Result<Mesh, MeshError> {
    let roots: Vec<_> = objects.iter().map(|object| object.root.clone()).collect();
    let objects = objects.iter().map(|object| (*object).clone()).collect();
    // Only materials matter: no tables of a sky are made.
    let scene = Scene { objects, field: Field::new(&roots), sky: Sky::default(), ..scene.clone() };
    let view = ViewScene::new(&scene, &Settings::of(&scene));
    let ctx = view.context();
    let paint = |leaf: usize, p: [f32; 3], normal: [f32; 3]| {
        let varying = TexturedPoint::new(&ctx, leaf, p.into(), normal.into(), 0.0).and_then(|point| point.colour());
        varying.map_or_else(|| display_colour(&scene, scene.field.leaves()[leaf].tag), |colour| colour.to_array())
    };
    Mesh::new(&scene.field, fineness, cut, &paint, progress)
}

/// Writes a mesh. Whoever looks sees the file that was there before or the new one, never half of one.
///
/// # Errors
/// [`MeshFileError`].
pub fn save(path: &Path, mesh: &Mesh) -> Result<(), MeshFileError> {
    let format = MeshFormat::from_path(path)?;
    let write_error = |source| MeshFileError::Write { path: path.to_owned(), source };
    let mut writer = BufWriter::new(atomic_file::beside(path).map_err(write_error)?);
    let write = match format {
        MeshFormat::Stl => stl::write,
        MeshFormat::Ply => ply::write,
        MeshFormat::Obj => obj::write,
        MeshFormat::Glb => glb::write,
    };
    write(&mut writer, mesh).map_err(write_error)?;
    let file = writer.into_inner().map_err(|error| write_error(error.into_error()))?;
    file.persist(path).map_err(|error| write_error(error.error))?;
    Ok(())
}

/// BsdfParameters as bytes, the lowest first.
fn write_numbers(writer: &mut dyn Write, numbers: impl IntoIterator<Item = f32>) -> io::Result<()> {
    numbers.into_iter().try_for_each(|number| writer.write_all(&number.to_le_bytes()))
}
