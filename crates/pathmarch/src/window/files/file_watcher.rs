//! File watcher: detects changes of a file by other programs.
//!
//! **Idea.** Editors write in place, or rename a new file over the old one, or delete the file and write it again. The
//! watcher therefore watches the directory and, for a symbolic link, also that of its target. An event only triggers a
//! check: once there is a quiet period and the file's size and time are stable, the file is read and compared with its
//! known content. So half-written files are never reported, many writes make one change, and touching a file makes
//! none.
//!
//! **Fallback.** If the system cannot watch (too many watches, some network drives), the file is polled every 300 ms.
//! Otherwise it is still polled every two seconds: changes made on other machines, and the loss of the directory, cause
//! no events.
//!
//! **Cost.** A thread that sleeps.

use notify::{RecommendedWatcher, RecursiveMode, Watcher};
use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime};

/// Quiet period before a file is read.
const QUIET_PERIOD: Duration = Duration::from_millis(30);
/// Time that a file may be empty or missing while it is being saved.
const MISSING_PERIOD: Duration = Duration::from_millis(400);
/// Maximum time to wait for a quiet period.
const MAX_WAIT: Duration = Duration::from_secs(1);
/// Polling intervals: without and with events of the system.
const POLL_INTERVALS: [Duration; 2] = [Duration::from_millis(300), Duration::from_secs(2)];

/// Watcher of one file. Dropping it stops the thread without waiting for a slow disk.
pub struct FileWatcher {
    shared: Arc<Shared>,
    sender: Sender<Message>,
}

enum Message {
    /// An event in the directory: check the file.
    Check,
    Stop,
}

struct Shared {
    path: PathBuf,
    stopped: AtomicBool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Known content of the file, or the reason why it cannot be read; `None` before the first check.
    known: Option<Result<String, String>>,
    change: Option<Result<String, String>>,
    /// Number of calls of [`FileWatcher::set_known`]. Content that was read before the last call is discarded.
    revision: u64,
}

impl Shared {
    /// Locks the state, even after a panic of the other thread: every value is complete at any time.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }
}

impl FileWatcher {
    /// Watches a file. Changes are relative to its current content, or to that of [`set_known`](Self::set_known). Calls
    /// `wake` on another thread when there is a change.
    pub fn new(path: &Path, wake: impl Fn() + Send + 'static) -> Self {
        Self::with(path, wake, true)
    }

    fn with(path: &Path, wake: impl Fn() + Send + 'static, events: bool) -> Self {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let shared = Arc::new(Shared { path, stopped: AtomicBool::new(false), state: Mutex::default() });
        let (sender, receiver) = channel();
        let watched = (shared.clone(), sender.clone());
        let thread = std::thread::Builder::new().name("watch".to_owned()).spawn(move || {
            let (shared, sender) = watched;
            let watcher = if events { watcher(&shared.path, sender) } else { None };
            follow(&shared, &receiver, POLL_INTERVALS[usize::from(watcher.is_some())], wake);
        });
        if let Err(error) = thread {
            let message = format!("{}: is not watched for changes: {error}", shared.path.display());
            shared.state().change = Some(Err(message));
        }
        Self { shared, sender }
    }

    /// Takes the pending change: the new text, or why the file can no longer be read, in one sentence.
    pub fn take_change(&mut self) -> Option<Result<String, String>> {
        self.shared.state().change.take()
    }

    /// Sets the known content, which the caller has just read or written. Any other content is a change.
    pub fn set_known(&mut self, text: &str) {
        let mut state = self.shared.state();
        state.known = Some(Ok(text.to_owned()));
        state.change = None;
        state.revision += 1;
        drop(state);
        // Without a thread nothing is watched.
        let _ = self.sender.send(Message::Check);
    }
}

impl Drop for FileWatcher {
    fn drop(&mut self) {
        self.shared.stopped.store(true, Ordering::SeqCst);
        let _ = self.sender.send(Message::Stop);
    }
}

/// Event source for all relevant directories, if the system has one.
fn watcher(path: &Path, sender: Sender<Message>) -> Option<RecommendedWatcher> {
    // Every event triggers a check, even an overflow of the event queue.
    let mut watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
        if !event.is_ok_and(|event| event.kind.is_access()) {
            let _ = sender.send(Message::Check);
        }
    })
    .ok()?;
    watcher.watch(path.parent()?, RecursiveMode::NonRecursive).ok()?;
    if let Ok(real) = fs::canonicalize(path)
        && let Some(directory) = real.parent()
        && fs::canonicalize(path.parent()?).is_ok_and(|watched| watched != directory)
    {
        watcher.watch(directory, RecursiveMode::NonRecursive).ok()?;
    }
    Some(watcher)
}

