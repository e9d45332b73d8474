//! A picture that follows its scene: for windows.
//!
//! **Idea.** A thread of its own renders what it was last told to show, and hands out pictures as they get better. Whoever
//! draws the window never waits for it. While the camera moves the picture is as large as fits the time of a frame; when
//! everything rests it grows to its whole size and accumulates, and once all samples are there nothing is computed any more.
//! Moving a camera and changing numbers compile nothing. A scene of a new structure is compiled in the background; until
//! it is ready, and where no GPU works or one is lost, the CPU renders.
//!
//! Its threads give way to others, so that on a machine with few cores windows still answer.
//!
//! **Costs.** A GPU gets about 10 ms of work at a time, two pieces of it ahead; a picture comes back as 4 bytes a pixel.

mod background;
mod engine;
mod pace;

use crate::job::Backend;
use crate::output::film::Film;
use crate::output::tonemap::Display;
use crate::settings::Settings;
use engine::Engine;
use pathmarch_scene::Scene;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What to show.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// The scene; one that is the same [`Arc`] is taken as unchanged.
    pub scene: Arc<Scene>,
    /// Size of the whole picture, when it is done, and everything else about it.
    pub settings: Settings,
    /// How the picture is shown; see [`Mode::display`](crate::Mode::display).
    pub display: Display,
    /// Whether something is being moved, so that the next picture matters more than its size.
    pub moving: bool,
    /// How long a picture may take while something moves.
    pub frame_time: Duration,
}

/// A picture for the screen.
#[derive(Clone, Debug)]
pub struct LiveImage {
    /// Width and height, pixels; smaller than ordered while something moves or a slow scene sharpens.
    pub size: [u32; 2],
    /// sRGB codes: red, green, blue and 255 for each pixel, the top row first.
    pub codes: Vec<u8>,
    /// Samples of each pixel, with a fraction for one that is begun.
    pub samples: f64,
    /// Which order it shows, as [`Live::show`] numbered it.
    pub request: u64,
    /// Which picture of this renderer it is.
    pub serial: u64,
    /// When it was ready.
    pub at: Instant,
}

/// What a [`Live`] is doing.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// "Vulkan", "Metal", …, or "CPU"; empty until the first order.
    pub backend: String,
    /// The adapter's name, or the number of threads.
    pub adapter: String,
    /// Samples of each pixel of the picture of the whole size, with a fraction; 0 while it is smaller.
    pub samples: f64,
    /// Samples of the whole size each second, as far as known.
    pub samples_per_second: f64,
    /// A kernel is being compiled.
    pub compiling: bool,
    /// Everything is done; nothing is computed until the next order.
    pub resting: bool,
    /// Why this is not the backend one would expect, in one sentence.
    pub notice: Option<String>,
    /// Why there is no picture.
    pub error: Option<String>,
}

/// Messages to the thread.
#[derive(Default)]
struct Inbox {
    order: Option<(u64, RenderRequest)>,
    films: Vec<Sender<Result<(Film, Settings), String>>>,
    /// The device is to be lost.
    lose_device: bool,
    stop: bool,
    /// There may be something new, whatever it is.
    woken: bool,
}

struct Shared {
    inbox: Mutex<Inbox>,
    wake: Condvar,
    picture: Mutex<Option<Arc<LiveImage>>>,
    status: Mutex<Status>,
    /// Called when there is a new picture or status.
    notify: Box<dyn Fn() + Send + Sync>,
}

/// The contents of a lock, also after a panic of another thread: every value is whole at any time.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn wake(&self) {
        lock(&self.inbox).woken = true;
        self.wake.notify_one();
    }
}

/// A renderer on a thread of its own, which follows orders.
pub struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    orders: u64,
}

impl Live {
    /// Starts the thread. With [`Backend::Auto`] it renders on a GPU, but not on one that is software: the CPU backend is
    /// faster than that in most scenes and compiles nothing. `adapter` is part of a GPU's name. `notify` is called,
    /// on that thread, whenever there is a new picture or status.
    pub fn new(backend: Backend, adapter: Option<String>, notify: impl Fn() + Send + Sync + 'static) -> Self {
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            wake: Condvar::new(),
            picture: Mutex::default(),
            status: Mutex::default(),
            notify: Box::new(notify),
        });
        let engine = Engine::new(shared.clone(), backend, adapter);
        let run = move || background::with_all_cores(|| engine.run());
        let thread = std::thread::Builder::new().name("live".to_owned()).spawn(run);
        // Without a thread there is no picture; everything else goes on.
        let thread = thread.map_err(|error| lock(&shared.status).error = Some(error.to_string())).ok();
        Self { shared, thread, orders: 0 }
    }

    /// From now on shows this; returns the number of the order.
    pub fn show(&mut self, order: RenderRequest) -> u64 {
        self.orders += 1;
        lock(&self.shared.inbox).order = Some((self.orders, order));
        self.shared.wake();
        self.orders
    }

    /// The newest picture.
    pub fn picture(&self) -> Option<Arc<LiveImage>> {
        lock(&self.shared.picture).clone()
    }

    /// What it is doing.
    pub fn status(&self) -> Status {
        lock(&self.shared.status).clone()
    }

    /// Asks for the film of the picture of the whole size, with what it was rendered with: what [`Renderer::render`]
    /// gives for as many samples on the same adapter. The answer comes soon; it is an error in words while the picture is
    /// not of its whole size yet.
    ///
    /// [`Renderer::render`]: crate::Renderer::render
    pub fn film(&self) -> Receiver<Result<(Film, Settings), String>> {
        let (sender, receiver) = channel();
        lock(&self.shared.inbox).films.push(sender);
        self.shared.wake();
        receiver
    }

    /// Loses the GPU, as happens when a driver is restarted: to try what comes then.
    pub fn lose_device(&self) {
        lock(&self.shared.inbox).lose_device = true;
        self.shared.wake();
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        lock(&self.shared.inbox).stop = true;
        self.shared.wake();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been reported as its status.
            let _ = thread.join();
        }
    }
}
