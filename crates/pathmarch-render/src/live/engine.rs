//! The thread of a [`Live`](super::Live): what to compute next.

use super::background::give_way;
use super::pace::Pace;
use super::{Inbox, LiveImage, RenderRequest, Shared, Status, lock};
use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{self, GpuContext, GpuJob, KernelSource};
use crate::error::RenderError;
use crate::job::Backend;
use crate::job::tracer::Tracer;
use crate::mode::Mode;
use crate::output::film::Film;
use crate::output::tonemap::Display;
use crate::settings::Settings;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

/// How long the CPU works before it looks for orders.
const CPU_SLICE: Duration = Duration::from_millis(12);
/// A picture that accumulates is shown anew this often, at least.
const SHOW_EVERY: Duration = Duration::from_millis(150);
/// Samples of a picture that is not of its whole size: enough to see something while the hand rests.
const LEVEL_SAMPLES: u32 = 64;
/// A kernel that is compiled within this time needs no other picture meanwhile.
const COMPILED_AT_ONCE: Duration = Duration::from_millis(30);
/// A new order waits this long at most for the first picture of the one before.
const WAITED_FOR: Duration = Duration::from_millis(120);
/// A first picture that is not there after this time was chosen too large.
const TOO_LONG: Duration = Duration::from_millis(300);
/// Times that a GPU that was lost is opened again, and how long after.
const REOPENINGS: u32 = 3;
const REOPEN_AFTER: Duration = Duration::from_secs(1);

/// What a live picture asks of a tracer besides.
impl Tracer {
    /// Does a little work towards `samples` samples, so that orders are looked for soon.
    fn advance_a_little(&mut self, samples: u32) -> Result<(), RenderError> {
        match self {
            Self::Gpu(job) => job.advance(samples),
            Self::Cpu(job) => {
                job.advance_for(CPU_SLICE);
                Ok(())
            }
        }
    }
    fn show(&mut self, display: &Display, mode: Mode) -> Result<Vec<u8>, RenderError> {
        match self {
            Self::Gpu(job) => job.show(display, mode),
            Self::Cpu(job) => Ok(job.show(display, mode)),
        }
    }
    /// Starts again, where it can; false otherwise.
    fn reframe(&mut self, input: &RenderInput) -> Result<bool, RenderError> {
        match self {
            Self::Gpu(job) => job.reframe(&input.frame),
            Self::Cpu(job) => {
                job.reframe(input);
                Ok(true)
            }
        }
    }
}

/// What became of the GPU.
enum Gpu {
    /// Not asked for, or given up.
    None,
    /// To be opened with the first kernel, not before then.
    Closed {
        from: Instant,
    },
    Open(Arc<GpuContext>),
}

/// What a thread that compiles sends: the device, where it could be opened, and whether the kernel is among its own.
struct Compiled {
    device: Option<Arc<GpuContext>>,
    result: Result<(), RenderError>,
}

pub(super) struct Engine {
    shared: Arc<Shared>,
    backend: Backend,
    adapter: Option<String>,
    gpu: Gpu,
    reopenings: u32,
    order: Option<(u64, RenderRequest)>,
    /// What comes after the first picture of the present order.
    next: Option<(u64, RenderRequest)>,
    input: Option<RenderInput>,
    /// The kernel's text for the input scene.
    source: Option<KernelSource>,
    compiling: Option<Receiver<Compiled>>,
    tracer: Option<Tracer>,
    /// The GPU refused this scene.
    refused: bool,
    /// Size of the picture being rendered.
    level: [u32; 2],
    gpu_pace: Pace,
    cpu_pace: Pace,
    /// When the tracer started on this picture, what it had done when last looked at, and when that was.
    measured: (f64, Instant),
    shown: Option<Instant>,
    /// When the first picture of the present order was begun; none once it is there.
    awaited: Option<Instant>,
    /// Orders in a row whose first picture was not waited for to the end.
    given_up: u32,
    /// Samples of the picture shown last.
    shown_samples: f64,
    serial: u64,
}

/// What comes of this, or that a driver failed in a way it should not.
fn caught<T>(work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        Err(RenderError::Device { adapter: "the GPU".to_owned(), reason: "its driver failed".to_owned() })
    })
}

/// Whether both want the same of the estimator, and only the view, the size or a limit changes.
fn same_kernel(a: &Settings, b: &Settings) -> bool {
    let rest = |settings: &Settings| Settings {
        size: [1, 1],
        samples: 1,
        bounces: 0,
        seed: 0,
        clamp: None,
        detail: 1.0,
        camera: 0,
        viewpoint: None,
        ..settings.clone()
    };
    rest(a) == rest(b)
}

