//! Choosing a backend, and rendering a scene with it.

pub(crate) mod motion;
pub(crate) mod tracer;

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{self, GpuContext, GpuJob};
use crate::error::RenderError;
use crate::output::film::Film;
use crate::ray_stats::{RayCounters, RayStats};
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;
use std::time::Duration;
use tracer::Tracer;

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
    gpu: Option<Arc<GpuContext>>,
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
        match GpuContext::open(adapter) {
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
        settings.check(scene)?;
        let mut input = RenderInput::new(scene, settings);
        let marches_in_software =
            input.scene.is_sphere_traced() && self.gpu.as_ref().is_some_and(|device| device.is_software());
        if marches_in_software && self.may_fall_back {
            self.notice =
                Some("the only GPU adapter is software, which marches slower than the CPU backend".to_owned());
            self.gpu = None;
        }
        // Paths that share a ray cannot be resumed where an adapter ends their loops, see gpu/loop_limit.rs.
        let limited = self.gpu.as_ref().is_some_and(|device| device.is_software()) && input.scene.field.has_loops();
        if settings.splitting.is_none() && !limited {
            input.choose_splitting(settings.samples, self.gpu.is_some());
        }
        if let Some(device) = &self.gpu {
            match GpuJob::new(device.clone(), &input, settings.first_sample, gpu::WHOLE) {
                Ok(job) => return Ok(Job { tracer: Tracer::Gpu(Box::new(job)), settings: settings.clone() }),
                Err(error) if self.may_fall_back => {
                    self.notice = Some(error.to_string());
                    self.gpu = None;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(Job { tracer: Tracer::Cpu(Box::new(CpuJob::new(input, settings.first_sample))), settings: settings.clone() })
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

/// Counts the rays and field evaluations of one sample of every pixel, on the CPU.
///
/// # Errors
/// [`RenderError::Settings`] where settings are out of range.
pub fn ray_stats(scene: &Scene, settings: &Settings) -> Result<RayStats, RenderError> {
    settings.check(scene)?;
    let counters = Arc::new(RayCounters::default());
    CpuJob::new(RenderInput::new(scene, settings), settings.first_sample).with_stats(counters.clone()).advance(1);
    Ok(counters.total())
}
