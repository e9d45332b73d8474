//! What tests of pictures need of the inside. No part of the public interface.

use crate::cpu::CpuJob;
use crate::error::RenderError;
use crate::film::Film;
use crate::frame;
use crate::gpu::{self, GpuJob, Printed, WHOLE};
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;

/// A scene as renderers read it.
pub struct Prepared(frame::Prepared);

impl Prepared {
    /// A scene with its settings.
    pub fn new(scene: &Scene, settings: &Settings) -> Self {
        Self(frame::Prepared::new(scene, settings))
    }

    /// The same, sphere-traced without over-relaxation.
    pub fn without_relaxation(mut self) -> Self {
        self.0.features.relaxation = 0.0;
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
    /// [`RenderError`] where the device refuses or fails.
    pub fn on_gpu(&self, device: &Device, samples: u32) -> Result<Film, RenderError> {
        let printed = Printed::new(&self.0, &device.0);
        let mut job = GpuJob::of_printed(device.0.clone(), &self.0, &printed, 0, WHOLE)?;
        while job.samples_done() < f64::from(samples) {
            job.advance(samples)?;
        }
        job.film()
    }
}

/// An opened GPU.
pub struct Device(Arc<gpu::Device>);

impl Device {
    /// Opens the preferred adapter.
    ///
    /// # Errors
    /// [`RenderError`] where there is none.
    pub fn open() -> Result<Self, RenderError> {
        Ok(Self(Arc::new(gpu::Device::open(None)?)))
    }

    /// Opens it and takes it for another kind of adapter: "software" or "discrete GPU".
    ///
    /// # Errors
    /// [`RenderError`] where there is none.
    pub fn open_as(kind: &'static str) -> Result<Self, RenderError> {
        let mut device = gpu::Device::open(None)?;
        device.description.kind = kind;
        Ok(Self(Arc::new(device)))
    }

    /// Whether it runs on the processor.
    pub fn is_software(&self) -> bool {
        self.0.is_software()
    }

    /// Whether a scene's frame and its table of leaves are in uniform memory.
    pub fn has_uniform_frame_and_leaves(&self, prepared: &Prepared) -> [bool; 2] {
        let memory = Printed::new(&prepared.0, &self.0).memory;
        [memory.is_uniform(gpu::FRAME), memory.is_uniform(gpu::LEAVES)]
    }
}
