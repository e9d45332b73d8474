//! Choosing a backend, and rendering a scene with it.

use crate::cpu::CpuJob;
use crate::error::RenderError;
use crate::film::Film;
use crate::frame::Prepared;
use crate::gpu::{self, Device, GpuJob};
use crate::settings::{MAX_BOUNCES, MAX_SPLITTING, Settings};
use crate::tracer::Tracer;
use crate::transport::splitting;
use pathmarch_scene::Scene;
use std::sync::Arc;
use std::time::Duration;

/// Which kind of backend to render with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The GPU where one works, else the CPU; the renderer says which, and why.
    Auto,
    /// The GPU, or an error.
    Gpu,
    /// The CPU.
    Cpu,
}

/// A backend, ready to render scenes.
pub struct Renderer {
    gpu: Option<Arc<Device>>,
    may_fall_back: bool,
    notice: Option<String>,
}

impl Renderer {
    /// Opens a backend; `adapter` is part of the name of the GPU adapter to use.
    ///
    /// # Errors
    /// [`RenderError`] where a GPU is asked for and none can be opened, or none of this name.
    pub fn open(backend: Backend, adapter: Option<&str>) -> Result<Self, RenderError> {
        if backend == Backend::Cpu {
            return Ok(Self { gpu: None, may_fall_back: false, notice: None });
        }
        match Device::open(adapter) {
            Ok(device) => {
                Ok(Self { gpu: Some(Arc::new(device)), may_fall_back: backend == Backend::Auto, notice: None })
            }
            Err(error) if backend == Backend::Auto && adapter.is_none() => {
                let reason = match error {
                    RenderError::NoAdapter { reason } => format!("no usable GPU adapter: {reason}"),
                    other => other.to_string(),
                };
                Ok(Self { gpu: None, may_fall_back: false, notice: Some(reason) })
            }
            Err(error) => Err(error),
        }
    }

    /// Why this is not the backend one would expect, in one sentence.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// The name of the backend: "Vulkan", "Metal", …, or "CPU".
    pub fn backend_name(&self) -> String {
        self.gpu.as_ref().map_or_else(|| "CPU".to_owned(), |device| device.description.backend.clone())
    }

    /// The name of the adapter, or the number of cores.
    pub fn adapter_name(&self) -> String {
        self.gpu
            .as_ref()
            .map_or_else(|| format!("{} threads", rayon::current_num_threads()), |d| d.description.name.clone())
    }

