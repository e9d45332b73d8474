//! Access to internals for tests of pictures. Not part of the public interface.

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{self, GpuJob, KernelSource, OFFLINE};
use crate::error::RenderError;
use crate::job::Renderer;
use crate::output::film::Film;
use crate::scene::RenderScene;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;

/// Input of the backends for one picture.
pub struct Picture(RenderInput);

impl Picture {
    /// Input of a scene and its settings.
    pub fn new(scene: &Scene, settings: &Settings) -> Self {
        Self(RenderInput::new(scene, settings))
    }

    /// Input that chooses lights by one table for all places.
    pub fn with_light_table(scene: &Scene, settings: &Settings) -> Self {
        let tables = RenderScene::choosing_lights(scene, settings.camera_of(scene), false);
        Self(RenderInput::with_tables(tables, scene, settings))
    }

    /// Turns off over-relaxation of sphere tracing.
    pub fn without_relaxation(mut self) -> Self {
        self.0.config.relaxation = 0.0;
        self
    }

    /// Makes the numbers of the field and the frame constants of the kernel.
    pub fn with_constant_numbers(mut self) -> Self {
        self.0.config.constant_numbers = true;
        self
    }

    /// Renders on the CPU.
    pub fn on_cpu(&self, samples: u32) -> Film {
        let mut job = CpuJob::new(self.0.clone(), 0);
        (0..samples).for_each(|_| job.advance(samples));
        job.film().clone()
    }

    /// Renders on a device.
    ///
    /// # Errors
    /// [`RenderError`] if the device refuses or fails.
    pub fn on_gpu(&self, device: &Device, samples: u32) -> Result<Film, RenderError> {
        let source = KernelSource::new(&self.0, &device.0);
        let mut job = GpuJob::of_source(device.0.clone(), &self.0, &source, 0, OFFLINE)?;
        while job.samples_done() < f64::from(samples) {
            job.advance(samples)?;
        }
        job.film()
    }
}

/// Opened GPU.
pub struct Device(Arc<gpu::GpuContext>);

impl Device {
    /// Opens the preferred adapter.
    ///
    /// # Errors
    /// [`RenderError`] if there is no usable adapter.
    pub fn open() -> Result<Self, RenderError> {
        Ok(Self(Arc::new(gpu::GpuContext::open(None)?)))
    }

    /// Opens the preferred adapter and treats it as another kind: "software" or "discrete GPU".
    ///
    /// # Errors
    /// [`RenderError`] if there is no usable adapter.
    pub fn open_as(kind: &'static str) -> Result<Self, RenderError> {
        let mut device = gpu::GpuContext::open(None)?;
        device.opened.description.kind = kind;
        Ok(Self(Arc::new(device)))
    }

    /// Opens the preferred adapter as software whose kernels read and write no textures.
    ///
    /// # Errors
    /// [`RenderError`] if there is no usable adapter.
    pub fn open_without_textures() -> Result<Self, RenderError> {
        let mut device = gpu::GpuContext::open(None)?;
        device.opened.description.kind = "software";
        device.opened.has_textures = false;
        Ok(Self(Arc::new(device)))
    }

    /// True if the adapter is software.
    pub fn is_software(&self) -> bool {
        self.0.is_software()
    }

    /// Reports whether the frame and the leaves of a picture are in uniform memory.
    pub fn has_uniform_frame_and_leaves(&self, picture: &Picture) -> [bool; 2] {
        let bindings = KernelSource::new(&picture.0, &self.0).bindings;
        [bindings.is_uniform(gpu::FRAME), bindings.is_uniform(gpu::LEAVES)]
    }

    /// Reports whether the light tree of a picture is in uniform memory.
    pub fn has_uniform_light_tree(&self, picture: &Picture) -> bool {
        KernelSource::new(&picture.0, &self.0).bindings.is_uniform(gpu::LIGHT_TREE)
    }
}

/// Renderer of [`Backend::Auto`](crate::Backend::Auto) that treats the preferred adapter as another kind, as
/// [`Device::open_as`] does.
///
/// # Errors
/// [`RenderError`] if there is no usable adapter.
pub fn auto_renderer_as(kind: &'static str) -> Result<Renderer, RenderError> {
    Ok(Renderer::choosing(Device::open_as(kind)?.0))
}
