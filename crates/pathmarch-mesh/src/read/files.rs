//! Files with bounds on their size and place.

use super::ReadOptions;
use super::error::{Mistake, ReadError};
use crate::files;
use std::cell::RefCell;
use std::collections::HashMap;
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// Reads a whole file of at most the largest size.
pub(super) fn read_file(path: &Path, options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
    let failed = |source| ReadError::Open { path: path.to_owned(), source };
    let metadata = files::metadata(path).map_err(failed)?;
    // Opening a pipe would wait, and a device has no end.
    if !metadata.is_file {
        return Err(failed(std::io::Error::other("it is not a regular file")));
    }
    let limit = options.max_file_bytes;
    let mut bytes = Vec::with_capacity(metadata.bytes.min(limit) as usize);
    files::open(path).map_err(failed)?.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit {
        return Err(ReadError::TooLarge { path: path.to_owned(), limit });
    }
    Ok(bytes)
}

/// Access to the files beside a mesh file, such as buffers, images and material libraries. A file is read once, however
/// often it is named.
pub(super) struct Companions<'a> {
    directory: &'a Path,
    options: &'a ReadOptions,
    /// Contents by canonical path.
    read: RefCell<HashMap<PathBuf, Arc<[u8]>>>,
}

impl<'a> Companions<'a> {
    pub fn new(path: &'a Path, options: &'a ReadOptions) -> Self {
        Self { directory: path.parent().unwrap_or(Path::new("")), options, read: RefCell::default() }
    }

    /// Reads a file by its relative name.
    pub fn read(&self, name: &str, place: &str) -> Result<Arc<[u8]>, Mistake> {
        let refused = |problem: String| {
            Mistake::with_remedy(place, problem, "put the file beside the mesh and name it by a relative path")
        };
        let relative = PathBuf::from(name.replace('\\', "/"));
        let is_relative = relative.components().all(|part| !matches!(part, Component::RootDir | Component::Prefix(_)));
        if !is_relative || name.contains("://") || name.contains('\0') || name.is_empty() {
            return Err(refused(format!("\"{}\" is not a relative path", shortened(name))));
        }
        let path = self.directory.join(relative);
        let canonical = files::canonicalize(&path).unwrap_or_else(|_| path.clone());
        if let Some(bytes) = self.read.borrow().get(&canonical) {
            return Ok(bytes.clone());
        }
        let bytes: Arc<[u8]> = read_file(&path, self.options).map_err(|error| refused(error.to_string()))?.into();
        self.read.borrow_mut().insert(canonical, bytes.clone());
        Ok(bytes)
    }
}

/// The start of a text of a file, for messages.
pub(super) fn shortened(text: &str) -> String {
    const LENGTH: usize = 60;
    let printable = text.chars().take(LENGTH).map(|c| if c.is_control() { '\u{fffd}' } else { c });
    let start: String = printable.collect();
    if text.chars().nth(LENGTH).is_some() { start + "..." } else { start }
}