    /// Begins a picture. With [`Backend::Auto`], a scene or size that the GPU cannot hold makes this a CPU renderer, as does one
    /// that is marched where the GPU is software; [`notice`](Self::notice) says so.
    ///
    /// # Errors
    /// [`RenderError`] where settings are out of range or the GPU refuses.
    pub fn start(&mut self, scene: &Scene, settings: &Settings) -> Result<Job, RenderError> {
        check(scene, settings)?;
        let mut prepared = Prepared::new(scene, settings);
        let marches_in_software = prepared.marches() && self.gpu.as_ref().is_some_and(|device| device.is_software());
        if marches_in_software && self.may_fall_back {
            self.notice =
                Some("the only GPU adapter is software, which marches slower than the CPU backend".to_owned());
            self.gpu = None;
        }
        // Paths that share a ray cannot be resumed where an adapter ends their loops, see gpu/loop_limit.rs.
        let limited = self.gpu.as_ref().is_some_and(|device| device.is_software()) && prepared.field.has_loops();
        if settings.splitting.is_none() && !limited {
            prepared.features.splitting = splitting::best(&prepared, settings.samples, self.gpu.is_some());
        }
        if let Some(device) = &self.gpu {
            match GpuJob::new(device.clone(), &prepared, settings.first_sample, gpu::WHOLE) {
                Ok(job) => return Ok(Job { tracer: Tracer::Gpu(Box::new(job)), settings: settings.clone() }),
                Err(error) if self.may_fall_back => {
                    self.notice = Some(error.to_string());
                    self.gpu = None;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(Job {
            tracer: Tracer::Cpu(Box::new(CpuJob::new(prepared, settings.first_sample))),
            settings: settings.clone(),
        })
    }

    /// Renders a whole picture.
    ///
    /// # Errors
    /// As [`start`](Self::start), and where the device fails on the way.
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Film, RenderError> {
        let mut job = self.start(scene, settings)?;
        while job.samples_done() < f64::from(settings.samples) {
            job.advance(settings.samples)?;
        }
        job.film()
    }
}

/// Refuses settings that are out of range.
pub(crate) fn check(scene: &Scene, settings: &Settings) -> Result<(), RenderError> {
    let fail = |message: String| Err(RenderError::Settings(message));
    let [width, height] = settings.size;
    let limit = crate::image::MAX_SIDE;
    if width == 0 || height == 0 || width > limit || height > limit {
        return fail(format!("a picture of {width}x{height} pixels: each side must be from 1 to {limit}"));
    }
    if settings.samples == 0 || settings.first_sample.checked_add(settings.samples).is_none() {
        return fail(format!(
            "{} samples from {}: there must be some, below 2³² in all",
            settings.samples, settings.first_sample
        ));
    }
    if !(settings.detail > 0.0 && settings.detail.is_finite()) {
        return fail(format!("a detail of {} pixels: it must be above 0", settings.detail));
    }
    if settings.bounces > MAX_BOUNCES {
        return fail(format!("{} bounces: at most {MAX_BOUNCES}", settings.bounces));
    }
    if settings.splitting.is_some_and(|paths| !(1..=MAX_SPLITTING).contains(&paths)) {
        return fail(format!("a splitting of {:?}: it must be from 1 to {MAX_SPLITTING}", settings.splitting));
    }
    if settings.viewpoint.is_none() && settings.camera >= scene.cameras.len() {
        return fail(format!("camera {} of {}", settings.camera, scene.cameras.len()));
    }
    Ok(())
}

/// A picture being rendered.
pub struct Job {
    tracer: Tracer,
    settings: Settings,
}

impl Job {
    /// Does a slice of the work: a few hundredths of a second on a GPU, one sample of every pixel on the CPU. Stops at
    /// `samples` samples, at most those asked for.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the GPU fails.
    pub fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        self.tracer.advance(samples.min(self.settings.samples))
    }

    /// Samples of every pixel that are done or on their way, with a fraction for one that is begun.
    pub fn samples_done(&self) -> f64 {
        self.tracer.samples_done()
    }

    /// The picture so far; finishes a sample that is begun.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the GPU fails.
    pub fn film(&mut self) -> Result<Film, RenderError> {
        self.tracer.film()
    }

    /// Waits for work that is on its way.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the GPU fails.
    pub fn wait(&mut self) -> Result<(), RenderError> {
        match &mut self.tracer {
            Tracer::Gpu(job) => job.wait(),
            Tracer::Cpu(_) => Ok(()),
        }
    }

    /// How long the GPU took to compile the scene; zero on the CPU.
    pub fn compile_time(&self) -> Duration {
        match &self.tracer {
            Tracer::Gpu(job) => job.compile_time,
            Tracer::Cpu(_) => Duration::ZERO,
        }
    }

    /// From now on measures how long the work takes on the GPU's own clock, see [`gpu_time`](Self::gpu_time). False where
    /// there is none: on the CPU, and on adapters without timestamps.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the GPU fails.
    pub fn measure_gpu_time(&mut self) -> Result<bool, RenderError> {
        match &mut self.tracer {
            Tracer::Gpu(job) => job.measure_gpu_time(),
            Tracer::Cpu(_) => Ok(false),
        }
    }

    /// How long the GPU worked since it is measured; none where it is not. Waits for work that is on its way.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the GPU fails.
    pub fn gpu_time(&mut self) -> Result<Option<Duration>, RenderError> {
        match &mut self.tracer {
            Tracer::Gpu(job) => job.gpu_time(),
            Tracer::Cpu(_) => Ok(None),
        }
    }
}
