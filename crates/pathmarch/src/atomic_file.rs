//! Writes of a user's own files: replaced as a whole or not at all, with reasons that a user understands.
//!
//! **Idea.** [`AtomicFile`] writes; what it would refuse is found before, so that the reason can be named. A read-only file is
//! not replaced, although a rename could do it.
//!
//! **Where we differ.** Other hard links to the file keep the old content, as with most editors.
//!
//! **Cost.** Two disk flushes, of the file and of its directory.

use pathmarch_render::atomic_file::{AtomicFile, follow_links};
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reason why a file was not written. The old file, if any, is unchanged.
#[derive(Debug, Error)]
pub enum SaveError {
    /// The directory does not exist.
    #[error("{}: the directory {} does not exist; create it, or save elsewhere", path.display(), directory.display())]
    MissingDirectory {
        /// The file.
        path: PathBuf,
        /// Its directory.
        directory: PathBuf,
    },
    /// The path is not a regular file.
    #[error("{}: is not a file; choose another name", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// The file is read-only.
    #[error("{}: is read-only; make it writable, or save under another name", path.display())]
    ReadOnly {
        /// The file.
        path: PathBuf,
    },
    /// The directory is not writable.
    #[error("{}: permission denied, no file can be created in {}; save elsewhere, or change the permissions of that directory", path.display(), directory.display())]
    Denied {
        /// The file.
        path: PathBuf,
        /// Its directory.
        directory: PathBuf,
    },
    /// The disk is full.
    #[error("{}: the disk is full; free some space, or save elsewhere", path.display())]
    Full {
        /// The file.
        path: PathBuf,
    },
    /// Any other error.
    #[error("{}: cannot be written: {source}; save elsewhere", path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

/// Writes a file, replacing an old one.
///
/// # Errors
/// Fails with [`SaveError`]; the old file is unchanged and no temporary file remains.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), SaveError> {
    write_with(path, |file| file.write_all(bytes))
}

/// Checks that a file can be written, before long work rather than after it.
///
/// # Errors
/// Fails as [`write_atomically`] would.
#[cfg(feature = "window")]
pub fn check_writable(path: &Path) -> Result<(), SaveError> {
    let target = Target::of(path)?;
    tempfile::tempfile_in(&target.directory).map(drop).map_err(|error| target.explain(error))
}

/// Writes atomically, with a function that produces the content.
fn write_with(path: &Path, write: impl FnOnce(&mut AtomicFile) -> io::Result<()>) -> Result<(), SaveError> {
    let target = Target::of(path)?;
    target.replace(write).map_err(|error| target.explain(error))
}

/// Target of a write.
struct Target {
    /// The file itself, after following links.
    file: PathBuf,
    directory: PathBuf,
}

impl Target {
    fn of(path: &Path) -> Result<Self, SaveError> {
        let other = |source| SaveError::Other { path: path.to_owned(), source };
        let file = follow_links(path).map_err(other)?;
        let directory = match file.parent() {
            Some(parent) if parent.as_os_str().is_empty() => PathBuf::from("."),
            Some(parent) => parent.to_owned(),
            None => return Err(SaveError::NotAFile { path: file }),
        };
        if file.file_name().is_none() {
            return Err(SaveError::NotAFile { path: file });
        }
        if !directory.is_dir() {
            return Err(SaveError::MissingDirectory { path: file, directory });
        }
        match fs::metadata(&file) {
            Ok(old) if !old.is_file() => return Err(SaveError::NotAFile { path: file }),
            Ok(old) => {
                let refused = || match OpenOptions::new().write(true).open(&file) {
                    Ok(_) => false,
                    Err(error) => error.kind() == ErrorKind::PermissionDenied,
                };
                if old.permissions().readonly() || refused() {
                    return Err(SaveError::ReadOnly { path: file });
                }
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(other(error)),
        }
        Ok(Self { file, directory })
    }

    fn replace(&self, write: impl FnOnce(&mut AtomicFile) -> io::Result<()>) -> io::Result<()> {
        let mut file = AtomicFile::create(&self.file)?;
        write(&mut file)?;
        file.commit()
    }

    fn explain(&self, source: io::Error) -> SaveError {
        let path = self.file.clone();
        match source.kind() {
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                SaveError::Denied { path, directory: self.directory.clone() }
            }
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => SaveError::Full { path },
            ErrorKind::NotFound => SaveError::MissingDirectory { path, directory: self.directory.clone() },
            _ => SaveError::Other { path, source },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(directory)
            .expect("a directory")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_made_and_replaced() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.kdl");
        write_atomically(&path, b"one").expect("written");
        write_atomically(&path, b"two, and longer").expect("written");
        #[cfg(feature = "window")]
        check_writable(&path).expect("writable");
        assert_eq!(fs::read(&path).expect("read"), b"two, and longer");
        assert_eq!(names(directory.path()), ["a.kdl"]);
    }

    #[test]
    fn a_failure_leaves_the_old_file() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.kdl");
        write_atomically(&path, b"old").expect("written");
        for (kind, words) in [
            (ErrorKind::StorageFull, "disk is full"),
            (ErrorKind::QuotaExceeded, "disk is full"),
            (ErrorKind::ReadOnlyFilesystem, "no file can be created"),
            (ErrorKind::PermissionDenied, "no file can be created"),
            (ErrorKind::BrokenPipe, "cannot be written"),
        ] {
            let failing = |file: &mut AtomicFile| file.write_all(b"ne").and(Err(kind.into()));
            let message = write_with(&path, failing).expect_err("it fails").to_string();
            assert!(message.contains(words) && message.contains("a.kdl"), "{message}");
            assert_eq!(fs::read(&path).expect("read"), b"old");
            assert_eq!(names(directory.path()), ["a.kdl"], "the temporary file is gone");
        }
    }

