//! `pathmarch.render`: pictures of scenes as NumPy arrays.

mod options;
mod task;

use crate::arrays;
use crate::exceptions::exception;
use crate::interruptible::{self, Callback};
use crate::scene::Scene;
use crate::source::Source;
use options::Options;
use pathmarch_render::aov::Layer;
use pathmarch_render::image::ChannelValues;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use task::Rendered;

/// Path-traces a scene, and returns its radiance: a float32 array of height x width x 3, linear Rec. 709.
///
/// `scene` is the text of a scene, the path of a file, or a `Scene`. Without `size` and `samples` the picture has those
/// of the scene. It is a pure function of the scene and these arguments, and on the CPU equal to that of the command
/// line.
///
/// - `backend`: "cpu", "gpu", or "auto" for the faster of both.
/// - `camera`: name of a camera of the scene; the first one without it.
/// - `time`: seconds since the start of an animation.
/// - `params`: new values of the scene's parameters, numbers or formulas.
/// - `layers`: names of noise-free layers, "albedo", "normal", "depth", "position", "objectId", "materialId",
/// "sampleCount", or "all". The result is then a dictionary of arrays, with the radiance as "picture".
/// - `progress`: function of the samples that are done and their number. It is called a few times a second; if it
/// returns False, rendering ends with `Cancelled`. Its exceptions end rendering, too, and so does Ctrl-C.
/// - `denoise`: "regression" or "oidn" filters the noise out of the picture.
/// - `mode`: quantity that the picture shows, such as "preview" or "normal"; "path" is radiance.
/// - `adapter`: part of the name of a GPU adapter.
/// - `folder`: folder of a text, to which its files are relative; `allow_files` lets it read others.
/// - All other settings of `render` in scenes: `bounces`, `detail`, `clamp`, `sampler`, `caustics`, `shutter` and so
/// on.
///
/// >>> import pathmarch
/// >>> ball = "pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\nobject ball { sphere 1 }"
/// >>> picture = pathmarch.render(ball, size=(32, 18), samples=4)
/// >>> picture.shape, str(picture.dtype)
/// ((18, 32, 3), 'float32')
#[pyfunction]
#[pyo3(signature = (scene, size = None, samples = None, seed = None, backend = "auto".to_owned(), camera = None,
    time = None, params = None, layers = None, progress = None, *, denoise = None, mode = "path".to_owned(),
    adapter = None, folder = None, allow_files = false, **settings))]
#[pyo3(
    text_signature = "(scene, size=None, samples=None, seed=0, backend='auto', camera=None, time=None, params=None, \
    layers=(), progress=None, *, denoise=None, mode='path', adapter=None, folder=None, allow_files=False, **settings)"
)]
#[expect(clippy::too_many_arguments, reason = "those of the function in Python")]
pub fn render<'py>(
    py: Python<'py>,
    scene: &Bound<'py, PyAny>,
    size: Option<Bound<'py, PyAny>>,
    samples: Option<Bound<'py, PyAny>>,
    seed: Option<Bound<'py, PyAny>>,
    backend: String,
    camera: Option<String>,
    time: Option<f64>,
    params: Option<Bound<'py, PyDict>>,
    layers: Option<Bound<'py, PyAny>>,
    progress: Option<Py<PyAny>>,
    denoise: Option<String>,
    mode: String,
    adapter: Option<String>,
    folder: Option<PathBuf>,
    allow_files: bool,
    settings: Option<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = Options { size, samples, seed, backend, camera, time, layers, denoise, mode, adapter, settings };
    let scene = match scene.cast::<Scene>() {
        Ok(_) if folder.is_some() || allow_files => {
            return Err(PyTypeError::new_err("folder and allow_files are for texts; give them to Scene(...)"));
        }
        Ok(scene) => scene.get().clone(),
        Err(_) => Scene::open(py, Source::of(scene, folder, allow_files)?, time)?,
    };
    let scene = match params {
        Some(params) => scene.with_values(py, &params)?,
        None => scene,
    };
    picture(py, &scene, &options, progress)
}

/// Renders a scene, and makes arrays of the result.
fn picture<'py>(
    py: Python<'py>,
    scene: &Scene,
    options: &Options<'py>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let render = options.render_settings(py, &scene.scene().render)?;
    let task = options.task(&scene.at_time(py, options.time, Some(render.fps))?, &render)?;
    let callback = Callback { function: progress, total: f64::from(task.settings.samples) };
    let rendered = interruptible::run(py, &callback, move |watcher| task.run(watcher))??;
    log(py, &rendered)?;
    if !rendered.complete {
        return Err(cancelled(py, rendered));
    }
    arrays_of(py, rendered)
}

/// Logs the backend, and why it is not the one that one would expect.
fn log(py: Python, rendered: &Rendered) -> PyResult<()> {
    let Rendered { picture, samples, backend, .. } = rendered;
    let notice = backend.notice.as_ref().map_or_else(String::new, |notice| format!("; {notice}"));
    let (width, height) = (picture.width, picture.height);
    let message = format!("{width}x{height}, {samples} samples, on {} ({}){notice}", backend.name, backend.adapter);
    let logger = py.import("logging")?.call_method1("getLogger", ("pathmarch",))?;
    logger.call_method1("info", ("%s", message)).map(|_| ())
}

/// The picture, or a dictionary if there are layers.
fn arrays_of(py: Python, rendered: Rendered) -> PyResult<Bound<PyAny>> {
    let shape = [rendered.picture.height as usize, rendered.picture.width as usize];
    let picture = arrays::of_picture(py, rendered.picture)?;
    if rendered.layers.is_empty() {
        return Ok(picture);
    }
    let all = PyDict::new(py);
    all.set_item("picture", picture)?;
    if let Some(noisy) = rendered.noisy {
        all.set_item("noisy", arrays::of_picture(py, noisy)?)?;
    }
    for (layer, channels) in rendered.layers {
        all.set_item(layer.name(), layer_array(py, layer, channels, shape)?)?;
    }
    Ok(all.into_any())
}

/// Array of height x width of a layer, or height x width x 3.
fn layer_array(
    py: Python,
    layer: Layer,
    channels: Vec<ChannelValues>,
    [height, width]: [usize; 2],
) -> PyResult<Bound<PyAny>> {
    let parts = layer.parts().len();
    let mut floats = vec![0.0; height * width * parts];
    for (part, values) in channels.into_iter().enumerate() {
        match values {
            ChannelValues::U32(values) => return arrays::of_values(py, values, &[height, width]),
            ChannelValues::F32(values) => {
                floats.iter_mut().skip(part).step_by(parts).zip(values).for_each(|(to, value)| *to = value);
            }
        }
    }
    let shape = [height, width, parts];
    arrays::of_values(py, floats, if parts == 1 { &shape[..2] } else { &shape })
}

/// `Cancelled`, with the picture so far.
fn cancelled(py: Python, rendered: Rendered) -> PyErr {
    let samples = rendered.samples;
    let picture = if samples > 0 { arrays::of_picture(py, rendered.picture).map(Some) } else { Ok(None) };
    picture.map_or_else(|error| error, |picture| exception(py, "Cancelled", (samples, picture)))
}