/// Whether the picture of `b` is that of `a` with more or fewer samples.
fn same_picture(a: &Settings, b: &Settings) -> bool {
    Settings { samples: 1, ..a.clone() } == Settings { samples: 1, ..b.clone() }
}

impl Engine {
    pub(super) fn new(shared: Arc<Shared>, backend: Backend, adapter: Option<String>) -> Self {
        let now = Instant::now();
        Self {
            shared,
            backend,
            adapter,
            gpu: if backend == Backend::Cpu { Gpu::None } else { Gpu::Closed { from: now } },
            reopenings: 0,
            order: None,
            next: None,
            input: None,
            source: None,
            compiling: None,
            tracer: None,
            refused: false,
            level: [0; 2],
            gpu_pace: Pace::default(),
            cpu_pace: Pace::default(),
            measured: (0.0, now),
            shown: None,
            awaited: None,
            given_up: 0,
            shown_samples: 0.0,
            serial: 0,
        }
    }

    pub(super) fn run(mut self) {
        loop {
            let inbox = self.take_inbox();
            if inbox.stop {
                return;
            }
            let done = catch_unwind(AssertUnwindSafe(|| self.turn(inbox)));
            match done {
                Ok(Ok(())) => {}
                Ok(Err(error)) => self.failed(&error),
                Err(panic) => {
                    let words = panic.downcast_ref::<String>().cloned();
                    let words = words.or_else(|| panic.downcast_ref::<&str>().map(|&words| words.to_owned()));
                    let reason = format!("the renderer failed: {}", words.unwrap_or_default());
                    let adapter = lock(&self.shared.status).adapter.clone();
                    self.failed(&RenderError::Device { adapter, reason });
                }
            }
        }
    }

    /// Messages; waits for one while there is nothing to do.
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

    /// When a GPU that was lost is to be opened again.
    fn reopens_at(&self) -> Option<Instant> {
        match self.gpu {
            Gpu::Closed { from } if self.order.is_some() && self.compiling.is_none() && !self.refused => Some(from),
            _ => None,
        }
    }

    /// Samples that the picture of the present level is to have.
    fn target(&self, order: &RenderRequest) -> u32 {
        if self.level == order.settings.size { order.settings.samples } else { LEVEL_SAMPLES }
    }

    fn has_work(&self) -> bool {
        if self.next.is_some() {
            return true;
        }
        let (Some((_, order)), Some(tracer)) = (&self.order, &self.tracer) else { return false };
        let target = self.target(order);
        let done = tracer.samples_done();
        // Whoever asked for a film may have had the last sample done.
        let not_shown = done >= f64::from(target) && done > self.shown_samples;
        done < f64::from(target) || not_shown || !order.moving && self.level != order.settings.size
    }

    /// Whether the first picture of an order is on its way. It is waited for a little while, so that orders that come faster
    /// than pictures still show some.
    fn is_about_to_show(&self) -> bool {
        // The more orders went by without a picture, the longer.
        let patience = WAITED_FOR * (1 << self.given_up.min(4));
        self.tracer.is_some() && self.awaited.is_some_and(|begun| begun.elapsed() < patience)
    }

    /// One round: orders, then what the background has finished, then a little work.
    fn turn(&mut self, inbox: Inbox) -> Result<(), RenderError> {
        if inbox.lose_device
            && let Gpu::Open(device) = &self.gpu
        {
            device.device.destroy();
        }
        self.next = inbox.order.or(self.next.take());
        if (!self.is_about_to_show() || !inbox.films.is_empty())
            && let Some((number, order)) = self.next.take()
        {
            self.follow(number, order)?;
        }
        self.receive_kernel()?;
        if self.reopens_at().is_some_and(|at| Instant::now() >= at) {
            self.compile();
        }
        for sender in inbox.films {
            let film = self.film();
            // Who asked may be gone.
            let _ = sender.send(film);
        }
        if self.has_work() {
            self.work()?;
        }
        self.report();
        Ok(())
    }

