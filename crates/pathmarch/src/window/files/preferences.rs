//! Preferences that persist between runs.
//!
//! They are stored as JSON in the user's preferences directory ([`AppDirs`](pathmarch_cli::AppDirs)). Unknown fields
//! are ignored and missing fields get defaults, so that older and newer versions can share the file. An unreadable file
//! is renamed to `preferences.json.bad` and replaced by defaults: preferences never keep the program from starting.

use crate::atomic_file::{SaveError, write_atomically};
use serde::{Deserialize, Serialize, Serializer};
use std::fs;
use std::path::{Path, PathBuf};

/// Maximum number of recent files.
pub const RECENT: usize = 12;
const FILE: &str = "preferences.json";

/// The preferences.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Dark theme; `None` follows the system.
    pub dark: Option<bool>,
    /// Zoom factor of text and widgets.
    pub scale: f32,
    /// Target frame rate while the view moves, frames per second.
    pub frame_rate: f32,
    /// Reconstruct clean pictures from few samples.
    pub reconstruct: bool,
    /// Show the scene tree.
    pub left_open: bool,
    /// Show the inspector.
    pub right_open: bool,
    /// Show the performance plots.
    pub show_plots: bool,
    /// Show the source editor.
    pub show_source: bool,
    /// Recent files, newest first. Names that are not Unicode are not stored.
    #[serde(serialize_with = "unicode_only")]
    pub recent: Vec<PathBuf>,
    /// File of the preferences; `None` if they are not stored.
    #[serde(skip)]
    file: Option<PathBuf>,
    /// Current content of the file.
    #[serde(skip)]
    saved: String,
    #[serde(skip)]
    notice: Option<String>,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            dark: None,
            scale: 1.0,
            frame_rate: 30.0,
            reconstruct: true,
            left_open: true,
            right_open: true,
            show_plots: false,
            show_source: false,
            recent: Vec::new(),
            file: None,
            saved: String::new(),
            notice: None,
        }
    }
}

fn unicode_only<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().filter_map(|path| path.to_str()))
}

