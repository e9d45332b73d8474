//! Directory listings and typed paths.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;

/// A file or directory of a listing.
#[derive(Clone, Debug)]
pub struct Entry {
    /// File name.
    pub name: OsString,
    /// Displayed name; that of a directory ends in a slash.
    pub label: String,
    /// A directory, or a link to one.
    pub is_directory: bool,
    /// Size of a file, bytes.
    pub size: Option<u64>,
    /// Modification time of a file.
    pub modified: Option<SystemTime>,
}

/// Lists a directory without hidden files: directories first, then by name, ignoring case.
///
/// # Errors
/// Fails with a message of one sentence.
pub fn read(directory: &Path) -> Result<Vec<Entry>, String> {
    let entries = fs::read_dir(directory).map_err(|error| {
        let reason = match error.kind() {
            ErrorKind::NotFound => "does not exist".to_owned(),
            ErrorKind::PermissionDenied => "cannot be opened: permission denied".to_owned(),
            ErrorKind::NotADirectory => "is not a directory".to_owned(),
            _ => format!("cannot be listed: {error}"),
        };
        format!("{} {reason}", directory.display())
    })?;
    let mut list: Vec<Entry> = entries.filter_map(|entry| describe(&entry.ok()?)).collect();
    list.sort_by_cached_key(|entry| (!entry.is_directory, entry.label.to_lowercase(), entry.name.clone()));
    Ok(list)
}

fn describe(entry: &fs::DirEntry) -> Option<Entry> {
    let name = entry.file_name();
    if name.as_encoded_bytes().starts_with(b".") {
        return None;
    }
    // For a broken link, use the metadata of the link itself.
    let data = fs::metadata(entry.path()).or_else(|_| entry.metadata()).ok();
    #[cfg(windows)]
    if data.as_ref().is_some_and(|data| std::os::windows::fs::MetadataExt::file_attributes(data) & 2 != 0) {
        return None;
    }
    let is_directory = data.as_ref().is_some_and(fs::Metadata::is_dir);
    // A line break in a name would split the row.
    let mut label = name.to_string_lossy().replace(char::is_control, "\u{fffd}");
    if is_directory {
        label.push('/');
    }
    let file = data.filter(|_| !is_directory);
    let size = file.as_ref().map(fs::Metadata::len);
    let modified = file.and_then(|file| file.modified().ok());
    Some(Entry { name, label, is_directory, size, modified })
}

/// Returns true if the name has one of the extensions, ignoring case, or if there are none.
pub fn has_extension(name: &OsStr, extensions: &[&str]) -> bool {
    let extension = Path::new(name).extension();
    extensions.is_empty() || extension.is_some_and(|found| extensions.iter().any(|one| found.eq_ignore_ascii_case(one)))
}

/// Adds the first extension to a name that has none of them.
pub fn with_extension(name: &OsStr, extensions: &[&str]) -> OsString {
    let mut name = name.to_owned();
    if !has_extension(&name, extensions)
        && let Some(first) = extensions.first()
    {
        if !name.as_encoded_bytes().ends_with(b".") {
            name.push(".");
        }
        name.push(first);
    }
    name
}

/// Resolves a typed path relative to `directory`; `~` is the home directory.
pub fn resolve(directory: &Path, typed: &str) -> PathBuf {
    let typed = typed.trim();
    let home = || directories::BaseDirs::new().map(|system| system.home_dir().to_owned());
    let path = match typed.strip_prefix('~') {
        Some(rest) if rest.is_empty() || rest.starts_with(std::path::is_separator) => {
            home().map(|home| home.join(rest.trim_start_matches(std::path::is_separator)))
        }
        _ => None,
    };
    let path = directory.join(path.unwrap_or_else(|| typed.into()));
    // Only the system can resolve `..` after a symbolic link.
    match fs::canonicalize(&path) {
        Ok(real) if path.components().any(|part| part == Component::ParentDir) => real,
        // Removes `.` and doubled separators.
        _ => path.components().collect(),
    }
}

/// Formats a size as "340 B", "1.2 kB" or "35 MB".
pub fn size_text(bytes: u64) -> String {
    let mut size = bytes as f64;
    for unit in ["B", "kB", "MB", "GB"] {
        if size < 999.5 {
            let digits = usize::from(unit != "B" && size < 9.95);
            return format!("{size:.digits$} {unit}");
        }
        size /= 1000.0;
    }
    format!("{size:.0} TB")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directories_come_first_and_hidden_files_not_at_all() {
        let directory = tempfile::tempdir().expect("a directory");
        for name in ["b.kdl", "A.kdl", ".hidden.kdl", "c.txt"] {
            fs::write(directory.path().join(name), name).expect("written");
        }
        for name in ["z", "Y", ".git"] {
            fs::create_dir(directory.path().join(name)).expect("made");
        }
        let list = read(directory.path()).expect("a list");
        let labels: Vec<_> = list.iter().map(|entry| entry.label.as_str()).collect();
        assert_eq!(labels, ["Y/", "z/", "A.kdl", "b.kdl", "c.txt"]);
        assert_eq!((list[2].size, list[0].size), (Some(5), None));
        assert!(list[2].modified.is_some());
        for missing in ["no", "b.kdl"] {
            let message = read(&directory.path().join(missing)).expect_err("no directory");
            assert!(message.contains(missing), "{message}");
        }
    }

    #[test]
    fn extensions_are_known_and_added() {
        let pictures = ["png", "exr", "jpg"];
        for (name, with) in [
            ("a", "a.png"),
            ("a.", "a.png"),
            ("a.PNG", "a.PNG"),
            ("a.exr", "a.exr"),
            ("scene.v2", "scene.v2.png"),
            (".png", ".png.png"),
        ] {
            assert_eq!(with_extension(OsStr::new(name), &pictures), with);
        }
        assert_eq!(with_extension(OsStr::new("a"), &[]), "a");
        assert!(has_extension(OsStr::new("a"), &[]) && !has_extension(OsStr::new("kdl"), &["kdl"]));
    }

    #[test]
    fn typed_paths_are_understood() {
        let directory = tempfile::tempdir().expect("a directory");
        let here = fs::canonicalize(directory.path()).expect("there");
        fs::create_dir(here.join("sub")).expect("made");
        assert_eq!(resolve(&here, " sub/ "), here.join("sub"));
        assert_eq!(resolve(&here.join("sub"), ".."), here);
        assert_eq!(resolve(&here, "./sub//a.kdl"), here.join("sub/a.kdl"));
        assert_eq!(resolve(&here, &here.join("x").to_string_lossy()), here.join("x"));
        assert_eq!(resolve(&here, ""), here);
        assert_eq!(resolve(&here, "~x"), here.join("~x"));
        if let Some(system) = directories::BaseDirs::new() {
            assert_eq!(resolve(&here, "~/a"), system.home_dir().join("a"));
            assert_eq!(resolve(&here, "~"), system.home_dir());
        }
    }

    #[test]
    fn sizes_read_well() {
        for (bytes, text) in [
            (0, "0 B"),
            (999, "999 B"),
            (1000, "1.0 kB"),
            (12_345, "12 kB"),
            (999_600, "1.0 MB"),
            (u64::MAX, "18446744 TB"),
        ] {
            assert_eq!(size_text(bytes), text);
        }
    }
}
