//! Jobs: pictures being rendered, still or with motion blur, each on the backend that suits it.

mod adaptive;
mod backend_choice;
mod identity;
mod motion;
mod record;
mod tiles;
pub(crate) mod tracer;
#[cfg(target_family = "wasm")]
mod web_gpu;

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{self, GpuContext, GpuJob, KernelSource, KernelTarget};
use crate::error::RenderError;
use crate::output::exposure::suitable_stops;
use crate::output::film::Film;
use crate::ray_stats::{RayCounters, RayStats};
use crate::settings::Settings;
pub use adaptive::{AdaptiveJob, AdaptiveTile, MAX_NOISE, MIN_NOISE};
use backend_choice::Choice;
use motion::MotionBlur;
pub use motion::Shutter;
use pathmarch_scene::{Animation, Scene};
use std::sync::{Arc, Mutex};
use std::time::Duration;
pub use tiles::TileTracer;
use tracer::Tracer;
#[cfg(target_family = "wasm")]
pub use web_gpu::{WebGpu, WebGpuJob};

/// Kind of backend to render with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The GPU if it can render the picture, else the CPU. If the adapter is software, the faster of both, by measurement.
    Auto,
    /// The GPU; an error if it cannot render the picture.
    Gpu,
    /// The CPU.
    Cpu,
}

/// Backend and adapter of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BackendInfo {
    /// Graphics API, "Vulkan", "Metal", …, or "CPU".
    pub name: String,
    /// Name of the adapter, or number of threads.
    pub adapter: String,
    /// Reason why this is not the backend that one would expect, in one sentence.
    pub notice: Option<String>,
}

impl BackendInfo {
    fn cpu(notice: Option<String>) -> Self {
        Self { name: "CPU".to_owned(), adapter: format!("{} threads", rayon::current_num_threads()), notice }
    }

    fn gpu(gpu: &GpuContext) -> Self {
        let description = &gpu.description;
        Self { name: description.backend.clone(), adapter: description.name.clone(), notice: None }
    }
}

/// Opened backends, ready to render scenes. Clones share them.
#[derive(Clone)]
pub struct Renderer {
    gpu: Option<Arc<GpuContext>>,
    may_fall_back: bool,
    /// Whether a software adapter is compared with the CPU before it is used.
    measures: bool,
    /// Reason why no GPU is open although one was requested.
    notice: Option<String>,
}

impl Renderer {
    /// Opens a backend; `adapter` is part of the name of the GPU adapter to use.
    ///
    /// # Errors
    /// [`RenderError`] if a GPU is requested and none can be opened, or none of this name.
    pub fn open(backend: Backend, adapter: Option<&str>) -> Result<Self, RenderError> {
        if backend == Backend::Cpu {
            return Ok(Self::on_cpu(None));
        }
        match GpuContext::open(adapter) {
            Ok(gpu) if backend == Backend::Auto => Ok(Self::choosing(Arc::new(gpu))),
            Ok(gpu) => Ok(Self { gpu: Some(Arc::new(gpu)), may_fall_back: false, measures: false, notice: None }),
            Err(error) if backend == Backend::Auto && adapter.is_none() => {
                let reason = match error {
                    RenderError::NoAdapter { reason } => format!("no usable GPU adapter: {reason}"),
                    other => other.to_string(),
                };
                Ok(Self::on_cpu(Some(reason)))
            }
            Err(error) => Err(error),
        }
    }

    fn on_cpu(notice: Option<String>) -> Self {
        Self { gpu: None, may_fall_back: false, measures: false, notice }
    }

    /// Renderer that chooses between this device and the CPU.
    pub(crate) fn choosing(gpu: Arc<GpuContext>) -> Self {
        Self { measures: gpu.is_software(), gpu: Some(gpu), may_fall_back: true, notice: None }
    }

    /// Opened backend. With [`Backend::Auto`], a job may still use the CPU, see [`Job::backend`].
    pub fn backend(&self) -> BackendInfo {
        match &self.gpu {
            Some(gpu) => BackendInfo::gpu(gpu),
            None => BackendInfo::cpu(self.notice.clone()),
        }
    }

    /// Starts a picture of one moment. With [`Backend::Auto`], the CPU renders a scene or size that the GPU refuses.
    ///
    /// # Errors
    /// [`RenderError`] if settings are out of range or the GPU refuses.
    pub fn start(&self, scene: &Scene, settings: &Settings) -> Result<Job, RenderError> {
        let (tracer, backend) = self.trace(scene, settings)?;
        Ok(Job { work: Work::Still(tracer), settings: settings.clone(), backend, taken: 0 })
    }

