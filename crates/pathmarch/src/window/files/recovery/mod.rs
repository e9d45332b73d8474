//! Crash recovery of unsaved work.
//!
//! **Idea.** Each window stores its unsaved text in a file of its own, and locks a second file beside it while it runs.
//! The system releases the lock however the program ends. A later window takes files without a locked partner as
//! abandoned work.
//!
//! **Format.** The scene text after a header of comments, so that any editor and `pathmarch check` can read it:
//!
//! ```text
//! // pathmarch: work that was not saved
//! // scene: /home/someone/balls.kdl
//! // saved: 1760000000
//! // program: 0.1.0
//! // based on: sha256 9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08
//! // bytes: 1234
//! // text:
//! ```
//!
//! Everything after the last header line is the text, byte for byte. In the path, `%` and characters that would end or
//! garble the line are percent-encoded; a scene without a file has no such line. The time is in seconds since 1970. The
//! work is based on the version of the file with this SHA-256 hash: if the file's hash differs, another program has
//! changed it. The line is missing if that version is unknown, as in files of older programs.
//!
//! **Cost.** A sleeping thread; it writes at most once a second, and only if the text has changed.

use crate::window::files::atomic_file::write_atomically;
use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Minimum time between two writes.
const PAUSE: Duration = Duration::from_secs(1);
const FIRST_LINE: &str = "// pathmarch: work that was not saved";
const LAST_LINE: &str = "// text:";
/// Suffix of recovery files; the lock file has [`LOCK`] instead.
const KEPT: &str = "unsaved.kdl";
const LOCK: &str = "lock";

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

/// Work to store.
#[derive(Clone, PartialEq)]
struct UnsavedWork {
    /// File of the scene.
    scene_path: Option<PathBuf>,
    text: String,
    /// Text of the file version that the work is based on.
    base: Option<String>,
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

fn write(file: &Path, UnsavedWork { scene_path, text, base }: &UnsavedWork, at: SystemTime) -> Result<(), String> {
    let seconds = at.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let scene = scene_path.as_deref().map(|path| format!("// scene: {}\n", encode(path))).unwrap_or_default();
    let base = base.as_deref().map(|base| format!("// based on: {}\n", version(base))).unwrap_or_default();
    let (program, bytes) = (env!("CARGO_PKG_VERSION"), text.len());
    let header = format!(
        "{FIRST_LINE}\n{scene}// saved: {seconds}\n// program: {program}\n{base}// bytes: {bytes}\n{LAST_LINE}\n"
    );
    write_atomically(file, (header + text).as_bytes()).map_err(|error| error.to_string())
}

/// Hash that identifies a version of a file.
fn version(text: &str) -> String {
    let hash = Sha256::digest(text.as_bytes());
    let digits: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
    format!("sha256 {digits}")
}

/// Removes a file, which may be gone already.
fn remove(file: &Path) -> io::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Unsaved work of a program that has ended.
#[derive(Debug)]
pub struct RecoveredWork {
    /// File of the scene; `None` if it was never saved.
    pub scene_path: Option<PathBuf>,
    /// The text, or the reason why it cannot be read, in one sentence.
    pub text: Result<String, String>,
    /// Version of the file that it is based on, if known.
    base: Option<String>,
    /// Time of the last write.
    pub saved_at: SystemTime,
    /// Path of the recovery file.
    pub file: PathBuf,
}

impl RecoveredWork {
    /// Returns true if the work is based on the file version with this text; false if the version is unknown.
    pub fn is_based_on(&self, text: &str) -> bool {
        self.base.as_deref().is_some_and(|base| base == version(text))
    }

    /// Removes the recovery file for good.
    ///
    /// # Errors
    /// Fails with a message if the file cannot be removed.
    pub fn discard(self) -> Result<(), String> {
        remove(&self.file).map_err(|error| format!("{}: cannot be removed: {error}", self.file.display()))?;
        let _ = remove(&lock_of(&self.file));
        Ok(())
    }
}

/// Finds abandoned work in a directory, newest first. Damaged files are included.
pub fn find_abandoned_work(directory: &Path) -> Vec<RecoveredWork> {
    let Ok(entries) = fs::read_dir(directory) else { return Vec::new() };
    let mut found = Vec::new();
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.starts_with('.') || !name.ends_with(&format!(".{KEPT}")) {
            continue;
        }
        if !is_owned(&lock_of(&path)) {
            found.push(read(path));
        }
    }
    found.sort_by_key(|recovered| std::cmp::Reverse(recovered.saved_at));
    found
}