    #[test]
    fn unwritable_targets_are_reported() {
        let directory = tempfile::tempdir().expect("a directory");
        let missing = directory.path().join("no").join("a.kdl");
        assert!(matches!(write_atomically(&missing, b""), Err(SaveError::MissingDirectory { .. })));
        assert!(matches!(write_atomically(directory.path(), b""), Err(SaveError::NotAFile { .. })));
        assert!(matches!(write_atomically(Path::new("/"), b""), Err(SaveError::NotAFile { .. })));
        assert!(matches!(write_atomically(&directory.path().join(".."), b""), Err(SaveError::NotAFile { .. })));

        let path = directory.path().join("a.kdl");
        fs::write(&path, "old").expect("written");
        let mut permissions = fs::metadata(&path).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).expect("set");
        assert!(matches!(write_atomically(&path, b"new"), Err(SaveError::ReadOnly { .. })));
        #[cfg(feature = "window")]
        assert!(matches!(check_writable(&path), Err(SaveError::ReadOnly { .. })));
        assert_eq!(fs::read(&path).expect("read"), b"old");
    }

    #[cfg(unix)]
    #[test]
    fn a_read_only_directory_is_reported() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.kdl");
        fs::write(&path, "old").expect("written");
        fs::set_permissions(directory.path(), fs::Permissions::from_mode(0o555)).expect("set");
        // Root ignores permissions; `/sys` refuses even root.
        let privileged = tempfile::tempfile_in(directory.path()).is_ok();
        let place = if privileged { Path::new("/sys/kernel/a.kdl") } else { &path };
        if place.parent().is_some_and(Path::is_dir) {
            let result = write_atomically(place, b"new");
            assert!(matches!(result, Err(SaveError::Denied { .. })), "{result:?}");
            #[cfg(feature = "window")]
            assert!(matches!(check_writable(place), Err(SaveError::Denied { .. } | SaveError::Other { .. })));
        }
        fs::set_permissions(directory.path(), fs::Permissions::from_mode(0o755)).expect("set");
        assert_eq!(fs::read(&path).expect("read"), b"old");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = tempfile::tempdir().expect("a directory");
        let real = directory.path().join("real.kdl");
        fs::write(&real, "old").expect("written");
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("set");
        fs::create_dir(directory.path().join("sub")).expect("made");
        let link = directory.path().join("sub/link.kdl");
        symlink("../real.kdl", &link).expect("linked");
        write_atomically(&link, b"new").expect("written");
        assert_eq!(fs::read(&real).expect("read"), b"new");
        assert_eq!(fs::metadata(&real).expect("there").permissions().mode() & 0o777, 0o640);
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());

        let dangling = directory.path().join("dangling.kdl");
        symlink("made.kdl", &dangling).expect("linked");
        write_atomically(&dangling, b"new").expect("written");
        assert_eq!(fs::read(directory.path().join("made.kdl")).expect("read"), b"new");

        let circle = directory.path().join("circle.kdl");
        symlink("circle.kdl", &circle).expect("linked");
        let message = write_atomically(&circle, b"new").expect_err("it fails").to_string();
        assert!(message.contains("circle"), "{message}");
    }
}