    /// Starts a picture with motion blur over the time that the shutter is open. `scene` is the animation at the moment at which
    /// it opens. Scenes without motion and modes other than [`Mode::Path`](crate::Mode::Path) show that moment alone.
    ///
    /// # Errors
    /// Those of [`start`](Self::start).
    pub fn start_motion_blur(
        &self,
        animation: &Arc<Mutex<Animation>>,
        scene: &Scene,
        settings: &Settings,
        shutter: Shutter,
    ) -> Result<Job, RenderError> {
        if !shutter.blurs(scene, settings) {
            return self.start(scene, settings);
        }
        settings.check(scene)?;
        // One choice for the whole picture, not one for each of its moments.
        let renderer = self.settled(scene, settings);
        let backend = renderer.backend();
        let motion = MotionBlur::new(renderer, animation.clone(), settings, shutter);
        Ok(Job { work: Work::Moving(Box::new(motion)), settings: settings.clone(), backend, taken: 0 })
    }

    /// Renders a whole picture.
    ///
    /// # Errors
    /// Those of [`start`](Self::start), and [`RenderError::Device`] if the device fails while rendering.
    pub fn render(&self, scene: &Scene, settings: &Settings) -> Result<Film, RenderError> {
        let mut job = self.start(scene, settings)?;
        job.run(|_| false, |_| {})?;
        job.film()
    }

    /// Exposure in stops that suits a picture, from a small one of few samples; 0 of a black one. Frames of an animation share
    /// one, so that they do not flicker.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn meter(&self, scene: &Scene, settings: &Settings) -> Result<f32, RenderError> {
        /// Width in pixels, and samples of the small picture.
        const METER: (u32, u32) = (96, 32);
        let [width, height] = settings.size.map(u64::from);
        let rows = (u64::from(METER.0) * height).div_ceil(width.max(1)).clamp(1, u64::from(settings.size[1])) as u32;
        let settings = Settings {
            size: [METER.0.min(settings.size[0]), rows],
            samples: METER.1,
            first_sample: 0,
            whole_samples: None,
            crop: None,
            ..settings.clone()
        };
        Ok(suitable_stops(&self.render(scene, &settings)?).unwrap_or(0.0))
    }

    /// The same renderer, with its choice between a software adapter and the CPU made for a picture.
    fn settled(&self, scene: &Scene, settings: &Settings) -> Self {
        if self.measures { self.with_input(scene, settings).0 } else { self.clone() }
    }

    /// Backend that suits a picture, with its input.
    fn with_input(&self, scene: &Scene, settings: &Settings) -> (Self, RenderInput) {
        let mut input = RenderInput::new(scene, settings);
        match &self.gpu {
            Some(gpu) if self.measures => {
                let (choice, input) = backend_choice::measure(scene, settings, &input, gpu);
                let renderer = match choice {
                    Choice::Gpu => Self { measures: false, ..self.clone() },
                    Choice::Cpu { reason } => Self::on_cpu(Some(reason)),
                };
                return (renderer, input);
            }
            Some(gpu) => input.choose_for_gpu(settings, gpu.is_software()),
            None => input.choose_for_cpu(settings),
        }
        (self.clone(), input)
    }

    /// Tracer of a picture, on the backend that suits it.
    fn trace(&self, scene: &Scene, settings: &Settings) -> Result<(Tracer, BackendInfo), RenderError> {
        settings.check(scene)?;
        let (Self { gpu, may_fall_back, notice, .. }, input) = self.with_input(scene, settings);
        let Some(gpu) = gpu else {
            return Ok((on_cpu(input, settings), BackendInfo::cpu(notice)));
        };
        match GpuJob::new(gpu.clone(), &input, settings.first_sample, gpu::OFFLINE) {
            Ok(job) => Ok((Tracer::Gpu(Box::new(job.cropped(settings.rect()))), BackendInfo::gpu(&gpu))),
            Err(error) if may_fall_back => {
                let (_, input) = Self::on_cpu(None).with_input(scene, settings);
                Ok((on_cpu(input, settings), BackendInfo::cpu(Some(error.to_string()))))
            }
            Err(error) => Err(error),
        }
    }
}

/// Tracer of a picture on the CPU.
fn on_cpu(input: RenderInput, settings: &Settings) -> Tracer {
    Tracer::Cpu(Box::new(CpuJob::new(input, settings.first_sample).cropped(settings.rect())))
}

impl Renderer {
    /// Tracer of an input that records guides, on the opened device if there is one.
    pub(crate) fn trace_with_guides(&self, input: &RenderInput, first_sample: u32) -> Result<Tracer, RenderError> {
        Ok(match &self.gpu {
            Some(gpu) => Tracer::Gpu(Box::new(GpuJob::new(gpu.clone(), input, first_sample, gpu::OFFLINE)?)),
            None => Tracer::Cpu(Box::new(CpuJob::new(input.clone(), first_sample))),
        })
    }
}

