//! Mesh files as scenes use them: surfaces, distance fields and materials, read and built once.
//!
//! **Idea.** A mesh file becomes one surface in its own world space, with all its nodes placed. It is kept by the file's path, size and
//! time of change. A distance field takes seconds to build, so it is also kept in a directory that the program names
//! ([`set_mesh_cache`]), under the hash of the triangles. Anything wrong with a kept file only means that it is built again.

use crate::mesh_materials::{self, Converted, Pictures};
use glam::Vec4;
use pathmarch_field::mesh_shape::MeshError;
use pathmarch_field::{MeshOpacity, MeshSurface};
use pathmarch_mesh::grid::GridError;
use pathmarch_mesh::import::{Node, TooManyTriangles, Warning};
use pathmarch_mesh::{DistanceGrid, Imported, Material, ReadError, ReadOptions, TriangleMesh, material};
use sha2::{Digest, Sha256};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// More triangles are refused: they need about 2.5 GB.
const MAX_TRIANGLES: usize = 20_000_000;

static CACHE: OnceLock<PathBuf> = OnceLock::new();

/// Names the directory in which distance fields of meshes are kept; it need not exist. The first call counts.
pub fn set_mesh_cache(directory: PathBuf) {
    CACHE.get_or_init(|| directory);
}

/// Function that is called with the share of a distance field that is built, from 0 to 1, and may stop it.
pub type MeshProgress = dyn Fn(f32) -> ControlFlow<()> + Send + Sync;

static PROGRESS: OnceLock<Box<MeshProgress>> = OnceLock::new();

/// Names the function that is called while distance fields of meshes are built, from several threads; the last call has 1. The
/// first call of this function counts.
pub fn set_mesh_progress(progress: Box<MeshProgress>) {
    PROGRESS.get_or_init(|| progress);
}

fn report_progress(share: f32) -> ControlFlow<()> {
    PROGRESS.get().map_or(ControlFlow::Continue(()), |progress| progress(share))
}

/// Mesh file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MeshFileError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    TooMany(#[from] TooManyTriangles),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error("there is no node {number}: {count} nodes have a mesh")]
    NoNode { number: u32, count: usize },
}

/// Contents of a mesh file.
pub(crate) struct MeshFile {
    pub(crate) surface: Arc<MeshSurface>,
    /// Materials of its triangles, in the order of their indices; at least one.
    materials: Vec<Material>,
    images: Vec<material::Image>,
    /// The same as materials of a scene, and what is not shown of them; made on first use.
    scene_materials: OnceLock<Vec<Converted>>,
    /// Opacity of the materials; made on first use.
    opacity: OnceLock<Option<Arc<MeshOpacity>>>,
    pub(crate) warnings: Vec<Warning>,
    /// Fields built so far, by resolution.
    fields: Mutex<Vec<(u32, Arc<DistanceGrid>)>>,
}

impl MeshFile {
    /// Reads the file at `path`.
    pub(crate) fn load(path: &Path) -> Result<Self, MeshFileError> {
        Self::new(Self::read(path)?)
    }

    /// Contents of the file at `path`.
    pub(crate) fn read(path: &Path) -> Result<Imported, MeshFileError> {
        Ok(pathmarch_mesh::read(path, &ReadOptions::default())?)
    }

    /// One node of a file, counted from 1 among those with a mesh.
    pub(crate) fn of_node(imported: &Imported, number: u32) -> Result<Self, MeshFileError> {
        let with_mesh = imported.nodes.iter().filter(|node| node.mesh.is_some());
        let count = with_mesh.clone().count();
        let node = with_mesh.clone().nth(number as usize - 1).ok_or(MeshFileError::NoNode { number, count })?;
        let mesh = node.mesh.and_then(|mesh| imported.meshes.get(mesh)).cloned().unwrap_or_default();
        Self::new(Imported {
            meshes: vec![mesh],
            nodes: vec![Node { mesh: Some(0), parent: None, light: None, camera: None, ..node.clone() }],
            materials: imported.materials.clone(),
            images: imported.images.clone(),
            ..Imported::default()
        })
    }

    fn new(imported: Imported) -> Result<Self, MeshFileError> {
        let mut mesh = imported.merged(MAX_TRIANGLES)?;
        let Imported { materials, images, mut warnings, lights, cameras, .. } = imported;
        warnings.extend(left_out("light", lights.len()));
        warnings.extend(left_out("camera", cameras.len()));
        let materials = used_materials(&mut mesh, materials);
        keep_used_attributes(&mut mesh, &materials);
        let surface = Arc::new(MeshSurface::new(mesh)?);
        let (scene_materials, opacity) = (OnceLock::new(), OnceLock::new());
        Ok(Self { surface, materials, images, scene_materials, opacity, warnings, fields: Mutex::default() })
    }

