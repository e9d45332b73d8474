//! Following a file that another program edits.
//!
//! **Idea.** Editors write in place, or write a new file and rename it over the old one, or remove it and write it again.
//! What is watched is therefore the directory, and where the name is a link, that of the file it leads to. Any event there
//! is only a reason to look: once it has been quiet for a moment and the file's size and time stand still, it is read, and
//! its content compared with what is known of it. So half-written files are not seen, many writes make one change, and
//! touching a file makes none.
//!
//! **Where the system cannot watch** (too many watches, some network drives) the file is looked at every 300 ms; where it
//! can, still every two seconds, since changes made on other machines, and the loss of the directory, cause no events.
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

/// How long it has to be quiet before a file is read.
const QUIET: Duration = Duration::from_millis(30);
/// How long a file may be empty or away in the middle of being saved.
const GRACE: Duration = Duration::from_millis(400);
/// After this long of changing all the time, a file is read nevertheless.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often to look where the system cannot watch, and where it can.
const POLL: [Duration; 2] = [Duration::from_millis(300), Duration::from_secs(2)];

/// A file that is watched. Dropping it ends that, without waiting for a slow disk.
pub struct FileWatcher {
    shared: Arc<Shared>,
    sender: Sender<Message>,
}

enum Message {
    /// Something happened in the directory.
    Look,
    Stop,
}

struct Shared {
    path: PathBuf,
    stopped: AtomicBool,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// What is known of the file: its content, or why there is none; nothing before the first look.
    known: Option<Result<String, String>>,
    change: Option<Result<String, String>>,
    /// How often the caller has said what is known; what was read before is of no account.
    revision: u64,
}

impl Shared {
    /// The contents of the lock, also after a panic: every value is whole at any time.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }
}

impl FileWatcher {
    /// Follows a file. Changes count from its content now; [`known`](Self::known) says what it should be instead.
    /// `wake` is called, on another thread, when there is a change to be had.
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
            follow(&shared, &receiver, POLL[usize::from(watcher.is_some())], wake);
        });
        if let Err(error) = thread {
            let message = format!("{}: is not watched for changes: {error}", shared.path.display());
            shared.state().change = Some(Err(message));
        }
        Self { shared, sender }
    }

    /// The file's new text, once after each change; or, in one sentence, why it cannot be read any more.
    pub fn take_change(&mut self) -> Option<Result<String, String>> {
        self.shared.state().change.take()
    }

    /// Says that the file's content is this, as far as the caller knows, who has just read or written it; whatever
    /// differs from it is a change.
    pub fn set_known(&mut self, text: &str) {
        let mut state = self.shared.state();
        state.known = Some(Ok(text.to_owned()));
        state.change = None;
        state.revision += 1;
        drop(state);
        // Without a thread nothing follows.
        let _ = self.sender.send(Message::Look);
    }
}

impl Drop for FileWatcher {
    fn drop(&mut self) {
        self.shared.stopped.store(true, Ordering::SeqCst);
        let _ = self.sender.send(Message::Stop);
    }
}