/// Picture being rendered.
pub struct Job {
    work: Work,
    settings: Settings,
    backend: BackendInfo,
    /// Number of samples in films that were taken.
    taken: u32,
}

enum Work {
    Still(Tracer),
    Moving(Box<MotionBlur>),
}

impl Job {
    /// Backend that renders it. With motion blur, the backend may change with the scene; this is the latest.
    pub fn backend(&self) -> &BackendInfo {
        match &self.work {
            Work::Still(_) => &self.backend,
            Work::Moving(motion) => motion.backend().unwrap_or(&self.backend),
        }
    }

    /// Renders a slice of the work: a few hundredths of a second on a GPU, one sample of every pixel on the CPU. Stops at
    /// `samples` samples, or at those of the settings.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails, and [`RenderError::Scene`] if the animation is not a valid scene at the moment
    /// of a sample.
    pub fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        match &mut self.work {
            Work::Still(tracer) => tracer.advance(samples.min(self.settings.samples).saturating_sub(self.taken)),
            Work::Moving(motion) => motion.advance(samples.min(self.settings.samples).saturating_sub(self.taken)),
        }
    }

    /// Renders until the picture has all its samples or `stop` returns true; calls `progress` after each slice. Both receive
    /// the number of samples that are done.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn run(&mut self, stop: impl Fn(f64) -> bool, mut progress: impl FnMut(f64)) -> Result<(), RenderError> {
        while self.samples_done() < f64::from(self.settings.samples) && !stop(self.samples_done()) {
            self.advance(self.settings.samples)?;
            progress(self.samples_done());
        }
        Ok(())
    }

    /// Samples of every pixel that are done or submitted, with a fraction for one that is begun.
    pub fn samples_done(&self) -> f64 {
        let done = match &self.work {
            Work::Still(tracer) => tracer.samples_done(),
            Work::Moving(motion) => motion.samples_done(),
        };
        f64::from(self.taken) + done
    }

    /// Film so far, without what [`record`](Self::record) has taken; finishes samples that are begun.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn film(&mut self) -> Result<Film, RenderError> {
        match &mut self.work {
            Work::Still(tracer) => tracer.film(),
            Work::Moving(motion) => motion.film(),
        }
    }

    /// Settings of the picture.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    fn gpu_job(&mut self) -> Option<&mut GpuJob> {
        match &mut self.work {
            Work::Still(Tracer::Gpu(job)) => Some(job),
            _ => None,
        }
    }

    /// Waits for submitted work.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn wait(&mut self) -> Result<(), RenderError> {
        self.gpu_job().map_or(Ok(()), GpuJob::wait)
    }

    /// Time that the GPU took to compile the scene; zero on the CPU.
    pub fn compile_time(&self) -> Duration {
        match &self.work {
            Work::Still(Tracer::Gpu(job)) => job.compile_time,
            _ => Duration::ZERO,
        }
    }

    /// Starts to measure the time of the work on the GPU's own clock, see [`gpu_time`](Self::gpu_time). Returns false on the CPU
    /// and on adapters without timestamps.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn measure_gpu_time(&mut self) -> Result<bool, RenderError> {
        self.gpu_job().map_or(Ok(false), GpuJob::measure_gpu_time)
    }

    /// GPU time since the measurement started; `None` without measurement. Waits for submitted work.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub fn gpu_time(&mut self) -> Result<Option<Duration>, RenderError> {
        self.gpu_job().map_or(Ok(None), GpuJob::gpu_time)
    }
}

/// Source of a picture's kernel in WGSL: for a software adapter if `software` is true, else for a GPU.
///
/// # Errors
/// [`RenderError::Settings`] if settings are out of range.
pub fn kernel_wgsl(scene: &Scene, settings: &Settings, software: bool) -> Result<String, RenderError> {
    settings.check(scene)?;
    Ok(KernelSource::for_target(&RenderInput::new(scene, settings), KernelTarget::new(software)).code)
}

/// Counts the rays and field evaluations of one sample of every pixel, on the CPU.
///
/// # Errors
/// [`RenderError::Settings`] if settings are out of range.
pub fn ray_stats(scene: &Scene, settings: &Settings) -> Result<RayStats, RenderError> {
    settings.check(scene)?;
    let counters = Arc::new(RayCounters::default());
    CpuJob::new(RenderInput::new(scene, settings), settings.first_sample).with_stats(counters.clone()).advance(1);
    Ok(counters.total())
}
