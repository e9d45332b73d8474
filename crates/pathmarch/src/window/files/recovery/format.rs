//! Format of recovery files.
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

use crate::atomic_file::write_atomically;
use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

pub(super) const FIRST_LINE: &str = "// pathmarch: work that was not saved";
pub(super) const LAST_LINE: &str = "// text:";

/// Work to store.
#[derive(Clone, PartialEq)]
pub(super) struct UnsavedWork {
    /// File of the scene.
    pub(super) scene_path: Option<PathBuf>,
    pub(super) text: String,
    /// Text of the file version that the work is based on.
    pub(super) base: Option<String>,
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
}

pub(super) fn write(
    file: &Path,
    UnsavedWork { scene_path, text, base }: &UnsavedWork,
    at: SystemTime,
) -> Result<(), String> {
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

pub(super) fn read(file: PathBuf) -> RecoveredWork {
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