    /// Takes an order on.
    fn follow(&mut self, number: u64, order: RenderRequest) -> Result<(), RenderError> {
        if let Err(error) = order.settings.check(&order.scene) {
            self.order = Some((number, order));
            self.give_up(error.to_string());
            return Ok(());
        }
        lock(&self.shared.status).error = None;
        let old = self.order.replace((number, order.clone()));
        let old = old.map(|(_, old)| old).filter(|_| self.input.is_some() && self.tracer.is_some());
        let (same_scene, same_picture) = old.as_ref().map_or((false, false), |old| {
            let scene = Arc::ptr_eq(&old.scene, &order.scene) && same_kernel(&old.settings, &order.settings);
            (scene, scene && same_picture(&old.settings, &order.settings))
        });
        if same_picture {
            // More samples, another look, or the end of a movement.
            if old.is_some_and(|old| old.display != order.display) && self.shown.is_some() {
                self.publish()?;
            }
            return Ok(());
        }
        if self.awaited.is_some()
            && let Some(tracer) = &self.tracer
        {
            // It took too long: what was done of it tells how large the next one can be.
            let done = tracer.samples_done();
            self.learn(done);
            self.given_up += 1;
        }
        self.level = self.first_level(&order);
        self.awaited = Some(Instant::now());
        let settings = self.level_settings(&order);
        let reframed = same_scene && self.input.as_mut().is_some_and(|input| input.reframe(&order.scene, &settings));
        if reframed {
            return self.restart();
        }
        self.input = Some(RenderInput::new(&order.scene, &settings));
        self.source = None;
        self.refused = false;
        self.compile();
        if let Some(compiling) = &self.compiling {
            // Mostly it is ready at once, and the picture need not be made twice.
            if let Ok(compiled) = compiling.recv_timeout(COMPILED_AT_ONCE) {
                self.compiling = None;
                self.take_kernel(compiled);
            }
        }
        self.tracer = None;
        self.restart()
    }

    /// The size to begin with.
    fn first_level(&self, order: &RenderRequest) -> [u32; 2] {
        let time = if order.moving { order.frame_time } else { order.frame_time.max(Duration::from_millis(60)) };
        let level = self.pace().size_within(order.settings.size, time);
        if order.moving {
            level
        } else {
            self.pace().next_level(level.map(|side| side.div_ceil(2)), order.settings.size)
        }
    }

    fn level_settings(&self, order: &RenderRequest) -> Settings {
        Settings { size: self.level, ..order.settings.clone() }
    }

    fn pace(&self) -> &Pace {
        if matches!(self.tracer, Some(Tracer::Gpu(_))) { &self.gpu_pace } else { &self.cpu_pace }
    }

    /// Sees to it that the kernel of the input scene is ready or on its way.
    fn compile(&mut self) {
        if self.compiling.is_some() || self.refused {
            return;
        }
        let Some(input) = &self.input else { return };
        let device = match &self.gpu {
            Gpu::None => return,
            Gpu::Open(device) => Some(device.clone()),
            Gpu::Closed { from } if *from > Instant::now() => return,
            Gpu::Closed { .. } => None,
        };
        if let Some(device) = &device {
            let source = KernelSource::new(input, device);
            let ready = source.is_compiled(device);
            self.source = Some(source);
            if ready {
                return;
            }
        }
        // A picture of one workgroup is enough to have it compiled.
        let mut sample = input.clone();
        (sample.frame.width, sample.frame.height) = (8, 8);
        let (adapter, software) = (self.adapter.clone(), self.takes_software());
        let (sender, receiver) = channel();
        let shared = self.shared.clone();
        let work = move || {
            give_way();
            let opened = match device {
                Some(device) => Ok(device),
                None => caught(|| GpuContext::open(adapter.as_deref()).map(Arc::new)),
            };
            let compiled = match opened {
                Err(error) => Compiled { device: None, result: Err(error) },
                Ok(device) if device.is_software() && !software => Compiled { device: Some(device), result: Ok(()) },
                Ok(device) => {
                    let result = caught(|| GpuJob::new(device.clone(), &sample, 0, gpu::LIVE).map(drop));
                    Compiled { device: Some(device), result }
                }
            };
            // The renderer may be gone.
            let _ = sender.send(compiled);
            shared.wake();
        };
        match std::thread::Builder::new().name("compile".to_owned()).spawn(work) {
            Ok(_) => self.compiling = Some(receiver),
            Err(error) => self.notice(error.to_string()),
        }
    }

    /// Takes a kernel that is ready, if there is one.
    fn receive_kernel(&mut self) -> Result<(), RenderError> {
        let Some(compiled) = self.compiling.as_ref().and_then(|compiling| compiling.try_recv().ok()) else {
            return Ok(());
        };
        self.compiling = None;
        let was_cpu = !matches!(self.tracer, Some(Tracer::Gpu(_)));
        self.take_kernel(compiled);
        // The scene may have changed meanwhile.
        self.compile();
        if was_cpu && self.ready_kernel().is_some() {
            self.tracer = None;
            let Some((_, order)) = self.order.clone() else { return Ok(()) };
            self.level = self.first_level(&order);
            return self.restart();
        }
        Ok(())
    }

