//! Data that the live renderer's thread shares with its owner.

use crate::output::film::Film;
use crate::output::tonemap::Display;
use crate::reconstruct::ReconstructOptions;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Request for a live picture.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// Scene; the same [`Arc`] as before counts as unchanged.
    pub scene: Arc<Scene>,
    /// Settings of the final picture, its full size among them.
    pub settings: Settings,
    /// Tone curve and exposure; see [`Mode::display`](crate::Mode::display).
    pub display: Display,
    /// True if the exposure is the one that suits the picture, instead of that of `display`. It follows slowly while something
    /// moves; at rest it is that of [`suitable_stops`](crate::exposure::suitable_stops).
    pub auto_exposure: bool,
    /// True while the user moves something: the next picture then matters more than its size.
    pub moving: bool,
    /// Time for each picture while something moves.
    pub frame_time: Duration,
    /// Reconstruction of clean pictures from few samples, see [`reconstruct`](crate::reconstruct). Applies to path-traced
    /// pictures. A picture at rest with all of its samples is not altered.
    pub reconstruct: Option<ReconstructOptions>,
}

/// Picture for the screen.
#[derive(Clone, Debug)]
pub struct LiveImage {
    /// Width and height, pixels; smaller than requested while something moves, or while a slow scene is refined.
    pub size: [u32; 2],
    /// sRGB codes: red, green, blue and 255 for each pixel, the top row first.
    pub codes: Vec<u8>,
    /// Exposure that it is shown with, stops.
    pub exposure_stops: f32,
    /// Samples of each pixel, with a fraction for one that is begun.
    pub samples: f64,
    /// Number of the request, as [`Live::show`](super::Live::show) returned it.
    pub request: u64,
    /// Number of this picture: the renderer counts its pictures from 1.
    pub serial: u64,
    /// Time at which it was ready.
    pub at: Instant,
}

/// State of a [`Live`](super::Live) renderer.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// Graphics API, "Vulkan", "Metal", …, or "CPU"; empty until the first request.
    pub backend: String,
    /// Name of the adapter, or number of threads.
    pub adapter: String,
    /// Samples of each pixel of the full-size picture, with a fraction; 0 while the picture is smaller.
    pub samples: f64,
    /// Estimated samples of the full-size picture each second.
    pub samples_per_second: f64,
    /// True while a kernel is being compiled.
    pub compiling: bool,
    /// True if the picture is finished: nothing is computed until the next request.
    pub resting: bool,
    /// Reason why this is not the backend that one would expect, in one sentence.
    pub notice: Option<String>,
    /// Reason why there is no picture.
    pub error: Option<String>,
}

/// Film and the settings it was rendered with, or the reason why there is none.
pub(super) type FilmReply = Result<(Film, Settings), String>;

/// Messages to the renderer's thread.
#[derive(Default)]
pub(super) struct Inbox {
    /// Newest request and its number.
    pub(super) request: Option<(u64, RenderRequest)>,
    /// Callers that wait for the film.
    pub(super) films: Vec<Sender<FilmReply>>,
    /// True if the GPU device must be destroyed.
    pub(super) lose_device: bool,
    /// True if the thread must end.
    pub(super) stop: bool,
    /// True if there may be messages or results.
    pub(super) woken: bool,
}

/// Messages, picture and status, shared by the renderer's thread and its owner.
pub(super) struct Shared {
    pub(super) inbox: Mutex<Inbox>,
    pub(super) wake: Condvar,
    pub(super) picture: Mutex<Option<Arc<LiveImage>>>,
    pub(super) status: Mutex<Status>,
    /// Callback for a new picture or status.
    pub(super) notify: Box<dyn Fn() + Send + Sync>,
}

impl Shared {
    pub(super) fn new(notify: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            inbox: Mutex::default(),
            wake: Condvar::new(),
            picture: Mutex::default(),
            status: Mutex::default(),
            notify: Box::new(notify),
        }
    }

    /// Wakes the renderer's thread.
    pub(super) fn wake(&self) {
        lock(&self.inbox).woken = true;
        self.wake.notify_one();
    }

    /// Reports why the backend is not the expected one.
    pub(super) fn set_notice(&self, notice: String) {
        lock(&self.status).notice = Some(notice);
        (self.notify)();
    }
}

/// Locks a mutex, also after a panic of another thread: every value is consistent at any time.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
