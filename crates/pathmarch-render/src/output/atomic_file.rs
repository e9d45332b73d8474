//! Atomic writes: a file is written under a temporary name beside the target, and renamed when it is complete.

use std::io;
use std::path::Path;
use tempfile::NamedTempFile;

/// Directory of a file.
pub(crate) fn directory(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Creates an empty file beside `path`, to be written and then persisted as `path`. Dropping it removes it.
///
/// # Errors
/// If it cannot be created, or `path` is a directory.
pub(crate) fn beside(path: &Path) -> io::Result<NamedTempFile> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&name).suffix(".part");
    #[cfg(unix)]
    {
        // The umask applies, as for any new file; tempfile's default is private to the user.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(directory(path))
}