    fn take_kernel(&mut self, Compiled { device, result }: Compiled) {
        if let Some(device) = device {
            let wanted = self.takes_software() || !device.is_software();
            self.gpu = if wanted { Gpu::Open(device) } else { Gpu::None };
        }
        match result {
            Ok(()) => {}
            Err(error) if matches!(self.gpu, Gpu::Open(_)) && !self.device_is_lost() => {
                // This scene is what it does not want.
                self.refused = true;
                self.notice(format!("{error}: rendering on the CPU"));
            }
            Err(error) => self.lose(&error),
        }
    }

    /// Whether a GPU that is software was asked for.
    fn takes_software(&self) -> bool {
        self.backend == Backend::Gpu || self.adapter.is_some()
    }

    fn device_is_lost(&self) -> bool {
        match &self.gpu {
            Gpu::Open(device) => device.check().is_err(),
            _ => false,
        }
    }

    /// The device and the kernel of the input scene, where it is ready.
    fn ready_kernel(&self) -> Option<(&Arc<GpuContext>, &KernelSource)> {
        match (&self.gpu, &self.source) {
            (Gpu::Open(device), Some(source)) if !self.refused && source.is_compiled(device) => Some((device, source)),
            _ => None,
        }
    }

    /// Begins the picture of the present level.
    fn restart(&mut self) -> Result<(), RenderError> {
        let Some((_, order)) = &self.order else { return Ok(()) };
        let settings = self.level_settings(order);
        let Some(input) = &mut self.input else { return Ok(()) };
        if [input.frame.width, input.frame.height] != self.level && !input.reframe(&order.scene, &settings) {
            *input = RenderInput::new(&order.scene, &settings);
            self.tracer = None;
        }
        let kept = match &mut self.tracer {
            Some(tracer) => tracer.reframe(input)?,
            None => false,
        };
        if !kept && let Some(input) = &self.input {
            let first = settings.first_sample;
            let cpu = || Tracer::Cpu(Box::new(CpuJob::new(input.clone(), first)));
            let tracer = match self.gpu_tracer(input, first) {
                Some(Err(error @ RenderError::TooLarge { .. })) => {
                    self.notice(format!("{error}: rendering on the CPU"));
                    self.refused = true;
                    cpu()
                }
                Some(tracer) => tracer?,
                None => cpu(),
            };
            self.tracer = Some(tracer);
        }
        self.measured = (0.0, Instant::now());
        self.shown_samples = 0.0;
        Ok(())
    }

    /// A tracer on the GPU, where the kernel is ready and the scene fits.
    fn gpu_tracer(&self, input: &RenderInput, first_sample: u32) -> Option<Result<Tracer, RenderError>> {
        let (device, source) = self.ready_kernel()?;
        let job = GpuJob::of_source(device.clone(), input, source, first_sample, gpu::LIVE);
        Some(job.map(|job| Tracer::Gpu(Box::new(job))))
    }

    /// A little work, and a picture if it is time for one.
    fn work(&mut self) -> Result<(), RenderError> {
        let Some((_, order)) = self.order.clone() else { return Ok(()) };
        let whole = self.level == order.settings.size;
        let target = self.target(&order);
        let Some(tracer) = &mut self.tracer else { return Ok(()) };
        if tracer.samples_done() < f64::from(target) {
            // What is shown first is one sample, as soon as can be.
            let upto = if tracer.samples_done() < 1.0 { 1 } else { target };
            tracer.advance_a_little(upto)?;
        }
        let done = tracer.samples_done();
        self.measure(done);
        if done >= 1.0 {
            (self.awaited, self.given_up) = (None, 0);
        } else if self.awaited.is_some_and(|begun| begun.elapsed() > TOO_LONG) && done > 0.0 {
            // Slower than thought: what was learnt tells which size is ready soon.
            self.awaited = None;
            self.learn(done);
            let smaller = self.pace().size_within(order.settings.size, TOO_LONG / 3);
            if smaller[0] < self.level[0] {
                self.level = smaller;
                return self.restart();
            }
        }
        let first = self.shown_samples < 1.0 && done >= 1.0;
        let better =
            done >= 1.0 && self.shown.is_none_or(|shown| shown.elapsed() >= SHOW_EVERY) && done > self.shown_samples;
        let last = done >= f64::from(target) && done > self.shown_samples;
        if first || better || last {
            self.publish()?;
        }
        if !order.moving && !whole && done >= 1.0 {
            self.level = self.pace().next_level(self.level, order.settings.size);
            self.restart()?;
        }
        Ok(())
    }

