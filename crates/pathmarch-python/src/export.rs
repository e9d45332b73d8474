//! Meshes of the solids of a scene, as arrays and as files.

use crate::arrays;
use crate::exceptions::exception;
use crate::failure::Failure;
use crate::interruptible::{self, Callback};
use crate::names;
use crate::settings::whole;
use pathmarch_render::mesh_file::{self, MeshFormat};
use pathmarch_render::pathmarch_field::mesh::{Fineness, MeshError};
use pathmarch_render::pathmarch_field::{Aabb, Field, Mesh};
use pathmarch_render::pathmarch_scene::{Object, Scene};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

/// Cells along the longest side, if nothing else is given.
const RESOLUTION: u32 = 128;
/// Smallest and largest resolution.
const RESOLUTIONS: (u32, u32) = (1, 100_000);

/// Units in a metre.
const UNITS: [(&str, f64); 4] = [("mm", 1000.0), ("cm", 100.0), ("m", 1.0), ("inch", 1.0 / 0.0254)];

/// Solids of which a mesh is to be made.
pub struct Solids {
    scene: Arc<Scene>,
    /// Indices of the objects.
    objects: Vec<usize>,
    fineness: Fineness,
    bounds: Option<Aabb>,
}

impl Solids {
    /// Solids of these names, or all; a `cell` replaces the resolution.
    ///
    /// # Errors
    /// `ValueError` for unknown names, and for numbers out of range.
    pub fn new(
        scene: Arc<Scene>,
        resolution: Option<&Bound<PyAny>>,
        cell: Option<f32>,
        objects: Option<Vec<String>>,
        bounds: Option<Bound<PyAny>>,
    ) -> PyResult<Self> {
        let resolution = resolution.map_or(Ok(RESOLUTION), |value| whole("resolution", value, RESOLUTIONS))?;
        let fineness = match cell {
            Some(cell) if cell > 0.0 && cell.is_finite() => Fineness::Cell(cell),
            Some(cell) => {
                return Err(PyValueError::new_err(format!("cell: must be a length above 0, metres, not {cell}")));
            }
            None => Fineness::Resolution(resolution),
        };
        let objects = objects.map_or_else(|| Ok(solids(&scene)), |names| named(&scene, &names))?;
        Ok(Self { scene, objects, fineness, bounds: bounds.map(clip_box).transpose()? })
    }
}

/// Objects that have an inside.
fn solids(scene: &Scene) -> Vec<usize> {
    let is_sheet = |object: &Object| {
        Field::new(std::slice::from_ref(&object.root)).leaves().iter().all(|leaf| leaf.shape.info().sheet)
    };
    (0..scene.objects.len()).filter(|&index| !is_sheet(&scene.objects[index])).collect()
}

fn named(scene: &Scene, names: &[String]) -> PyResult<Vec<usize>> {
    let known: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    let index = |name: &String| {
        known.iter().position(|known| known == name).ok_or_else(|| names::unknown("objects", name, &known))
    };
    names.iter().map(index).collect()
}

fn clip_box(corners: Bound<PyAny>) -> PyResult<Aabb> {
    if let Ok((corners, _)) = arrays::points(&corners)
        && let [min, max] = corners[..]
        && (0..3).all(|axis| min[axis] < max[axis] && min[axis].is_finite() && max[axis].is_finite())
    {
        return Ok(Aabb { min, max });
    }
    let message = "bounds: expected the lower corner and the upper one, as in ((-1, 0, -1), (1, 2, 1))";
    Err(PyValueError::new_err(message))
}

/// Makes the mesh, metres.
///
/// # Errors
/// `ValueError` for solids that have no mesh, `Cancelled`, and exceptions of the callback.
pub fn mesh(py: Python, solids: Solids, progress: Option<Py<PyAny>>) -> PyResult<Mesh> {
    let callback = Callback { function: progress, total: 1.0 };
    let made = interruptible::run(py, &callback, move |watcher| {
        let Solids { scene, objects, fineness, bounds } = solids;
        let objects: Vec<&Object> = objects.iter().map(|&index| &scene.objects[index]).collect();
        mesh_file::mesh(&scene, &objects, fineness, bounds, &|share| {
            watcher.report(f64::from(share));
            if watcher.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    })?;
    made.map_err(|error| match error {
        MeshError::Stopped => exception(py, "Cancelled", ()),
        error => PyValueError::new_err(error.to_string()),
    })
}

/// Arrays of a mesh.
pub fn arrays(py: Python, mesh: Mesh) -> PyResult<Bound<PyDict>> {
    let Mesh { positions, normals, colours, triangles } = mesh;
    let all = PyDict::new(py);
    for (name, values) in [("positions", positions), ("normals", normals), ("colours", colours)] {
        let count = values.len();
        all.set_item(name, arrays::of_values(py, values.into_flattened(), &[count, 3])?)?;
    }
    let count = triangles.len();
    all.set_item("triangles", arrays::of_values(py, triangles.into_flattened(), &[count, 3])?)?;
    Ok(all)
}

/// A mesh file to write.
pub struct File {
    path: PathBuf,
    units_per_metre: f64,
}

impl File {
    /// File of this name, with numbers in this unit or in the usual one of its format.
    ///
    /// # Errors
    /// `ValueError` for unknown formats and units.
    pub fn new(path: PathBuf, unit: Option<&str>) -> PyResult<Self> {
        let format = MeshFormat::from_path(&path).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let usual = format.unit().unwrap_or(if format == MeshFormat::Stl { "mm" } else { "m" });
        let unit = unit.unwrap_or(usual);
        if format.unit().is_some_and(|only| only != unit) {
            let message =
                format!("unit: .{} files are in {usual}; leave it out, or write another format", format.extension());
            return Err(PyValueError::new_err(message));
        }
        Ok(Self { path, units_per_metre: names::find("unit", unit, UNITS)? })
    }

    /// Writes a mesh of a scene, and returns its number of triangles.
    ///
    /// # Errors
    /// [`Failure::File`] if the file cannot be written.
    pub fn write(&self, mut mesh: Mesh, scene: &Scene) -> Result<usize, Failure> {
        mesh.positions.iter_mut().flatten().for_each(|v| *v = (f64::from(*v) * self.units_per_metre) as f32);
        mesh_file::save(&self.path, &mesh, scene).map_err(|error| Failure::File(error.to_string()))?;
        Ok(mesh.triangles.len())
    }
}