/// Body of the watcher thread.
fn follow(shared: &Shared, receiver: &Receiver<Message>, poll: Duration, wake: impl Fn()) {
    let mut seen: Option<Stamp> = None;
    loop {
        let stamp = Stamp::of(&shared.path);
        if seen != Some(stamp) {
            let Some(found) = settle(shared, receiver) else { return };
            seen = Some(found.stamp);
            if publish(shared, found) && !shared.stopped() {
                wake();
            }
        }
        match receiver.recv_timeout(poll) {
            Ok(Message::Stop) | Err(RecvTimeoutError::Disconnected) => return,
            Ok(Message::Check) => seen = None,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

/// A file whose content is stable.
struct Found {
    content: Result<String, String>,
    stamp: Stamp,
    /// [`State::revision`] before the file was read.
    revision: u64,
}

/// Stores new content; returns true if it is a change.
fn publish(shared: &Shared, found: Found) -> bool {
    let mut state = shared.state();
    // `set_known` has triggered another check.
    if state.revision != found.revision || state.known.as_ref() == Some(&found.content) {
        return false;
    }
    let change = state.known.is_some() || found.content.is_err();
    if change {
        state.change = Some(found.content.clone());
    }
    state.known = Some(found.content);
    change
}

/// Waits until the file is stable and reads it; `None` to stop the thread.
fn settle(shared: &Shared, receiver: &Receiver<Message>) -> Option<Found> {
    let began = Instant::now();
    loop {
        let before = Stamp::of(&shared.path);
        // Quiet: no event for a while.
        loop {
            match receiver.recv_timeout(QUIET_PERIOD) {
                Ok(Message::Stop) | Err(RecvTimeoutError::Disconnected) => return None,
                Ok(Message::Check) if began.elapsed() < MAX_WAIT => {}
                Ok(Message::Check) | Err(RecvTimeoutError::Timeout) => break,
            }
        }
        if shared.stopped() {
            return None;
        }
        let revision = shared.state().revision;
        let content = read(&shared.path);
        let after = Stamp::of(&shared.path);
        let waited = began.elapsed();
        let still = before == after || waited > MAX_WAIT;
        // An empty or missing file is usually about to be written.
        let whole =
            content.as_ref().is_ok_and(|text| !text.is_empty()) || waited > MISSING_PERIOD || may_be_empty(shared);
        if still && whole {
            return Some(Found { content, stamp: after, revision });
        }
    }
}

/// Returns true if an empty or missing file can be reported at once.
fn may_be_empty(shared: &Shared) -> bool {
    match &shared.state().known {
        None => true,
        Some(Ok(text)) => text.is_empty(),
        Some(Err(_)) => false,
    }
}

/// Fingerprint of a file's state, without reading it.
#[derive(Clone, Copy, PartialEq)]
struct Stamp(Option<(u64, Option<SystemTime>, u64)>);

impl Stamp {
    fn of(path: &Path) -> Self {
        Self(fs::metadata(path).ok().map(|data| {
            #[cfg(unix)]
            let number = std::os::unix::fs::MetadataExt::ino(&data);
            #[cfg(not(unix))]
            let number = 0;
            (data.len(), data.modified().ok(), number)
        }))
    }
}

fn read(path: &Path) -> Result<String, String> {
    let fail = |reason: &str| Err(format!("{}: {reason}; the last picture is kept", path.display()));
    let mut bytes = Vec::new();
    let result = fs::metadata(path).and_then(|data| {
        // Reading a pipe would block forever.
        if data.is_file() { File::open(path)?.read_to_end(&mut bytes) } else { Err(ErrorKind::InvalidInput.into()) }
    });
    match result {
        Ok(_) => String::from_utf8(bytes).or_else(|_| fail("is no longer UTF-8 text")),
        Err(error) => match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => fail("was deleted, renamed or moved"),
            ErrorKind::InvalidInput => fail("is no longer a file"),
            ErrorKind::PermissionDenied => fail("can no longer be read: permission denied"),
            _ => fail(&format!("can no longer be read: {error}")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::tests::timeout;
    use std::sync::Weak;

    struct Watched {
        directory: tempfile::TempDir,
        path: PathBuf,
        watcher: FileWatcher,
        woken: Receiver<()>,
    }

    /// A file watched with events or by polling.
    fn watched(events: bool) -> Watched {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.kdl");
        fs::write(&path, "old").expect("written");
        let (sender, woken) = channel();
        let mut watcher = FileWatcher::with(&path, move || sender.send(()).unwrap_or_default(), events);
        watcher.set_known("old");
        Watched { directory, path, watcher, woken }
    }

    impl Watched {
        fn next(&mut self) -> Result<String, String> {
            loop {
                self.woken.recv_timeout(timeout()).expect("a change");
                if let Some(change) = self.watcher.take_change() {
                    return change;
                }
            }
        }

        /// Waits for this content, skipping earlier changes.
        fn until(&mut self, text: &str) {
            while self.next().as_deref() != Ok(text) {}
        }
    }

    #[test]
    fn every_way_to_save_is_noticed() {
        for events in [true, false] {
            let mut file = watched(events);
            fs::write(&file.path, "in place").expect("written");
            file.until("in place");

            let other = file.directory.path().join("a.kdl.tmp");
            fs::write(&other, "renamed").expect("written");
            fs::rename(&other, &file.path).expect("renamed");
            file.until("renamed");

            fs::remove_file(&file.path).expect("removed");
            let message = file.next().expect_err("it is gone");
            assert!(message.contains("a.kdl") && message.contains("deleted"), "{message}");
            fs::write(&file.path, "renamed").expect("written");
            file.until("renamed");

            fs::write(&file.path, b"\xff\xfe").expect("written");
            let message = file.next().expect_err("it is no text");
            assert!(message.contains("UTF-8"), "{message}");
            fs::write(&file.path, "text").expect("written");
            file.until("text");

            fs::remove_file(&file.path).expect("removed");
            fs::write(&file.path, "again").expect("written");
            file.until("again");
            assert_eq!(file.watcher.take_change(), None, "once for each change");
        }
    }

    #[test]
    fn the_last_of_many_writes_is_seen() {
        let mut file = watched(true);
        for number in 0..=200 {
            fs::write(&file.path, format!("{number}")).expect("written");
        }
        file.until("200");
    }

    #[test]
    fn a_half_written_file_is_not_reported() {
        let text = "0123456789".repeat(10_000);
        let began = Instant::now();
        loop {
            let mut file = watched(true);
            let emptied = Instant::now();
            fs::write(&file.path, "").expect("written");
            fs::write(&file.path, &text).expect("written");
            // A file that stays empty for longer counts as empty. On a busy machine the test itself may be that slow.
            if emptied.elapsed() < MISSING_PERIOD / 2 {
                assert_eq!(file.next().as_deref(), Ok(&text[..]), "neither empty nor a part");
                return;
            }
            assert!(began.elapsed() < timeout(), "no file was written fast enough");
        }
    }

    #[test]
    fn known_content_is_no_change() {
        let mut file = watched(true);
        fs::write(&file.path, "own").expect("written");
        file.watcher.set_known("own");
        fs::write(&file.path, "of others").expect("written");
        assert_eq!(file.next().as_deref(), Ok("of others"));
        // Known content that differs from the file: that is a change.
        file.watcher.set_known("lost");
        assert_eq!(file.next().as_deref(), Ok("of others"));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        let elsewhere = tempfile::tempdir().expect("a directory");
        let real = elsewhere.path().join("real.kdl");
        fs::write(&real, "old").expect("written");
        let file = watched(true);
        let link = file.directory.path().join("link.kdl");
        std::os::unix::fs::symlink(&real, &link).expect("linked");
        let (sender, woken) = channel();
        let mut watcher = FileWatcher::new(&link, move || sender.send(()).unwrap_or_default());
        watcher.set_known("old");
        fs::write(&real, "new").expect("written");
        woken.recv_timeout(timeout()).expect("a change");
        assert_eq!(watcher.take_change(), Some(Ok("new".to_owned())));
    }

    #[test]
    fn a_missing_file_is_reported_and_awaited() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("later.kdl");
        let (sender, woken) = channel();
        let mut watcher = FileWatcher::new(&path, move || sender.send(()).unwrap_or_default());
        woken.recv_timeout(timeout()).expect("a change");
        assert!(watcher.take_change().expect("change").is_err());
        fs::write(&path, "here").expect("written");
        woken.recv_timeout(timeout()).expect("a change");
        assert_eq!(watcher.take_change(), Some(Ok("here".to_owned())));
    }

    #[test]
    fn dropping_it_ends_the_thread() {
        let directory = tempfile::tempdir().expect("a directory");
        let alive = Arc::new(());
        let weak: Weak<()> = Arc::downgrade(&alive);
        let watcher = FileWatcher::new(&directory.path().join("a.kdl"), move || {
            let _ = &alive;
        });
        drop(watcher);
        let began = Instant::now();
        while weak.upgrade().is_some() {
            assert!(began.elapsed() < timeout(), "the thread lives on");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
