//! The class `Scene`.

use crate::arrays;
use crate::diagnostics::{diagnostics, report};
use crate::exceptions::class;
use crate::export::{self, Solids};
use crate::failure::Failure;
use crate::field;
use crate::interruptible::{self, Callback};
use crate::parameters;
use crate::source::Source;
use pathmarch_render::pathmarch_scene::{self as scene, Animation, Moment};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Largest time of an animation, seconds.
const MAX_TIME: f64 = 1e9;

/// A scene: its text, checked, with everything that it names.
///
/// `source` is the text of a scene, or the path of a file. A text with mistakes raises `SceneError`, which has every
/// mistake with its line and column; what is most likely not intended is a `SceneWarning`. `time` is that of an
/// animation, in seconds. A text reads files relative to `folder`, and none outside of it unless `allow_files` is true.
///
/// >>> import pathmarch
/// >>> scene = pathmarch.Scene("""
/// ...     pathmarch 1
/// ...     param radius 1 min=0.1 max=2 doc="Of the ball, metres."
/// ...     camera { position 0 1 4; target 0 0 0 }
/// ...     sky 1
/// ...     object ball { sphere radius }
/// ... """)
/// >>> scene.parameters[0].name, scene.parameters[0].range
/// ('radius', (0.1, 2.0))
/// >>> float(scene.distance([3, 0, 0])), float(scene.with_params(radius=2).distance([3, 0, 0]))
/// (2.0, 1.0)
#[pyclass(frozen, module = "pathmarch")]
#[derive(Clone)]
pub struct Scene {
    source: Source,
    time: f64,
    moving: Moving,
}

/// A scene at a moment, and at all others.
#[derive(Clone)]
pub struct Moving {
    pub scene: Arc<scene::Scene>,
    pub animation: Arc<Mutex<Animation>>,
}

impl Scene {
    /// Reads a scene.
    ///
    /// # Errors
    /// `SceneError` with every mistake, and `ValueError` for a time that is none.
    fn read(py: Python, source: Source, time: Option<f64>) -> PyResult<Self> {
        let time = checked(time.unwrap_or(0.0))?;
        let (animation, fps) = (Arc::new(Mutex::new(source.animation())), None);
        let moving = interruptible::run(py, &NO_CALLBACK, move |_| moment_of(animation, time, fps))??;
        Ok(Self { source, time, moving })
    }

    /// Reads a scene, and warns of what is most likely not intended.
    ///
    /// # Errors
    /// Those of [`read`](Self::read), and warnings that Python was told to raise.
    pub fn open(py: Python, source: Source, time: Option<f64>) -> PyResult<Self> {
        let scene = Self::read(py, source, time)?;
        let category = class(py, "SceneWarning")?;
        for warning in &scene.scene().warnings {
            let text = CString::new(format!("\n{}", report(warning)).replace('\0', "?")).unwrap_or_default();
            PyErr::warn(py, &category, &text, 1)?;
        }
        Ok(scene)
    }

    /// The scene at a time, or at its own; `fps` replaces that of the scene.
    ///
    /// # Errors
    /// `SceneError` if the animation is no scene at this time, and `ValueError` for a time that is none.
    pub fn at_time(&self, py: Python, time: Option<f64>, fps: Option<f32>) -> PyResult<Moving> {
        let time = checked(time.unwrap_or(self.time))?;
        if time == self.time && fps.is_none_or(|fps| fps == self.moving.scene.render.fps) {
            return Ok(self.moving.clone());
        }
        let animation = self.moving.animation.clone();
        Ok(interruptible::run(py, &NO_CALLBACK, move |_| moment_of(animation, time, fps))??)
    }

    /// The same with other values of parameters.
    ///
    /// # Errors
    /// `ValueError` for parameters that it has not, and for values that they cannot have.
    pub fn with_values(&self, py: Python, values: &Bound<PyDict>) -> PyResult<Self> {
        let (values, source) = (parameters::values(values)?, self.source.clone());
        let source = interruptible::run(py, &NO_CALLBACK, move |_| parameters::replaced(source, &values))??;
        Self::read(py, source, Some(self.time))
    }