impl Preferences {
    /// Loads preferences from a directory; falls back to the defaults.
    pub fn load_from(directory: &Path) -> Self {
        let file = directory.join(FILE);
        let mut this = match fs::read(&file) {
            Ok(bytes) => match serde_json::from_slice::<Self>(&bytes) {
                Ok(read) => Self { saved: String::from_utf8(bytes).unwrap_or_default(), ..read },
                Err(error) => Self { notice: Some(set_aside(&file, &error.to_string())), ..Self::default() },
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Self::default(),
            Err(error) => Self {
                notice: Some(format!("{}: cannot be read: {error}; using the defaults", file.display())),
                ..Self::default()
            },
        };
        this.file = Some(file);
        // Keep the window usable whatever the file contains.
        this.scale = this.scale.clamp(0.5, 4.0);
        this.frame_rate = this.frame_rate.clamp(1.0, 240.0);
        this.recent.truncate(RECENT);
        this
    }

    /// Message about a problem with the file, in one sentence.
    pub fn notice(&self) -> Option<&str> {
        self.notice.as_deref()
    }

    /// Saves the preferences if they have changed.
    ///
    /// # Errors
    /// Fails with [`SaveError`].
    pub fn save(&mut self) -> Result<(), SaveError> {
        let Some(file) = &self.file else { return Ok(()) };
        let other = |source: std::io::Error| SaveError::Other { path: file.clone(), source };
        let text = serde_json::to_string_pretty(self).map_err(|error| other(error.into()))? + "\n";
        if text == self.saved {
            return Ok(());
        }
        if let Some(directory) = file.parent() {
            fs::create_dir_all(directory).map_err(other)?;
        }
        write_atomically(file, text.as_bytes())?;
        self.saved = text;
        Ok(())
    }

    /// Adds a file to the recent files.
    pub fn opened(&mut self, path: &Path) {
        let path = fs::canonicalize(path).or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|recent| *recent != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }

    /// Removes a file from the recent files, e.g. one that was deleted.
    pub fn forget(&mut self, path: &Path) {
        self.recent.retain(|recent| recent != path);
    }
}

/// Renames an unreadable file, so that it is not overwritten; returns a message.
fn set_aside(file: &Path, reason: &str) -> String {
    let mut bad = file.as_os_str().to_owned();
    bad.push(".bad");
    match fs::rename(file, &bad) {
        Ok(()) => {
            format!("{}: is not valid: {reason}; renamed to {}, using the defaults", file.display(), bad.display())
        }
        Err(error) => {
            format!("{}: is not valid: {reason}; cannot be renamed: {error}; using the defaults", file.display())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_saved_and_loaded() {
        let directory = tempfile::tempdir().expect("a directory");
        let home = directory.path().join("not/made/yet");
        let mut first = Preferences::load_from(&home);
        assert_eq!(Preferences { file: None, ..first.clone() }, Preferences::default());
        first.dark = Some(true);
        first.show_plots = true;
        first.scale = 1.25;
        first.opened(&directory.path().join("a.kdl"));
        first.save().expect("saved");
        let second = Preferences::load_from(&home);
        assert_eq!(second, first);
        assert_eq!(second.notice(), None);
    }

    #[test]
    fn preferences_are_written_only_when_changed() {
        let directory = tempfile::tempdir().expect("a directory");
        let mut preferences = Preferences::load_from(directory.path());
        preferences.save().expect("saved");
        let file = directory.path().join(FILE);
        fs::remove_file(&file).expect("it was written");
        preferences.save().expect("saved");
        assert!(!file.exists(), "nothing changed");
        preferences.frame_rate = 60.0;
        preferences.save().expect("saved");
        assert!(file.exists());
        fs::remove_file(&file).expect("it was written");
        fs::create_dir(&file).expect("made");
        preferences.frame_rate = 24.0;
        assert!(matches!(preferences.save(), Err(SaveError::NotAFile { .. })));
    }

    #[test]
    fn preferences_load_whatever_the_file_contains() {
        let directory = tempfile::tempdir().expect("a directory");
        let file = directory.path().join(FILE);
        for bad in [&b"{"[..], b"", b"\xff", b"[1]", b"{\"scale\": null}", b"{\"recent\": 3}", b"{\"dark\": \"yes\"}"] {
            fs::write(&file, bad).expect("written");
            let preferences = Preferences::load_from(directory.path());
            assert!(preferences.notice().is_some_and(|notice| notice.contains(".bad")), "{bad:?}");
            assert_eq!(preferences.scale, 1.0);
            assert!(!file.exists());
            assert_eq!(fs::read(directory.path().join("preferences.json.bad")).expect("kept"), bad);
        }
        fs::write(&file, "{\"scale\": 1e30, \"frame_rate\": -5, \"of the future\": [1]}").expect("written");
        let preferences = Preferences::load_from(directory.path());
        assert_eq!(preferences.notice(), None);
        assert_eq!((preferences.scale, preferences.frame_rate), (4.0, 1.0));
    }

    #[test]
    fn recent_files_are_few_and_different() {
        let directory = tempfile::tempdir().expect("a directory");
        let mut preferences = Preferences::default();
        let path = |number: usize| directory.path().join(format!("{number}.kdl"));
        for number in 0..20 {
            fs::write(path(number), "").expect("written");
            preferences.opened(&path(number));
        }
        preferences.opened(&directory.path().join(".").join("15.kdl"));
        assert_eq!(preferences.recent.len(), RECENT);
        let names: Vec<_> = preferences.recent.iter().map(|path| path.file_stem().expect("a name")).collect();
        assert_eq!(names[..3], ["15", "19", "18"]);
        assert_eq!(names.iter().filter(|name| **name == "15").count(), 1);
        let newest = preferences.recent[0].clone();
        preferences.forget(&newest);
        assert!(!preferences.recent.contains(&newest));
    }

    #[cfg(unix)]
    #[test]
    fn names_that_are_not_unicode_are_skipped() {
        use std::os::unix::ffi::OsStringExt;
        let directory = tempfile::tempdir().expect("a directory");
        let mut preferences = Preferences::load_from(directory.path());
        preferences.opened(Path::new("/a.kdl"));
        preferences.opened(Path::new(&std::ffi::OsString::from_vec(b"/\xff.kdl".to_vec())));
        preferences.save().expect("saved");
        assert_eq!(Preferences::load_from(directory.path()).recent, [PathBuf::from("/a.kdl")]);
    }
}
