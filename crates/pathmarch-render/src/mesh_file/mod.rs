//! Meshes of a scene's objects, and mesh files.
//!
//! **Idea.** [`mesh`] triangulates objects and colours the vertices with their materials. [`save`] writes the mesh in the
//! format of the file's extension, under a temporary name that is changed when the file is complete.
//!
//! | Format | Contents |
//! |---|---|
//! | `.stl`, binary | triangles and their normals |
//! | `.ply`, binary | shared vertices with colours, 8-bit sRGB, as its readers expect |
//! | `.obj`, text | shared vertices with colours after the coordinates, sRGB from 0 to 1 |
//! | `.glb` (glTF 2.0) | vertices with normals and linear colours, those at sharp edges duplicated for each side; cameras |
//! | `.3mf` | triangles and colours, for printers: millimetres |
//! | `.usda`, text, and `.usdz` | vertices with normals and linear colours, as in `.glb` |
//!
//! Coordinates are written as they are, with y up. glTF and USD say that they are metres, and 3MF millimetres: see
//! [`MeshFormat::unit`].
//!
//! **Source.** STL (3D Systems 1989), PLY (Turk 1994), OBJ (Wavefront 1990), glTF 2.0 (Khronos 2021). 3MF and USD: see their
//! files. The formats are so simple that writing them takes fewer lines than filling the structures of a crate. The tests read
//! the files with crates.
//!
//! **Cost.** A million triangles take about 0.1 s, as text 1 s.

mod glb;
mod obj;
mod ply;
mod split_mesh;
mod stl;
mod three_mf;
mod usd;

use crate::output::atomic_file::AtomicFile;
use crate::settings::Settings;
use crate::shading::textured_point::TexturedPoint;
use crate::views::{ViewScene, display_colour};
use pathmarch_field::mesh::{Fineness, MeshError, Progress};
use pathmarch_field::{Aabb, Field, Mesh};
use pathmarch_scene::{Object, Scene, Sky};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Mesh file formats.
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
    /// 3MF.
    ThreeMf,
    /// USD, text.
    Usda,
    /// USD, archive.
    Usdz,
}

impl MeshFormat {
    /// All formats.
    pub const ALL: [Self; 7] = [Self::Stl, Self::Ply, Self::Obj, Self::Glb, Self::ThreeMf, Self::Usda, Self::Usdz];

    /// Extension of file names, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::ThreeMf => "3mf",
            Self::Usda => "usda",
            Self::Usdz => "usdz",
        }
    }

    /// Unit that files of this format are in: "mm" or "m". `None` if the format leaves it open.
    pub fn unit(self) -> Option<&'static str> {
        match self {
            Self::Stl | Self::Ply | Self::Obj => None,
            Self::Glb | Self::Usda | Self::Usdz => Some("m"),
            Self::ThreeMf => Some("mm"),
        }
    }

    /// Format of a file name's extension, in any case.
    ///
    /// # Errors
    /// [`MeshFileError::UnknownExtension`], which names the accepted ones.
    pub fn from_path(path: &Path) -> Result<Self, MeshFileError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        let format = Self::ALL.into_iter().find(|format| Some(format.extension()) == extension.as_deref());
        format.ok_or_else(|| MeshFileError::UnknownExtension { path: path.to_owned() })
    }
}

/// Failure of writing a mesh file. Every message names the file and suggests a remedy.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The extension of the name is not that of a mesh format.
    #[error("{path}: the extension of a mesh must be .stl, .ply, .obj, .glb, .3mf, .usda or .usdz; rename the file", path = path.display())]
    UnknownExtension {
        /// Path of the file.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("{path}: cannot be written: {source}; check that its directory exists, its permissions and the free space", path = path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// Mesh of the union of some objects of a scene. The colour of a vertex is the albedo of its material, linear Rec. 709, with
/// textures and orbit traps evaluated at the vertex; for an emitter, its radiance clipped to 1. See [`Mesh::new`].
///
/// # Errors
/// [`MeshError`]: a solid without bounds or inside, too many cells, or cancellation.
pub fn mesh(
    scene: &Scene,
    objects: &[&Object],
    fineness: Fineness,
    cut: Option<Aabb>,
    progress: Progress,
) -> Result<Mesh, MeshError> {
    let roots: Vec<_> = objects.iter().map(|object| object.root.clone()).collect();
    let objects = objects.iter().map(|object| (*object).clone()).collect();
    // Only materials matter; the default sky needs no tables.
    let scene = Scene { objects, field: Field::new(&roots), sky: Sky::default(), ..scene.clone() };
    let view = ViewScene::new(&scene, &Settings::of(&scene));
    let ctx = view.context();
    let vertex_colour = |leaf: usize, p: [f32; 3], normal: [f32; 3]| {
        let textured = TexturedPoint::at(
            &ctx,
            leaf,
            (p.into(), normal.into(), pathmarch_scene::textures::MeshAttributes::default()),
            0.0,
        )
        .and_then(|point| point.colour());
        textured.map_or_else(|| display_colour(&scene, scene.field.leaves()[leaf].tag), |colour| colour.to_array())
    };
    Mesh::new(&scene.field, fineness, cut, &vertex_colour, progress)
}

/// Writes a mesh in the format of the file's extension. Replaces an existing file atomically. A `.glb` file has the
/// scene's cameras, too, as pinhole cameras with the aspect ratio of its picture; the other formats leave them out.
///
/// # Errors
/// [`MeshFileError`]: an unknown extension, or a file that cannot be written.
pub fn save(path: &Path, mesh: &Mesh, scene: &Scene) -> Result<(), MeshFileError> {
    let format = MeshFormat::from_path(path)?;
    let write_error = |source| MeshFileError::Write { path: path.to_owned(), source };
    let mut writer = BufWriter::new(AtomicFile::create(path).map_err(write_error)?);
    let written = match format {
        MeshFormat::Stl => stl::write(&mut writer, mesh),
        MeshFormat::Ply => ply::write(&mut writer, mesh),
        MeshFormat::Obj => obj::write(&mut writer, mesh),
        MeshFormat::Glb => glb::write(&mut writer, mesh, scene),
        MeshFormat::ThreeMf => three_mf::write(&mut writer, mesh),
        MeshFormat::Usda => usd::write_text(&mut writer, mesh),
        MeshFormat::Usdz => usd::write_archive(&mut writer, mesh),
    };
    written.map_err(write_error)?;
    let file = writer.into_inner().map_err(|error| write_error(error.into_error()))?;
    file.commit().map_err(write_error)
}

/// Writes 32-bit floats in little-endian order.
fn write_numbers(writer: &mut dyn Write, numbers: impl IntoIterator<Item = f32>) -> io::Result<()> {
    numbers.into_iter().try_for_each(|number| writer.write_all(&number.to_le_bytes()))
}