fn lock_of(kept: &Path) -> PathBuf {
    let name = kept.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    kept.with_file_name(format!("{}{LOCK}", name.strip_suffix(KEPT).unwrap_or(name)))
}

/// Returns true if a running program holds this lock.
fn is_owned(lock: &Path) -> bool {
    let Ok(lock) = OpenOptions::new().write(true).open(lock) else { return false };
    matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
}

/// Removes lock files without work that are at least a day old: a newer one may not be locked yet.
fn remove_stale_locks(directory: &Path) {
    for path in fs::read_dir(directory).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let Some(stem) = name.strip_suffix(LOCK).filter(|stem| stem.ends_with('.')) else { continue };
        let changed = fs::metadata(&path).and_then(|data| data.modified());
        let old = changed.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > Duration::from_secs(24 * 60 * 60)));
        if old && !path.with_file_name(format!("{stem}{KEPT}")).exists() && !is_owned(&path) {
            // A leftover file is harmless.
            let _ = fs::remove_file(path);
        }
    }
}

fn read(file: PathBuf) -> RecoveredWork {
    let changed = fs::metadata(&file).and_then(|data| data.modified()).unwrap_or(UNIX_EPOCH);
    let damaged = |reason: &str| Err(format!("{}: {reason}; open it in an editor", file.display()));
    let mut recovered =
        RecoveredWork { scene_path: None, text: Ok(String::new()), base: None, saved_at: changed, file: file.clone() };
    let bytes = match fs::read(&file) {
        Ok(bytes) => bytes,
        Err(error) => {
            recovered.text = damaged(&format!("cannot be read: {error}"));
            return recovered;
        }
    };
    let mut rest = &bytes[..];
    let mut length = None;
    let mut lines = 0;
    recovered.text = loop {
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else {
            break damaged("the header is missing or incomplete");
        };
        let line = String::from_utf8_lossy(&rest[..end]).into_owned();
        rest = &rest[end + 1..];
        lines += 1;
        if lines == 1 && line != FIRST_LINE || !line.starts_with("// ") {
            break damaged("the header is missing or damaged");
        }
        if line == LAST_LINE {
            break match String::from_utf8(rest.to_owned()) {
                Ok(text) if length.is_none_or(|length| length == text.len()) => Ok(text),
                Ok(_) => damaged("the text was truncated or changed"),
                Err(_) => damaged("the text is not UTF-8"),
            };
        }
        match line[3..].split_once(": ") {
            Some(("scene", path)) => recovered.scene_path = Some(decode(path)),
            Some(("saved", seconds)) => {
                let at = seconds.parse().ok().and_then(|s| UNIX_EPOCH.checked_add(Duration::from_secs(s)));
                recovered.saved_at = at.unwrap_or(changed);
            }
            Some(("based on", version)) => recovered.base = Some(version.to_owned()),
            Some(("bytes", bytes)) => length = bytes.parse::<usize>().ok(),
            _ => {}
        }
    };
    recovered
}

/// Encodes a path as one line of text.
fn encode(path: &Path) -> String {
    let mut line = String::new();
    // On systems whose paths are not bytes, parts that are not Unicode are lost; such names are rare.
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        for character in chunk.valid().chars() {
            if character == '%' || character.is_control() || matches!(character, '\u{2028}' | '\u{2029}') {
                let mut bytes = [0; 4];
                character.encode_utf8(&mut bytes).bytes().for_each(|byte| line += &format!("%{byte:02x}"));
            } else {
                line.push(character);
            }
        }
        chunk.invalid().iter().for_each(|byte| line += &format!("%{byte:02x}"));
    }
    line
}

/// Decodes a path written by [`encode`].
fn decode(line: &str) -> PathBuf {
    let mut bytes = Vec::new();
    let mut rest = line.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = (*first == b'%').then(|| std::str::from_utf8(tail.get(..2)?).ok()).flatten();
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    #[cfg(unix)]
    let name: OsString = std::os::unix::ffi::OsStringExt::from_vec(bytes);
    #[cfg(not(unix))]
    let name = OsString::from(String::from_utf8_lossy(&bytes).into_owned());
    name.into()
}

#[cfg(test)]
mod tests;
