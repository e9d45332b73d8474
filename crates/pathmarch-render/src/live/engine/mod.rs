//! Thread of a [`Live`](super::Live) renderer: it handles messages, renders slices of work and recovers from failures.

mod publish;
mod request;

use super::gpu::LiveGpu;
use super::pace::Pace;
use super::shared::{Inbox, LiveImage, RenderRequest, Shared, Status, lock};
use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::job::Backend;
use crate::job::tracer::Tracer;
use crate::reconstruct::Reconstruction;
use pathmarch_scene::Scene;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// Time for which the CPU renders before it checks the inbox.
const CPU_SLICE: Duration = Duration::from_millis(12);
/// Longest time between two pictures of an accumulating film.
const PUBLISH_INTERVAL: Duration = Duration::from_millis(150);
/// Least time between two reconstructed pictures of an accumulating film, in times of a reconstruction.
const MIN_PUBLISH_RATIO: u32 = 6;
/// Samples of a picture below full size: enough to see something while the user pauses.
const LEVEL_SAMPLES: u32 = 64;
/// Longest time for which a new request waits for the first picture of the one before.
const FIRST_IMAGE_WAIT: Duration = Duration::from_millis(120);
/// Time after which a level without a first picture counts as too large.
const LEVEL_TIMEOUT: Duration = Duration::from_millis(300);

/// State of the renderer's thread.
pub(super) struct Engine {
    shared: Arc<Shared>,
    gpu: LiveGpu,
    /// Request being rendered, and its number.
    request: Option<(u64, RenderRequest)>,
    /// Request that follows the first picture of the present one.
    next: Option<(u64, RenderRequest)>,
    input: Option<RenderInput>,
    tracer: Option<Tracer>,
    /// Scene for which it is known whether pixels at rest share light, and the answer.
    path_reuse: Option<(Arc<Scene>, bool)>,
    /// First sample of the picture being rendered.
    first_sample: u32,
    /// Next sample of reconstructed pictures in motion: those of successive pictures complement each other.
    next_moving_sample: u32,
    /// Size of the picture being rendered, pixels.
    level: [u32; 2],
    gpu_pace: Pace,
    cpu_pace: Pace,
    /// Pace of pictures at rest whose pixels share light; others do not get smaller by it.
    sharing_pace: Pace,
    reconstruction: Reconstruction,
    /// True if the scene has changed since the last film was started.
    scene_changed: bool,
    /// Duration of the last reconstruction.
    reconstruction_time: Duration,
    /// Samples and time at the last measurement of the pace.
    last_measurement: (f64, Instant),
    published_at: Option<Instant>,
    /// Samples of the last published picture.
    published_samples: f64,
    /// Last automatic exposure, stops.
    metered_stops: Option<f32>,
    /// Samples of the film of the last automatic exposure; 0 for that of another film.
    metered_samples: f64,
    /// Start of the present request's first picture; `None` once it is published.
    first_image_since: Option<Instant>,
    /// Number of requests in a row that were replaced before their first picture.
    skipped_requests: u32,
    /// Number of published pictures.
    serial: u64,
}

impl Engine {
    pub(super) fn new(shared: Arc<Shared>, backend: Backend, adapter: Option<String>) -> Self {
        Self {
            shared,
            gpu: LiveGpu::new(backend, adapter),
            request: None,
            next: None,
            input: None,
            tracer: None,
            path_reuse: None,
            first_sample: 0,
            next_moving_sample: 0,
            level: [0; 2],
            gpu_pace: Pace::default(),
            cpu_pace: Pace::default(),
            sharing_pace: Pace::default(),
            reconstruction: Reconstruction::default(),
            scene_changed: false,
            reconstruction_time: Duration::ZERO,
            last_measurement: (0.0, Instant::now()),
            published_at: None,
            published_samples: 0.0,
            metered_stops: None,
            metered_samples: 0.0,
            first_image_since: None,
            skipped_requests: 0,
            serial: 0,
        }
    }

    /// Renders until the owner stops the thread.
    pub(super) fn run(mut self) {
        loop {
            let inbox = self.take_inbox();
            if inbox.stop {
                return;
            }
            let done = catch_unwind(AssertUnwindSafe(|| self.step(inbox)));
            match done {
                Ok(Ok(())) => {}
                Ok(Err(error)) => self.recover(&error),
                Err(panic) => {
                    let message = panic.downcast_ref::<String>().cloned();
                    let message = message.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
                    let reason = format!("the renderer failed: {}", message.unwrap_or_default());
                    let adapter = lock(&self.shared.status).adapter.clone();
                    self.recover(&RenderError::Device { adapter, reason });
                }
            }
        }
    }

    /// Takes the messages; waits for one while there is no work.
    fn take_inbox(&mut self) -> Inbox {
        let mut inbox = lock(&self.shared.inbox);
        while !inbox.woken && !self.has_work() {
            inbox = match self.reopens_at() {
                Some(at) => {
                    let left = at.saturating_duration_since(Instant::now());
                    let woken = self.shared.wake.wait_timeout(inbox, left);
                    let (inbox, _) = woken.unwrap_or_else(PoisonError::into_inner);
                    if Instant::now() >= at {
                        drop(inbox);
                        return std::mem::take(&mut *lock(&self.shared.inbox));
                    }
                    inbox
                }
                None => self.shared.wake.wait(inbox).unwrap_or_else(PoisonError::into_inner),
            };
        }
        std::mem::take(&mut inbox)
    }

    /// Time at which a lost GPU is to be opened again.
    fn reopens_at(&self) -> Option<Instant> {
        self.request.as_ref().and_then(|_| self.gpu.reopens_at())
    }

