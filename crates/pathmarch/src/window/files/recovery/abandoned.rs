//! Abandoned work: recovery files whose program has ended.

use super::format::{RecoveredWork, read};
use std::fs::{self, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Suffix of recovery files; the lock file has [`LOCK`] instead.
pub(super) const KEPT: &str = "unsaved.kdl";
pub(super) const LOCK: &str = "lock";

/// Removes a file, which may be gone already.
pub(super) fn remove(file: &Path) -> io::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

impl RecoveredWork {
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

pub(super) fn lock_of(kept: &Path) -> PathBuf {
    let name = kept.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    kept.with_file_name(format!("{}{LOCK}", name.strip_suffix(KEPT).unwrap_or(name)))
}

/// Returns true if a running program holds this lock.
fn is_owned(lock: &Path) -> bool {
    let Ok(lock) = OpenOptions::new().write(true).open(lock) else { return false };
    matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
}

/// Removes lock files without work that are at least a minute old: a newer one may not be locked yet.
pub(super) fn remove_stale_locks(directory: &Path) {
    for path in fs::read_dir(directory).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let Some(stem) = name.strip_suffix(LOCK).filter(|stem| stem.ends_with('.')) else { continue };
        let changed = fs::metadata(&path).and_then(|data| data.modified());
        let old = changed.is_ok_and(|at| at.elapsed().is_ok_and(|age| age > Duration::from_secs(60)));
        if old && !path.with_file_name(format!("{stem}{KEPT}")).exists() && !is_owned(&path) {
            // A leftover file is harmless.
            let _ = fs::remove_file(path);
        }
    }
}