    /// Its materials as those of a scene, and what is not shown of each.
    pub(crate) fn scene_materials(&self) -> &[Converted] {
        let has_colours = !self.surface.mesh().colours.is_empty();
        self.scene_materials.get_or_init(|| {
            let mut pictures = Pictures::new(&self.images);
            self.materials.iter().map(|source| mesh_materials::convert(source, &mut pictures, has_colours)).collect()
        })
    }

    /// Opacity of its materials.
    pub(crate) fn opacity(&self) -> Option<Arc<MeshOpacity>> {
        self.opacity.get_or_init(|| mesh_materials::opacity(&self.materials, &self.images)).clone()
    }

    /// Distance field with this number of voxels along its longest edge.
    pub(crate) fn field(&self, resolution: u32) -> Result<Arc<DistanceGrid>, GridError> {
        let mut fields = self.fields.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, grid)) = fields.iter().find(|(known, _)| *known == resolution) {
            return Ok(Arc::clone(grid));
        }
        let grid = Arc::new(kept_grid(self.surface.mesh(), resolution)?);
        fields.push((resolution, Arc::clone(&grid)));
        Ok(grid)
    }
}

/// Warning of lights or cameras in a file, which a mesh does not place.
fn left_out(what: &str, count: usize) -> Option<Warning> {
    let message = format!("a `mesh` has no {what}s; `pathmarch import` reads them");
    (count > 0).then(|| Warning { place: format!("{what}s"), message, count })
}

/// Leaves out colours that are all white, and tangents without a normal map; computes those that a normal map lacks.
fn keep_used_attributes(mesh: &mut TriangleMesh, materials: &[Material]) {
    if mesh.colours.iter().all(|&colour| colour == Vec4::ONE) {
        mesh.colours = Vec::new();
    }
    if materials.iter().all(|material| material.normal_texture.is_none()) {
        mesh.tangents = Vec::new();
        return;
    }
    let uv_set =
        |material: u32| materials.get(material as usize)?.normal_texture.as_ref().map(|texture| texture.uv_set);
    mesh.add_tangents(uv_set);
}

/// Keeps the materials that triangles have, and renumbers them.
fn used_materials(mesh: &mut TriangleMesh, materials: Vec<Material>) -> Vec<Material> {
    let mut numbers = vec![u32::MAX; materials.len().max(1)];
    let mut used = Vec::new();
    for triangle in 0..mesh.triangles.len() {
        let index = (mesh.material(triangle) as usize).min(numbers.len() - 1);
        if numbers[index] == u32::MAX {
            numbers[index] = used.len() as u32;
            used.push(materials.get(index).cloned().unwrap_or_else(Material::plain));
        }
    }
    for material in &mut mesh.materials {
        *material = numbers[(*material as usize).min(numbers.len() - 1)];
    }
    if used.len() <= 1 {
        mesh.materials.clear();
    }
    used
}

/// Grid of a mesh, from the directory of kept ones if it is there.
fn kept_grid(mesh: &TriangleMesh, resolution: u32) -> Result<DistanceGrid, GridError> {
    let path = CACHE.get().map(|directory| directory.join(format!("{}.grid", digest(mesh, resolution))));
    let kept = path.as_ref().and_then(|path| std::fs::read(path).ok());
    if let Some(grid) = kept.and_then(|bytes| DistanceGrid::from_bytes(&bytes).ok()) {
        return Ok(grid);
    }
    let grid = DistanceGrid::build(mesh, resolution, &report_progress);
    // The field is done, or stopped.
    let _is_stopped = report_progress(1.0);
    let grid = grid?;
    if let Some(path) = path {
        // Without it the field is built again the next time.
        drop(keep(&path, &grid.to_bytes()));
    }
    Ok(grid)
}

/// Writes a file under a name of its own, then renames it, so that no reader finds half of it.
fn keep(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let directory = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(directory)?;
    let unfinished = path.with_extension(format!("{}.part", std::process::id()));
    let mut file = std::fs::File::create(&unfinished)?;
    let written = file.write_all(bytes).and_then(|()| std::fs::rename(&unfinished, path));
    written.inspect_err(|_| drop(std::fs::remove_file(&unfinished)))
}

/// Hash of what a grid depends on, hexadecimal.
fn digest(mesh: &TriangleMesh, resolution: u32) -> String {
    let mut hash = Sha256::new();
    hash.update(resolution.to_le_bytes());
    hash.update((mesh.positions.len() as u64).to_le_bytes());
    mesh.positions.iter().flat_map(|p| p.to_array()).for_each(|v| hash.update(v.to_le_bytes()));
    mesh.triangles.iter().flatten().for_each(|v| hash.update(v.to_le_bytes()));
    hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}