    /// Number of samples at which the present level is done.
    fn target(&self, request: &RenderRequest) -> u32 {
        if self.level == request.settings.size { request.settings.samples } else { LEVEL_SAMPLES }
    }

    fn has_work(&self) -> bool {
        if self.next.is_some() {
            return true;
        }
        let (Some((_, request)), Some(tracer)) = (&self.request, &self.tracer) else { return false };
        let target = self.target(request);
        let done = tracer.samples_done();
        // Reading the film back may have completed the last sample.
        let unpublished = done >= f64::from(target) && done > self.published_samples;
        done < f64::from(target) || unpublished || !request.moving && self.level != request.settings.size
    }

    /// True while the first picture of a request is worth waiting for: some are then published although requests come
    /// faster than pictures.
    fn waits_for_first_image(&self) -> bool {
        // The wait doubles with every request that was replaced before its first picture.
        let wait = FIRST_IMAGE_WAIT * (1 << self.skipped_requests.min(4));
        self.tracer.is_some() && self.first_image_since.is_some_and(|start| start.elapsed() < wait)
    }

    /// Handles the messages, then results of compilations, then renders a slice.
    fn step(&mut self, inbox: Inbox) -> Result<(), RenderError> {
        if inbox.lose_device
            && let Some(device) = self.gpu.device()
        {
            device.device.destroy();
        }
        self.next = inbox.request.or(self.next.take());
        if (!self.waits_for_first_image() || !inbox.films.is_empty())
            && let Some((number, request)) = self.next.take()
        {
            self.start_request(number, request)?;
        }
        self.poll_kernel()?;
        if self.reopens_at().is_some_and(|at| Instant::now() >= at) {
            self.compile();
        }
        for sender in inbox.films {
            let film = self.film();
            // The receiver may be gone.
            let _ = sender.send(film);
        }
        if self.has_work() {
            self.render_slice()?;
        }
        self.update_status();
        Ok(())
    }

    /// Pace of the backend in use.
    fn pace(&self) -> &Pace {
        if matches!(self.tracer, Some(Tracer::Gpu(_))) { &self.gpu_pace } else { &self.cpu_pace }
    }

    /// True if the pixels of the picture share light.
    fn shares_light(&self) -> bool {
        self.input.as_ref().is_some_and(|input| input.config.path_reuse)
    }

    /// Renders a slice, and publishes a picture if it is time for one.
    fn render_slice(&mut self) -> Result<(), RenderError> {
        let Some((_, request)) = self.request.clone() else { return Ok(()) };
        let is_full_size = self.level == request.settings.size;
        let target = self.target(&request);
        let Some(tracer) = &mut self.tracer else { return Ok(()) };
        if tracer.samples_done() < f64::from(target) {
            // The first picture has one sample, so that it comes soon.
            let upto = if tracer.samples_done() < 1.0 { 1 } else { target };
            tracer.advance_for(CPU_SLICE, upto)?;
        }
        let done = tracer.samples_done();
        if done < 1.0 {
            self.measure_pace(done);
        }
        if done >= 1.0 {
            (self.first_image_since, self.skipped_requests) = (None, 0);
        } else if self.first_image_since.is_some_and(|start| start.elapsed() > LEVEL_TIMEOUT) && done > 0.0 {
            // Slower than estimated: chooses a smaller level from the measured pace.
            self.first_image_since = None;
            self.update_pace(done);
            let smaller = self.pace().size_within(request.settings.size, LEVEL_TIMEOUT / 3);
            if smaller[0] < self.level[0] {
                self.level = smaller;
                return self.start_level();
            }
        }
        if self.is_due(done, target) {
            self.publish()?;
        }
        // After the picture is published, so that the time of its reconstruction counts.
        if done >= 1.0 {
            self.measure_pace(done);
        }
        if !request.moving && done >= 1.0 {
            if !is_full_size {
                self.level = self.pace().next_level(self.level, request.settings.size);
                return self.start_level();
            }
            if self.choose_path_reuse(&request) {
                return self.start_level();
            }
        }
        Ok(())
    }

    /// Updates the pace once enough was rendered since the last measurement.
    fn measure_pace(&mut self, done: f64) {
        let (before, since) = self.last_measurement;
        // Submissions on a GPU may still be in flight: only several of them make a measurement.
        let took = since.elapsed();
        if done - before >= 1.0 || took > Duration::from_millis(100) && done > before {
            self.update_pace(done);
        }
    }

    /// Updates the pace from the samples since the last measurement.
    fn update_pace(&mut self, done: f64) {
        let (before, since) = self.last_measurement;
        if done > before {
            let took = since.elapsed();
            let pixels = (done - before) * f64::from(self.level[0]) * f64::from(self.level[1]);
            let shares = self.shares_light();
            let pace = match &self.tracer {
                Some(Tracer::Gpu(_)) => &mut self.gpu_pace,
                _ if shares => &mut self.sharing_pace,
                _ => &mut self.cpu_pace,
            };
            pace.learn(pixels, took);
            self.last_measurement = (done, Instant::now());
        }
    }

    /// Continues on the CPU after a failure of the GPU; stops after a failure of the CPU.
    fn recover(&mut self, error: &RenderError) {
        if self.gpu.device().is_some() || self.gpu.is_compiling() {
            match error {
                RenderError::LoopLimit { .. } => self.gpu.refuse(error, &self.shared),
                _ => self.gpu.lose(error, &self.shared),
            }
            self.tracer = None;
            if let Err(error) = self.start_level() {
                self.fail(error.to_string());
            }
        } else {
            self.fail(error.to_string());
        }
    }

    /// Drops the picture and reports why there is none.
    fn fail(&mut self, reason: String) {
        self.tracer = None;
        self.input = None;
        lock(&self.shared.status).error = Some(reason);
        self.update_status();
        (self.shared.notify)();
    }
}
