//! Reading of scene files as text.

use crate::diagnostic::SceneError;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Largest scene file, bytes.
pub(crate) const MAX_BYTES: usize = 16 << 20;

/// Reason for refusing a larger file, and help.
pub(crate) fn too_large() -> (String, String) {
    (format!("it is larger than {} MiB", MAX_BYTES >> 20), "Leave parts of the scene out.".to_owned())
}

/// Reads the text of the scene file at `path`, unchanged.
///
/// # Errors
/// [`SceneError::Unreadable`] as for [`Scene::load`](crate::Scene::load).
pub fn read_text(path: &Path) -> Result<String, SceneError> {
    read(path).map_err(|(reason, help)| SceneError::Unreadable { name: path.display().to_string(), reason, help })
}

/// Reads a text file of another program. One that is not UTF-8 is read as Latin-1, which the flag beside the text reports.
///
/// # Errors
/// [`SceneError::Unreadable`] as for [`Scene::load`](crate::Scene::load).
pub fn read_foreign_text(path: &Path) -> Result<(String, bool), SceneError> {
    let bytes = read_bytes(path).map_err(|(reason, help)| SceneError::Unreadable {
        name: path.display().to_string(),
        reason,
        help,
    })?;
    Ok(match String::from_utf8(bytes) {
        Ok(text) => (text, false),
        Err(error) => (error.as_bytes().iter().map(|&byte| char::from(byte)).collect(), true),
    })
}

/// Reads the text of a file. The error is the reason and the help.
fn read(path: &Path) -> Result<String, (String, String)> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count();
        (format!("it is not UTF-8 text (line {line}, byte {at})"), "Save it as UTF-8.".to_owned())
    })
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, (String, String)> {
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => ("there is no such file".to_owned(), "Check the path.".to_owned()),
        ErrorKind::PermissionDenied => ("reading it is not permitted".to_owned(), "Check its permissions.".to_owned()),
        _ => (error.to_string(), "Check the path.".to_owned()),
    };
    let file = pathmarch_mesh::files::open(path).map_err(failed)?;
    if file.is_directory().map_err(failed)? {
        return Err(("it is a directory".to_owned(), "Name a .kdl file in it.".to_owned()));
    }
    let mut bytes = Vec::new();
    // Reading one byte more than allowed detects a larger file, whatever its metadata claim.
    file.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() > MAX_BYTES {
        return Err(too_large());
    }
    Ok(bytes)
}
