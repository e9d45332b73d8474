//! Long work on a thread of its own, which Ctrl-C and callbacks of Python can end.
//!
//! **Idea.** The work never holds the interpreter's lock, so that other threads of Python go on. The calling thread
//! waits for messages of the work, calls back, and looks for signals a few times a second. When it leaves with an
//! exception, the work ends at its next slice, for which it waits a second at most.

use crate::exceptions::internal;
use crate::fork;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Time between two looks for signals.
const PATIENCE: Duration = Duration::from_millis(50);
/// Longest wait for the end of work that was interrupted.
const GRACE: Duration = Duration::from_secs(1);
/// Stack of the work, bytes: that of a main thread.
const STACK: usize = 8 << 20;

enum Message<T> {
    Progress(f64),
    Done(T),
}

/// Connection of the work to the thread that waits for it.
pub struct Watcher<T> {
    sender: Sender<Message<T>>,
    stopped: Arc<AtomicBool>,
}

impl<T> Watcher<T> {
    /// True if the work should end.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }
    /// Reports the progress, in the unit of the work.
    pub fn report(&self, progress: f64) {
        // If nobody waits any more, the work is stopped, too.
        let _ = self.sender.send(Message::Progress(progress));
    }
}

/// Callback of Python that receives the progress and a total; the work goes on unless it returns `False`.
pub struct Callback {
    /// The callable, if there is one.
    pub function: Option<Py<PyAny>>,
    /// Last argument.
    pub total: f64,
}

impl Callback {
    /// Calls back; returns false if the work is to end.
    fn call(&self, py: Python, progress: f64) -> PyResult<bool> {
        let Some(function) = &self.function else { return Ok(true) };
        let answer = function.call1(py, (progress.min(self.total), self.total))?;
        // Any answer but a truth value goes on, so that `print` is a callback.
        Ok(answer.extract(py).unwrap_or(true))
    }
}

/// Runs `work` and returns its result. After `False` of the callback the work is told to end, and its result is
/// awaited.
///
/// # Errors
/// Exceptions of the callback, `KeyboardInterrupt`, and `RuntimeError` if no thread can be started.
pub fn run<T: Send + 'static>(
    py: Python,
    callback: &Callback,
    work: impl FnOnce(&Watcher<T>) -> T + Send + 'static,
) -> PyResult<T> {
    fork::check()?;
    let (sender, receiver) = channel();
    let stopped = Arc::new(AtomicBool::new(false));
    let watcher = Watcher { sender, stopped: stopped.clone() };
    let thread = thread::Builder::new().name("pathmarch".to_owned()).stack_size(STACK);
    let started = thread.spawn(move || {
        let result = work(&watcher);
        let _ = watcher.sender.send(Message::Done(result));
    });
    let thread = started.map_err(|error| PyRuntimeError::new_err(format!("no thread can be started: {error}")))?;
    let result = wait(py, callback, receiver, &stopped);
    stopped.store(true, Ordering::SeqCst);
    py.detach(|| end(&thread));
    result
}

/// Gives the work some time to end, so that it does not go on while the interpreter exits.
fn end(thread: &JoinHandle<()>) {
    let started = Instant::now();
    while !thread.is_finished() && started.elapsed() < GRACE {
        thread::sleep(Duration::from_millis(1));
    }
}

fn wait<T: Send>(
    py: Python,
    callback: &Callback,
    mut receiver: Receiver<Message<T>>,
    stopped: &AtomicBool,
) -> PyResult<T> {
    loop {
        let (news, same) = py.detach(move || (News::of(&receiver), receiver));
        receiver = same;
        py.check_signals()?;
        if let Some(progress) = news.progress.filter(|_| !stopped.load(Ordering::SeqCst)) {
            stopped.store(!callback.call(py, progress)?, Ordering::SeqCst);
        }
        match news.result {
            Some(result) => return Ok(result),
            None if news.ended => return Err(internal("a thread ended without a result")),
            None => {}
        }
    }
}

/// Messages of the work since the last look.
struct News<T> {
    /// The latest progress: a slow callback leaves others out.
    progress: Option<f64>,
    result: Option<T>,
    /// True if there will be no more messages.
    ended: bool,
}

impl<T> News<T> {
    fn of(receiver: &Receiver<Message<T>>) -> Self {
        let mut news = Self { progress: None, result: None, ended: false };
        let mut next = receiver.recv_timeout(PATIENCE);
        while let Ok(message) = next {
            match message {
                Message::Progress(progress) => news.progress = Some(progress),
                Message::Done(result) => news.result = Some(result),
            }
            next = receiver.recv_timeout(Duration::ZERO);
        }
        news.ended = matches!(next, Err(RecvTimeoutError::Disconnected));
        news
    }
}
