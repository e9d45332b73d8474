//! Arguments of `render`, and the task that they stand for.

use super::task::Task;
use crate::failure::Failure;
use crate::names;
use crate::scene::Moving;
use crate::settings::{apply, whole};
use pathmarch_render::aov::Layer;
use pathmarch_render::denoise::Denoiser;
use pathmarch_render::pathmarch_scene::{RenderSettings, Scene};
use pathmarch_render::{Backend, Mode, Settings, Shutter};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

/// Names of the backends.
const BACKENDS: [(&str, Backend); 3] = [("auto", Backend::Auto), ("cpu", Backend::Cpu), ("gpu", Backend::Gpu)];
/// Name of all layers together.
const ALL: &str = "all";

/// Arguments of `render` as Python gives them.
pub struct Options<'py> {
    pub size: Option<Bound<'py, PyAny>>,
    pub samples: Option<Bound<'py, PyAny>>,
    pub seed: Option<Bound<'py, PyAny>>,
    pub backend: String,
    pub camera: Option<String>,
    pub time: Option<f64>,
    pub layers: Option<Bound<'py, PyAny>>,
    pub denoise: Option<String>,
    pub mode: String,
    pub adapter: Option<String>,
    /// Further render settings by name.
    pub settings: Option<Bound<'py, PyDict>>,
}

impl Options<'_> {
    /// The picture that they ask for.
    ///
    /// # Errors
    /// `TypeError` and `ValueError` for values that a picture cannot have.
    pub fn task(&self, scene: &Moving, render: &RenderSettings) -> PyResult<Task> {
        let mode = names::find("mode", &self.mode, Mode::ALL.map(|mode| (mode.name(), mode)))?;
        let mut settings = Settings { mode, camera: self.camera(&scene.scene)?, seed: self.seed()?, ..render.into() };
        if self.samples.is_none() {
            settings.samples = mode.samples(settings.samples);
        }
        settings.check(&scene.scene).map_err(Failure::from)?;
        Ok(Task {
            animation: scene.animation.clone(),
            scene: scene.scene.clone(),
            shutter: Shutter::open_for(&scene.scene, render.shutter, render.fps),
            backend: names::find("backend", &self.backend, BACKENDS)?,
            adapter: self.adapter.clone(),
            layers: self.layers()?,
            denoiser: self.denoiser(mode)?,
            settings,
        })
    }

    /// Settings of a scene with those of the arguments.
    ///
    /// # Errors
    /// `TypeError` and `ValueError` for settings that do not exist, or cannot have these values.
    pub fn render_settings(&self, py: Python, render: &RenderSettings) -> PyResult<RenderSettings> {
        let given = match &self.settings {
            Some(settings) => settings.copy()?,
            None => PyDict::new(py),
        };
        for (name, value) in [("size", &self.size), ("samples", &self.samples)] {
            value.as_ref().map_or(Ok(()), |value| given.set_item(name, value))?;
        }
        let mut render = render.clone();
        apply(&mut render, &given)?;
        Ok(render)
    }

    fn camera(&self, scene: &Scene) -> PyResult<usize> {
        let Some(asked) = &self.camera else { return Ok(0) };
        let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
        let found = names.iter().position(|name| name == asked);
        found.ok_or_else(|| names::unknown("camera", asked, &names))
    }

    fn seed(&self) -> PyResult<u32> {
        self.seed.as_ref().map_or(Ok(0), |seed| whole("seed", seed, (0, u32::MAX)))
    }

    fn layers(&self) -> PyResult<Vec<Layer>> {
        let Some(layers) = &self.layers else { return Ok(Vec::new()) };
        let names: Vec<String> = match layers.cast::<PyString>() {
            Ok(name) => vec![name.extract()?],
            Err(_) => layers.extract()?,
        };
        if names == [ALL] {
            return Ok(Layer::ALL.to_vec());
        }
        let all = Layer::ALL.map(|layer| (layer.name(), layer));
        names.iter().map(|name| names::find("layers", name, all)).collect()
    }

    fn denoiser(&self, mode: Mode) -> PyResult<Option<Denoiser>> {
        let Some(name) = &self.denoise else { return Ok(None) };
        if mode != Mode::Path {
            let message =
                format!("denoise: only pictures of mode \"path\" can be denoised, not of \"{}\"", mode.name());
            return Err(PyValueError::new_err(message));
        }
        let denoiser = names::find("denoise", name, Denoiser::ALL.map(|denoiser| (denoiser.name(), denoiser)))?;
        denoiser.check().map_err(|error| Failure::Render(error.to_string()))?;
        Ok(Some(denoiser))
    }
}
