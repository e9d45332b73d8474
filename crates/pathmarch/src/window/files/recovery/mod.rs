//! Crash recovery of unsaved work.
//!
//! **Idea.** Each window stores its unsaved text in a file of its own, and locks a second file beside it while it runs.
//! The system releases the lock however the program ends. A later window takes files without a locked partner as
//! abandoned work.
//!
//! **Cost.** A sleeping thread; it writes at most once a second, and only if the text has changed.

mod abandoned;
mod format;

pub use abandoned::find_abandoned_work;
use abandoned::{KEPT, LOCK, remove, remove_stale_locks};
pub use format::RecoveredWork;
use format::{UnsavedWork, write};
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Minimum time between two writes.
const PAUSE: Duration = Duration::from_secs(1);

/// Recovery file of one window. Dropping it writes pending work and keeps the file.
pub struct Recovery {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    /// Work that was last passed to [`Self::keep`].
    kept: Option<UnsavedWork>,
    lock: Option<(File, PathBuf)>,
    file: PathBuf,
}

#[derive(Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    changed: Condvar,
}

#[derive(Default)]
struct Inbox {
    task: Option<DiskTask>,
    /// The thread is writing.
    busy: bool,
    /// Write without delay.
    hurry: bool,
    stop: bool,
    problem: Option<String>,
}

/// Task of the thread.
enum DiskTask {
    Write(UnsavedWork, SystemTime),
    Remove,
}

impl Shared {
    /// Locks the inbox, even after a panic of the other thread: every value is complete at any time.
    fn inbox(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Recovery {
    /// Creates a recovery file in a directory, which is created if necessary. If that fails, nothing is stored, and
    /// [`problem`](Self::problem) returns the reason.
    pub fn new(directory: &Path) -> Self {
        let shared = Arc::<Shared>::default();
        let mut this = Self { shared, thread: None, kept: None, lock: None, file: PathBuf::new() };
        if let Err(error) = this.start(directory) {
            this.shared.inbox().problem =
                Some(format!("crash recovery is not available: {}: {error}", directory.display()));
        }
        this
    }

    fn start(&mut self, directory: &Path) -> io::Result<()> {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true);
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(directory)?;
        remove_stale_locks(directory);
        let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        for attempt in 0..100 {
            let name = format!("{time}-{}-{attempt}", std::process::id());
            let lock_path = directory.join(format!("{name}.{LOCK}"));
            let lock = match OpenOptions::new().write(true).create_new(true).open(&lock_path) {
                Ok(lock) => lock,
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            // On a file system without locks, other windows take this work for abandoned; nothing is lost.
            let _ = lock.try_lock();
            self.lock = Some((lock, lock_path));
            self.file = directory.join(format!("{name}.{KEPT}"));
            let (shared, file) = (self.shared.clone(), self.file.clone());
            self.thread =
                Some(std::thread::Builder::new().name("recovery".to_owned()).spawn(move || work(&shared, &file))?);
            return Ok(());
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Reason why work is not stored, in one sentence.
    pub fn problem(&self) -> Option<String> {
        self.shared.inbox().problem.clone()
    }

    /// Path of the recovery file; the file exists only while there is unsaved work.
    #[cfg(test)]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Stores the text of a scene unless it equals `disk_text`, the file version that it is based on (if known). Cheap
    /// to call often: it only compares, and queues what has changed.
    pub fn keep(&mut self, scene_path: Option<&Path>, text: &str, disk_text: Option<&str>) {
        if disk_text == Some(text) {
            self.clear();
            return;
        }
        let is_same = |work: &UnsavedWork| {
            work.text == text && work.scene_path.as_deref() == scene_path && work.base.as_deref() == disk_text
        };
        if self.thread.is_none() || self.kept.as_ref().is_some_and(is_same) {
            return;
        }
        let scene_path = scene_path.map(Path::to_owned);
        let work = UnsavedWork { scene_path, text: text.to_owned(), base: disk_text.map(str::to_owned) };
        self.kept = Some(work.clone());
        let absolute = work.scene_path.map(|path| std::path::absolute(&path).unwrap_or(path));
        self.send(DiskTask::Write(UnsavedWork { scene_path: absolute, ..work }, SystemTime::now()));
    }

    /// Removes the recovery file: nothing is unsaved.
    pub fn clear(&mut self) {
        if self.kept.take().is_some() {
            self.send(DiskTask::Remove);
        }
    }

    /// Waits until everything is written.
    pub fn flush(&mut self) {
        if self.thread.is_none() {
            return;
        }
        let mut inbox = self.shared.inbox();
        inbox.hurry = true;
        self.shared.changed.notify_all();
        while inbox.task.is_some() || inbox.busy {
            inbox = self.shared.changed.wait(inbox).unwrap_or_else(PoisonError::into_inner);
        }
        inbox.hurry = false;
    }

    fn send(&self, task: DiskTask) {
        self.shared.inbox().task = Some(task);
        self.shared.changed.notify_all();
    }
}

impl Drop for Recovery {
    fn drop(&mut self) {
        self.shared.inbox().stop = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread needs no second report.
            let _ = thread.join();
        }
        if let Some((lock, path)) = self.lock.take() {
            drop(lock);
            // A leftover lock file is harmless: nobody holds the lock.
            let _ = fs::remove_file(path);
        }
    }
}

/// Body of the thread: runs the newest task, with pauses between writes.
fn work(shared: &Shared, file: &Path) {
    let mut written: Option<Instant> = None;
    let mut inbox = shared.inbox();
    loop {
        let pause = match (&inbox.task, written) {
            (None, _) if inbox.stop => return,
            (None, _) => None,
            (Some(DiskTask::Write(..)), Some(at)) if !inbox.stop && !inbox.hurry => {
                Some(PAUSE.saturating_sub(at.elapsed()))
            }
            _ => Some(Duration::ZERO),
        };
        inbox = match pause {
            None => shared.changed.wait(inbox).unwrap_or_else(PoisonError::into_inner),
            Some(Duration::ZERO) => {
                let task = inbox.task.take();
                inbox.busy = true;
                drop(inbox);
                let result = match task {
                    Some(DiskTask::Write(work, at)) => {
                        written = Some(Instant::now());
                        write(file, &work, at)
                    }
                    _ => remove(file).map_err(|error| format!("{}: {error}", file.display())),
                };
                let mut inbox = shared.inbox();
                inbox.busy = false;
                inbox.problem = result.err().map(|error| format!("crash recovery failed: {error}"));
                shared.changed.notify_all();
                inbox
            }
            Some(pause) => shared.changed.wait_timeout(inbox, pause).unwrap_or_else(PoisonError::into_inner).0,
        };
    }
}

#[cfg(test)]
mod tests;
