//! Files of the disk, and files in memory.
//!
//! Meshes and scenes name further files: buffers, pictures, fonts, included scenes. A program without a disk, such as a web page,
//! [mounts](mount) these files; readers then find them by the same paths.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, SystemTime};

/// A file in memory.
#[derive(Clone)]
struct Mounted {
    bytes: Arc<[u8]>,
    /// Number of files that were mounted before: it tells contents of one path apart.
    serial: u64,
}

/// Files in memory by their paths without detours, and the number of calls of [`mount`].
static MOUNTED: RwLock<(BTreeMap<PathBuf, Mounted>, u64)> = RwLock::new((BTreeMap::new(), 0));

/// Puts a file into memory for the whole program. It replaces a mounted file of this path, and hides one on the disk.
pub fn mount(path: impl AsRef<Path>, bytes: impl Into<Arc<[u8]>>) {
    let mut mounted = MOUNTED.write().unwrap_or_else(PoisonError::into_inner);
    let serial = mounted.1;
    mounted.1 += 1;
    mounted.0.insert(without_detours(path.as_ref()), Mounted { bytes: bytes.into(), serial });
}

fn mounted(path: &Path) -> Option<Mounted> {
    let mounted = MOUNTED.read().unwrap_or_else(PoisonError::into_inner);
    mounted.0.get(&without_detours(path)).cloned()
}

/// The path without `.`, and without `..` behind a name. Mounted paths have no links, so it names the same file.
fn without_detours(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(short.components().next_back(), Some(Component::Normal(_))) => {
                short.pop();
            }
            part => short.push(part),
        }
    }
    short
}

/// Kind and size of a file.
#[derive(Clone, Copy, Debug)]
pub struct Metadata {
    /// True for a regular file: no directory, pipe or device.
    pub is_file: bool,
    /// True for a directory.
    pub is_directory: bool,
    /// Size, bytes.
    pub bytes: u64,
    /// Time of the last change, if known.
    pub modified: Option<SystemTime>,
}

impl From<&Mounted> for Metadata {
    fn from(file: &Mounted) -> Self {
        let modified = SystemTime::UNIX_EPOCH + Duration::from_nanos(file.serial);
        Self { is_file: true, is_directory: false, bytes: file.bytes.len() as u64, modified: Some(modified) }
    }
}

impl From<std::fs::Metadata> for Metadata {
    fn from(file: std::fs::Metadata) -> Self {
        let modified = file.modified().ok();
        Self { is_file: file.is_file(), is_directory: file.is_dir(), bytes: file.len(), modified }
    }
}

/// Kind and size of the file at `path`; does not open it, which would wait for a pipe.
///
/// # Errors
/// Those of [`std::fs::metadata`].
pub fn metadata(path: &Path) -> io::Result<Metadata> {
    match mounted(path) {
        Some(file) => Ok(Metadata::from(&file)),
        None => std::fs::metadata(path).map(Metadata::from),
    }
}

/// The path without detours and links.
///
/// # Errors
/// Those of [`Path::canonicalize`].
pub fn canonicalize(path: &Path) -> io::Result<PathBuf> {
    if mounted(path).is_some() { Ok(without_detours(path)) } else { path.canonicalize() }
}

/// Opens the file at `path` for reading.
///
/// # Errors
/// Those of [`std::fs::File::open`].
pub fn open(path: &Path) -> io::Result<File> {
    match mounted(path) {
        Some(file) => Ok(File::Memory(Cursor::new(file.bytes))),
        None => std::fs::File::open(path).map(File::Disk),
    }
}

/// All bytes of the file at `path`.
///
/// # Errors
/// Those of [`std::fs::read`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// An open file.
#[derive(Debug)]
pub enum File {
    /// On the disk.
    Disk(std::fs::File),
    /// In memory.
    Memory(Cursor<Arc<[u8]>>),
}

impl File {
    /// True for a directory, which can be opened on some systems.
    ///
    /// # Errors
    /// Those of [`std::fs::File::metadata`].
    pub fn is_directory(&self) -> io::Result<bool> {
        match self {
            Self::Disk(file) => Ok(file.metadata()?.is_dir()),
            Self::Memory(_) => Ok(false),
        }
    }
}

impl Read for File {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Disk(file) => file.read(buffer),
            Self::Memory(file) => file.read(buffer),
        }
    }
}

impl Seek for File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::Disk(file) => file.seek(to),
            Self::Memory(file) => file.seek(to),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mounted_file_is_found_by_any_path_that_leads_to_it() {
        mount("rooms/tests-of-files/chair.txt", *b"chair");
        let path = Path::new("rooms/other/../tests-of-files/./chair.txt");
        assert_eq!(read(path).expect("mounted"), b"chair");
        assert_eq!(metadata(path).expect("mounted").bytes, 5);
        assert_eq!(canonicalize(path).expect("mounted"), Path::new("rooms/tests-of-files/chair.txt"));
        assert!(read(Path::new("../rooms/tests-of-files/chair.txt")).is_err());
    }

    #[test]
    fn new_contents_of_a_path_have_another_time() {
        let path = Path::new("tests-of-files-changed");
        mount(path, *b"one");
        let before = metadata(path).expect("mounted").modified;
        mount(path, *b"two");
        assert_ne!(metadata(path).expect("mounted").modified, before);
        assert_eq!(read(path).expect("mounted"), b"two");
    }
}
