//! Live picture of a scene that changes, for windows.
//!
//! **Idea.** A thread of its own renders the newest request and publishes pictures as they improve; the window never waits
//! for it. While the camera moves, the picture is as large as the frame time allows. Once nothing moves, it grows to its
//! full size and accumulates samples; with all samples done, the thread sleeps. Moving a camera and changing parameters
//! compile nothing. A scene of a new structure is compiled in the background. The CPU renders until the kernel is ready, and
//! wherever no GPU works or one is lost.
//!
//! Its threads have a low priority, so that windows still answer on a machine with few cores.
//!
//! **Cost.** A GPU receives submissions of about 10 ms, two in flight; a picture comes back as 4 bytes a pixel.

mod background;
mod engine;
mod gpu;
mod pace;
mod shared;

use crate::job::Backend;
use crate::output::film::Film;
use crate::settings::Settings;
use engine::Engine;
pub use shared::{LiveImage, RenderRequest, Status};
use shared::{Shared, lock};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;

/// Renderer on a thread of its own, which always renders the newest request.
pub struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    /// Number of requests so far.
    requests: u64,
}

impl Live {
    /// Starts the thread. [`Backend::Auto`] renders on a GPU, but never on a software adapter: the CPU backend is faster
    /// than that in most scenes and compiles nothing. `adapter` is part of a GPU's name. The thread calls `notify`
    /// whenever there is a new picture or status.
    pub fn new(backend: Backend, adapter: Option<String>, notify: impl Fn() + Send + Sync + 'static) -> Self {
        let shared = Arc::new(Shared::new(notify));
        let engine = Engine::new(shared.clone(), backend, adapter);
        let run = move || background::with_all_cores(|| engine.run());
        let thread = std::thread::Builder::new().name("live".to_owned()).spawn(run);
        // Without a thread there is no picture, but everything else works.
        let thread = thread.map_err(|error| lock(&shared.status).error = Some(error.to_string())).ok();
        Self { shared, thread, requests: 0 }
    }

    /// Requests a picture in place of the present one; returns the number of the request.
    pub fn show(&mut self, request: RenderRequest) -> u64 {
        self.requests += 1;
        lock(&self.shared.inbox).request = Some((self.requests, request));
        self.shared.wake();
        self.requests
    }

    /// Newest picture.
    pub fn picture(&self) -> Option<Arc<LiveImage>> {
        lock(&self.shared.picture).clone()
    }

    /// State of the renderer.
    pub fn status(&self) -> Status {
        lock(&self.shared.status).clone()
    }

    /// Asks for the film of the full-size picture and its settings. The film equals that of [`Renderer::render`] with as
    /// many samples on the same adapter. The reply comes soon; it is an error message while the picture is smaller.
    ///
    /// [`Renderer::render`]: crate::Renderer::render
    pub fn film(&self) -> Receiver<Result<(Film, Settings), String>> {
        let (sender, receiver) = channel();
        lock(&self.shared.inbox).films.push(sender);
        self.shared.wake();
        receiver
    }

    /// Destroys the GPU device, as a restart of the driver does; for tests of the recovery.
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
            // The status reports panics of the thread.
            let _ = thread.join();
        }
    }
}