    /// Learns from what was done since the last time.
    fn measure(&mut self, done: f64) {
        let (before, since) = self.measured;
        // A piece of a GPU's work is only on its way: some of them tell the pace.
        let took = since.elapsed();
        if done - before >= 1.0 || took > Duration::from_millis(100) && done > before {
            self.learn(done);
        }
    }

    fn learn(&mut self, done: f64) {
        let (before, since) = self.measured;
        if done > before {
            let took = since.elapsed();
            let pixels = (done - before) * f64::from(self.level[0]) * f64::from(self.level[1]);
            let pace = match &self.tracer {
                Some(Tracer::Gpu(_)) => &mut self.gpu_pace,
                _ => &mut self.cpu_pace,
            };
            pace.learn(pixels, took);
            self.measured = (done, Instant::now());
        }
    }

    fn publish(&mut self) -> Result<(), RenderError> {
        let (Some((number, order)), Some(tracer)) = (&self.order, &mut self.tracer) else { return Ok(()) };
        let samples = tracer.samples_done();
        let codes = tracer.show(&order.display, order.settings.mode)?;
        let now = Instant::now();
        self.serial += 1;
        let shown = LiveImage { size: self.level, codes, samples, request: *number, serial: self.serial, at: now };
        *lock(&self.shared.picture) = Some(Arc::new(shown));
        self.shown = Some(now);
        self.shown_samples = samples;
        self.report();
        (self.shared.notify)();
        Ok(())
    }

    /// The film of the whole picture, and what it was rendered with.
    fn film(&mut self) -> Result<(Film, Settings), String> {
        let Some((_, order)) = self.order.clone() else { return Err("nothing is shown yet".to_owned()) };
        let Some(tracer) = &mut self.tracer else { return Err("nothing is shown yet".to_owned()) };
        if self.level != order.settings.size {
            return Err("the picture does not have its whole size yet".to_owned());
        }
        let film = tracer.film().map_err(|error| error.to_string())?;
        if film.samples == 0 {
            return Err("no sample of the picture is done yet".to_owned());
        }
        let settings = Settings { samples: film.samples, ..order.settings };
        Ok((film, settings))
    }

    /// Goes on without the GPU, and perhaps with it again later.
    fn failed(&mut self, error: &RenderError) {
        if matches!(self.gpu, Gpu::Open(_)) || self.compiling.is_some() {
            self.lose(error);
            self.tracer = None;
            if let Err(error) = self.restart() {
                self.give_up(error.to_string());
            }
        } else {
            self.give_up(error.to_string());
        }
    }

    fn lose(&mut self, error: &RenderError) {
        let again = self.reopenings < REOPENINGS && !matches!(error, RenderError::NoSuchAdapter { .. });
        self.reopenings += 1;
        self.gpu = match (again, error) {
            (true, RenderError::Device { .. }) => Gpu::Closed { from: Instant::now() + REOPEN_AFTER },
            _ => Gpu::None,
        };
        self.compiling = None;
        self.source = None;
        self.notice(format!("{error}: rendering on the CPU"));
    }

    fn notice(&self, words: String) {
        lock(&self.shared.status).notice = Some(words);
        (self.shared.notify)();
    }

    /// No picture, and why.
    fn give_up(&mut self, why: String) {
        self.tracer = None;
        self.input = None;
        lock(&self.shared.status).error = Some(why);
        self.report();
        (self.shared.notify)();
    }

    /// Says what it is doing.
    fn report(&self) {
        let mut status = lock(&self.shared.status);
        let whole = self.order.as_ref().map(|(_, order)| order.settings.size);
        let Status { backend, adapter, samples, samples_per_second, compiling, resting, notice, .. } = &mut *status;
        match (&self.tracer, &self.gpu) {
            (Some(Tracer::Gpu(_)), Gpu::Open(device)) => {
                backend.clone_from(&device.description.backend);
                adapter.clone_from(&device.description.name);
                *notice = None;
            }
            (Some(_), _) => {
                "CPU".clone_into(backend);
                *adapter = format!("{} threads", rayon::current_num_threads());
            }
            (None, _) => {}
        }
        *samples = match &self.tracer {
            Some(tracer) if whole == Some(self.level) => tracer.samples_done(),
            _ => 0.0,
        };
        *samples_per_second = whole.map_or(0.0, |whole| 1.0 / self.pace().seconds(whole));
        *compiling = self.compiling.is_some();
        let was_resting = std::mem::replace(resting, self.tracer.is_some() && !self.has_work());
        let changed = was_resting != *resting;
        drop(status);
        if changed {
            (self.shared.notify)();
        }
    }
}
