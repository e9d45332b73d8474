//! Directories of the program's own files.
//!
//! Those that the system has for this, or, where the environment variable `PATHMARCH_HOME` is set, that one
//! directory for everything: for tests, and for an installation that is carried around.

use directories::ProjectDirs;
use std::ffi::OsString;
use std::path::PathBuf;

/// The environment variable that names the one directory for everything.
pub const HOME_VARIABLE: &str = "PATHMARCH_HOME";

/// The program's own directories; none need exist.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AppDirs {
    /// For preferences.
    pub preferences: PathBuf,
    /// For work that is not saved.
    pub recovery: PathBuf,
    /// For converged pictures that others are measured against; they can be made again.
    pub references: PathBuf,
}

impl AppDirs {
    /// Directories of this user; `None` where the user has no home directory.
    pub fn of_user() -> Option<Self> {
        Self::with_home(std::env::var_os(HOME_VARIABLE))
    }

    fn with_home(home: Option<OsString>) -> Option<Self> {
        if let Some(home) = home.filter(|home| !home.is_empty()) {
            let home = PathBuf::from(home);
            let (recovery, references) = (home.join("recovery"), home.join("references"));
            return Some(Self { preferences: home, recovery, references });
        }
        let system = ProjectDirs::from("org", "pathmarch", "pathmarch")?;
        Some(Self {
            preferences: system.config_dir().to_owned(),
            recovery: system.data_local_dir().join("recovery"),
            references: system.cache_dir().join("references"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_directory_can_stand_for_all() {
        let dirs = AppDirs::with_home(Some("/somewhere/own".into())).expect("directories");
        assert_eq!(dirs.preferences, PathBuf::from("/somewhere/own"));
        assert_eq!(dirs.recovery, PathBuf::from("/somewhere/own").join("recovery"));
        assert_eq!(dirs.references, PathBuf::from("/somewhere/own").join("references"));
        let system = AppDirs::with_home(None);
        assert_ne!(system.as_ref(), Some(&dirs));
        assert_eq!(AppDirs::with_home(Some(OsString::new())), system, "empty is as if not set");
    }
}
