//! Files: written as a whole, watched, recovered after a crash, remembered.

pub(crate) mod atomic_file;
pub(crate) mod file_watcher;
pub(crate) mod preferences;
pub(crate) mod recovery;
pub(crate) mod relative_time;
