//! Atomic writes: a file is written under a temporary name beside the target, flushed to the disk, and renamed when it is
//! complete.
//!
//! A symbolic link is followed: its target is replaced. The new file keeps the permissions of the old one. What is not a
//! regular file, such as a directory, a pipe or a device, is refused. A temporary file is locked while it is written, so that
//! the next write of the same target can remove those of programs that were killed, and no others.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Extension of temporary files.
const SUFFIX: &str = ".part";
/// Number of links that are followed from one to the next.
const MAX_LINKS: usize = 40;

/// Directory of a file.
pub fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// File being written; dropping it removes what was written.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    temporary: NamedTempFile,
}

impl AtomicFile {
    /// Creates a temporary file beside the target of `path`.
    ///
    /// # Errors
    /// If it cannot be created, or `path` exists and is not a regular file.
    pub fn create(path: &Path) -> io::Result<Self> {
        let target = follow_links(path)?;
        let old = match fs::metadata(&target) {
            Ok(old) if old.is_dir() => return Err(ErrorKind::IsADirectory.into()),
            Ok(old) if !old.is_file() => return Err(io::Error::other("it exists and is not a file")),
            Ok(old) if old.permissions().readonly() => return Err(ErrorKind::PermissionDenied.into()),
            Ok(old) => Some(old),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        let prefix = prefix(&target);
        remove_abandoned(&target, &prefix);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX);
        #[cfg(unix)]
        if old.is_none() {
            // The umask applies, as for any new file; tempfile's default is private to the user.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let temporary = builder.tempfile_in(directory(&target))?;
        // Some network file systems have no locks; a file there may stay behind.
        let _ = temporary.as_file().try_lock();
        if let Some(old) = old {
            keep_attributes(temporary.as_file(), &old);
        }
        Ok(Self { target, temporary })
    }

    /// Flushes the file to the disk and gives it its name.
    ///
    /// # Errors
    /// If the disk is full or the file cannot be renamed; nothing has changed then.
    pub fn commit(self) -> io::Result<()> {
        self.temporary.as_file().sync_all()?;
        let directory = directory(&self.target).to_owned();
        self.temporary.persist(&self.target).map_err(|error| error.error)?;
        // The new name, too, survives a power failure. Systems that cannot flush a directory do not need it.
        #[cfg(unix)]
        if let Ok(directory) = File::open(directory) {
            let _ = directory.sync_all();
        }
        #[cfg(not(unix))]
        drop(directory);
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.temporary.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        self.temporary.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.temporary.seek(to)
    }
}

/// File that a path leads to through symbolic links; it need not exist.
///
/// # Errors
/// If the links form a loop or cannot be read.
pub fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut file = path.to_owned();
    for _ in 0..MAX_LINKS {
        if !fs::symlink_metadata(&file).is_ok_and(|found| found.is_symlink()) {
            return Ok(file);
        }
        file = directory(&file).join(fs::read_link(&file)?);
    }
    Err(io::Error::other("it is a symbolic link that leads nowhere"))
}

/// Start of the names of a target's temporary files.
fn prefix(target: &Path) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(target.file_name().unwrap_or_default());
    prefix.push(".");
    prefix
}

/// Removes the temporary files of a target that no program is writing.
fn remove_abandoned(target: &Path, prefix: &OsString) {
    let Ok(files) = fs::read_dir(directory(target)) else { return };
    let Some(prefix) = prefix.to_str() else { return };
    for file in files.flatten() {
        let name = file.file_name();
        let random = name.to_str().and_then(|name| name.strip_prefix(prefix)?.strip_suffix(SUFFIX));
        // The random part of tempfile's names.
        if !random.is_some_and(|random| random.len() == 6 && random.bytes().all(|byte| byte.is_ascii_alphanumeric())) {
            continue;
        }
        let is_abandoned = |file: File| file.try_lock().is_ok();
        if fs::OpenOptions::new().write(true).open(file.path()).is_ok_and(is_abandoned) {
            let _ = fs::remove_file(file.path());
        }
    }
}

/// Gives a new file the permissions of the old one and, where the system allows, its owner.
fn keep_attributes(file: &File, old: &fs::Metadata) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        // Usually only root can change the owner; keeping the group matters more.
        let _ = fchown(file, None, Some(old.gid())).and_then(|()| fchown(file, Some(old.uid()), None));
    }
    let _ = file.set_permissions(old.permissions());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, text: &str) -> io::Result<()> {
        let mut file = AtomicFile::create(path)?;
        file.write_all(text.as_bytes())?;
        file.commit()
    }

    fn names(directory: &Path) -> Vec<String> {
        let names = fs::read_dir(directory).expect("a directory").flatten();
        let mut names: Vec<_> = names.map(|file| file.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_programs_that_were_killed_left_behind_is_removed() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.png");
        for name in [".a.png.AbC123.part", ".a.png.notes.part", ".b.png.AbC123.part"] {
            fs::write(directory.path().join(name), "torn").expect("written");
        }
        // A second write of the same target goes on.
        let other = AtomicFile::create(&path).expect("created");
        write(&path, "whole").expect("written");
        other.commit().expect("it was not removed");
        assert_eq!(names(directory.path()), [".a.png.notes.part", ".b.png.AbC123.part", "a.png"]);
    }

    #[test]
    fn nothing_is_left_of_a_write_that_is_given_up() {
        let directory = tempfile::tempdir().expect("a directory");
        drop(AtomicFile::create(&directory.path().join("a.png")).expect("created"));
        assert!(names(directory.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_are_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = tempfile::tempdir().expect("a directory");
        let [real, link, chain, dangling] =
            ["real", "link", "chain", "dangling"].map(|name| directory.path().join(name));
        fs::write(&real, "old").expect("written");
        fs::set_permissions(&real, fs::Permissions::from_mode(0o600)).expect("a mode");
        symlink("real", &link).expect("a link");
        symlink(&link, &chain).expect("a link");
        write(&chain, "new").expect("written");
        assert_eq!(fs::read_to_string(&real).expect("text"), "new");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::metadata(&real).expect("there").permissions().mode() & 0o777, 0o600);
        symlink("later", &dangling).expect("a link");
        write(&dangling, "made").expect("written");
        assert_eq!(fs::read_to_string(directory.path().join("later")).expect("text"), "made");
        symlink("loop", directory.path().join("loop")).expect("a link");
        assert!(write(&directory.path().join("loop"), "never").is_err());
    }

    #[test]
    fn what_is_not_a_file_is_refused() {
        let directory = tempfile::tempdir().expect("a directory");
        assert!(AtomicFile::create(directory.path()).is_err());
        #[cfg(unix)]
        assert!(write(Path::new("/dev/null"), "never").is_err());
    }
}