    /// The scene at its own time.
    pub fn scene(&self) -> &scene::Scene {
        &self.moving.scene
    }
}

const NO_CALLBACK: Callback = Callback { function: None, total: 0.0 };

fn checked(time: f64) -> PyResult<f64> {
    if (0.0..=MAX_TIME).contains(&time) {
        return Ok(time);
    }
    Err(PyValueError::new_err(format!("time: must be a number of seconds from 0 to {MAX_TIME}, not {time}")))
}

fn moment_of(animation: Arc<Mutex<Animation>>, time: f64, fps: Option<f32>) -> Result<Moving, Failure> {
    let mut locked = animation.lock().unwrap_or_else(PoisonError::into_inner);
    let mut scene = locked.at(Moment::default())?;
    if time > 0.0 {
        scene = locked.at(Moment::of_seconds(time, fps.unwrap_or(scene.render.fps)))?;
    }
    drop(locked);
    Ok(Moving { scene: Arc::new(scene), animation })
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (source, *, time = 0.0, folder = None, allow_files = false))]
    fn new(py: Python, source: &Bound<PyAny>, time: f64, folder: Option<PathBuf>, allow_files: bool) -> PyResult<Self> {
        Self::open(py, Source::of(source, folder, allow_files)?, Some(time))
    }

    /// Text of the scene. It is the whole truth about it: `Scene(scene.text)` is the same scene.
    #[getter]
    fn text(&self) -> &str {
        &self.source.text
    }

    /// Path of the file, or of the file that the text would be.
    #[getter]
    fn name(&self) -> &str {
        &self.source.name
    }

    /// Time of the scene, seconds.
    #[getter]
    fn time(&self) -> f64 {
        self.time
    }

    /// True if anything depends on the time.
    #[getter]
    fn animated(&self) -> bool {
        self.scene().animated
    }

    /// Parameters that the text declares, with name, value, range and doc.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        parameters::listed(py, &self.scene().params)
    }

    /// Names of the cameras; the first one is the default.
    #[getter]
    fn cameras<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.scene().cameras.iter().map(|camera| &camera.name))
    }

    /// Names of the materials, in the order of the layer "materialId".
    #[getter]
    fn materials<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.scene().materials.iter().map(|material| &material.name))
    }

    /// Names of the objects, in the order of the layer "objectId".
    #[getter]
    fn objects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.scene().objects.iter().map(|object| &object.name))
    }

    /// Lower and upper corner of a box around all objects, metres; infinite for endless ones.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let bounds = self.scene().field.bounds();
        arrays::of_values(py, [bounds.min, bounds.max].concat(), &[2, 3])
    }

    /// Diagnostics of what is allowed, but most likely not intended.
    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        diagnostics(py, &self.scene().warnings)
    }

    /// The scene with other values of its parameters: numbers, or formulas as texts.
    ///
    /// Only their values in the text change; comments and layout stay.
    #[pyo3(signature = (**values))]
    fn with_params(&self, py: Python, values: Option<&Bound<PyDict>>) -> PyResult<Self> {
        values.map_or_else(|| Ok(self.clone()), |values| self.with_values(py, values))
    }

    /// The scene at another time, seconds.
    fn at(&self, py: Python, time: f64) -> PyResult<Self> {
        Ok(Self { source: self.source.clone(), time, moving: self.at_time(py, Some(time), None)? })
    }

    /// Path-traces the scene: see `pathmarch.render`.
    #[pyo3(signature = (*args, **options))]
    #[pyo3(text_signature = "($self, size=None, samples=None, seed=0, backend='auto', camera=None, time=None, \
        params=None, layers=(), progress=None, *, denoise=None, mode='path', adapter=None, **settings)")]
    fn render<'py>(
        slf: &Bound<'py, Self>,
        args: &Bound<'py, PyTuple>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let with_scene: Vec<Bound<PyAny>> = std::iter::once(slf.clone().into_any()).chain(args.iter()).collect();
        let function = slf.py().import("pathmarch._native")?.getattr("render")?;
        function.call(PyTuple::new(slf.py(), with_scene)?, options)
    }

    /// Signed distance of each point to the nearest surface, metres: negative inside, infinite without objects.
    ///
    /// `points` is an array of N x 3 numbers, or of more axes, the last of which has x, y and z. The result is float32,
    /// as are the numbers that the renderer itself uses.
    ///
    /// >>> import pathmarch
    /// >>> ball = pathmarch.Scene("pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\nobject ball { sphere }")
    /// >>> ball.distance([[0, 0, 0], [3, 0, 0]]).tolist()
    /// [-1.0, 2.0]
    fn distance<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (points, shape) = arrays::points(points)?;
        arrays::of_values(py, field::distances(py, &self.scene().field, &points)?, &shape)
    }

    /// Exact gradient of the distance at each point: the surface's normal there, of length 1 where the distance is
    /// exact.
    ///
    /// >>> import pathmarch
    /// >>> ball = pathmarch.Scene("pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\nobject ball { sphere }")
    /// >>> ball.gradient([[0, 2, 0]]).tolist()
    /// [[0.0, 1.0, 0.0]]
    fn gradient<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (points, mut shape) = arrays::points(points)?;
        shape.push(3);
        arrays::of_values(py, field::gradients(py, &self.scene().field, &points)?.into_flattened(), &shape)
    }

    /// Triangles of the solids: a dictionary of the arrays `positions`, `normals`, `colours` and `triangles`.
    ///
    /// `resolution` is the number of cells along the longest side; `cell` is the size of a cell instead, metres.
    /// `objects` are names of objects, all solids without it. `bounds` clips to a box of two corners. `progress` is
    /// called with the fraction that is done and 1, and ends the work if it returns False.
    #[pyo3(signature = (resolution = None, *, cell = None, objects = None, bounds = None, progress = None))]
    #[pyo3(text_signature = "($self, resolution=128, *, cell=None, objects=None, bounds=None, progress=None)")]
    fn mesh<'py>(
        &self,
        py: Python<'py>,
        resolution: Option<Bound<'py, PyAny>>,
        cell: Option<f32>,
        objects: Option<Vec<String>>,
        bounds: Option<Bound<'py, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let solids = Solids::new(self.moving.scene.clone(), resolution.as_ref(), cell, objects, bounds)?;
        export::arrays(py, export::mesh(py, solids, progress)?)
    }

    /// Writes the solids as a mesh file: `.stl`, `.ply`, `.obj`, `.glb`, `.3mf`, `.usda` or `.usdz`, as `pathmarch export` does.
    ///
    /// `unit` is "mm", "cm", "m" or "inch"; without it millimetres for `.stl` and `.3mf`, metres for others. The other arguments
    /// are those of `mesh`. Returns the number of triangles.
    #[pyo3(signature = (path, resolution = None, *, cell = None, objects = None, bounds = None, unit = None,
        progress = None))]
    #[pyo3(text_signature = "($self, path, resolution=128, *, cell=None, objects=None, bounds=None, unit=None, \
        progress=None)")]
    #[expect(clippy::too_many_arguments, reason = "those of the method in Python")]
    fn export<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        resolution: Option<Bound<'py, PyAny>>,
        cell: Option<f32>,
        objects: Option<Vec<String>>,
        bounds: Option<Bound<'py, PyAny>>,
        unit: Option<&str>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<usize> {
        let file = export::File::new(path, unit)?;
        let solids = Solids::new(self.moving.scene.clone(), resolution.as_ref(), cell, objects, bounds)?;
        let mesh = export::mesh(py, solids, progress)?;
        let scene = &self.moving.scene;
        Ok(py.detach(|| file.write(mesh, scene))?)
    }

    fn __repr__(&self) -> String {
        let (objects, name) = (self.scene().objects.len(), &self.source.name);
        format!("<pathmarch.Scene {name:?}: {objects} object{}>", if objects == 1 { "" } else { "s" })
    }

    /// Scenes are copied to other processes as texts.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let Source { name, text, allow_files } = &self.source;
        let make = class(py, "restored_scene")?;
        let arguments = (text, name, self.time, *allow_files).into_pyobject(py)?;
        Ok((make, arguments))
    }
}
