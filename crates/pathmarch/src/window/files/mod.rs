//! Files of the window: atomic writes, file watching, crash recovery, preferences.

pub(crate) mod file_watcher;
pub(crate) mod preferences;
pub(crate) mod recovery;
pub(crate) mod relative_time;