/// A watcher of all directories that matter, if the system has one.
fn watcher(path: &Path, sender: Sender<Message>) -> Option<RecommendedWatcher> {
    // Whatever happened, also an overflow of events, is a reason to look; without a listener nobody has to be revision.
    let mut watcher = notify::recommended_watcher(move |event: notify::Result<notify::Event>| {
        if !event.is_ok_and(|event| event.kind.is_access()) {
            let _ = sender.send(Message::Look);
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

/// The thread.
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
            Ok(Message::Look) => seen = None,
            Err(RecvTimeoutError::Timeout) => {}
        }
    }
}

/// A file that stands still.
struct Found {
    content: Result<String, String>,
    stamp: Stamp,
    /// [`State::revision`] before it was read.
    revision: u64,
}

/// Notes what the file holds; whether that is a change.
fn publish(shared: &Shared, found: Found) -> bool {
    let mut state = shared.state();
    // Whoever tells what is known has another look taken.
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

/// Waits until the file stands still, and reads it; nothing when it is time to stop.
fn settle(shared: &Shared, receiver: &Receiver<Message>) -> Option<Found> {
    let began = Instant::now();
    loop {
        let before = Stamp::of(&shared.path);
        // Quiet is when no event came for a while.
        loop {
            match receiver.recv_timeout(QUIET) {
                Ok(Message::Stop) | Err(RecvTimeoutError::Disconnected) => return None,
                Ok(Message::Look) if began.elapsed() < PATIENCE => {}
                Ok(Message::Look) | Err(RecvTimeoutError::Timeout) => break,
            }
        }
        if shared.stopped() {
            return None;
        }
        let revision = shared.state().revision;
        let content = read(&shared.path);
        let after = Stamp::of(&shared.path);
        let waited = began.elapsed();
        let still = before == after || waited > PATIENCE;
        // Empty and missing files are usually on the way to being something else.
        let whole = content.as_ref().is_ok_and(|text| !text.is_empty()) || waited > GRACE || may_be_empty(shared);
        if still && whole {
            return Some(Found { content, stamp: after, revision });
        }
    }
}

/// Whether there is nothing to wait for in an empty or missing file.
fn may_be_empty(shared: &Shared) -> bool {
    match &shared.state().known {
        None => true,
        Some(Ok(text)) => text.is_empty(),
        Some(Err(_)) => false,
    }
}

/// What tells one state of a file from another without reading it.
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
    let fail = |reason: &str| Err(format!("{}: {reason}; the picture stays as it was", path.display()));
    let mut bytes = Vec::new();
    let result = fs::metadata(path).and_then(|data| {
        // A pipe would be waited for without end.
        if data.is_file() { File::open(path)?.read_to_end(&mut bytes) } else { Err(ErrorKind::InvalidInput.into()) }
    });
    match result {
        Ok(_) => String::from_utf8(bytes).or_else(|_| fail("is not UTF-8 text any more")),
        Err(error) => match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => fail("was deleted, renamed or moved"),
            ErrorKind::InvalidInput => fail("is not a file any more"),
            ErrorKind::PermissionDenied => fail("may not be read any more"),
            _ => fail(&format!("cannot be read any more: {error}")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::tests::patience;
    use std::sync::Weak;

    struct Watched {
        directory: tempfile::TempDir,
        path: PathBuf,
        watch: FileWatcher,
        woken: Receiver<()>,
    }

    /// A file that is watched by events, or by looking.
    fn watched(events: bool) -> Watched {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.kdl");
        fs::write(&path, "old").expect("written");
        let (sender, woken) = channel();
        let mut watch = FileWatcher::with(&path, move || sender.send(()).unwrap_or_default(), events);
        watch.set_known("old");
        Watched { directory, path, watch, woken }
    }

    impl Watched {
        fn next(&mut self) -> Result<String, String> {
            loop {
                self.woken.recv_timeout(patience()).expect("a change");
                if let Some(change) = self.watch.take_change() {
                    return change;
                }
            }
        }

        /// Waits until this is the newest; what comes before does not matter.
        fn until(&mut self, text: &str) {
            while self.next().as_deref() != Ok(text) {}
        }
    }

    #[test]
    fn every_way_to_save_is_seen() {
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
            assert_eq!(file.watch.take_change(), None, "once for each change");
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
    fn a_file_of_half_the_size_is_not_seen() {
        let text = "0123456789".repeat(10_000);
        let began = Instant::now();
        loop {
            let mut file = watched(true);
            let emptied = Instant::now();
            fs::write(&file.path, "").expect("written");
            fs::write(&file.path, &text).expect("written");
            // A file that is empty for longer than that is an empty file; on a busy machine the test is what was slow.
            if emptied.elapsed() < GRACE / 2 {
                assert_eq!(file.next().as_deref(), Ok(&text[..]), "neither empty nor a part");
                return;
            }
            assert!(began.elapsed() < patience(), "no file was written fast enough");
        }
    }

    #[test]
    fn what_is_known_is_no_change() {
        let mut file = watched(true);
        fs::write(&file.path, "own").expect("written");
        file.watch.set_known("own");
        fs::write(&file.path, "of others").expect("written");
        assert_eq!(file.next().as_deref(), Ok("of others"));
        // Known to be something that it is not: that is a change.
        file.watch.set_known("lost");
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
        let mut watch = FileWatcher::new(&link, move || sender.send(()).unwrap_or_default());
        watch.set_known("old");
        fs::write(&real, "new").expect("written");
        woken.recv_timeout(patience()).expect("a change");
        assert_eq!(watch.take_change(), Some(Ok("new".to_owned())));
    }

    #[test]
    fn a_missing_file_is_said_and_awaited() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("later.kdl");
        let (sender, woken) = channel();
        let mut watch = FileWatcher::new(&path, move || sender.send(()).unwrap_or_default());
        woken.recv_timeout(patience()).expect("a change");
        assert!(watch.take_change().expect("change").is_err());
        fs::write(&path, "here").expect("written");
        woken.recv_timeout(patience()).expect("a change");
        assert_eq!(watch.take_change(), Some(Ok("here".to_owned())));
    }

    #[test]
    fn dropping_it_ends_the_thread() {
        let directory = tempfile::tempdir().expect("a directory");
        let alive = Arc::new(());
        let weak: Weak<()> = Arc::downgrade(&alive);
        let watch = FileWatcher::new(&directory.path().join("a.kdl"), move || {
            let _ = &alive;
        });
        drop(watch);
        let began = Instant::now();
        while weak.upgrade().is_some() {
            assert!(began.elapsed() < patience(), "the thread lives on");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
