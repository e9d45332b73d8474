//! Where the program keeps its own files.
//!
//! The directories that the system has for this, or, where the environment variable `PATHMARCH_HOME` is set, that one
//! directory for everything: for tests, and for an installation that is carried around.

use directories::ProjectDirs;
use std::ffi::OsString;
use std::path::PathBuf;

/// The environment variable that names the one directory for everything.
pub const HOME_VARIABLE: &str = "PATHMARCH_HOME";

/// The program's own directories; none need exist.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Places {
    /// For preferences.
    pub preferences: PathBuf,
    /// For work that is not saved.
    pub recovery: PathBuf,
    /// For converged pictures that others are measured against; they can be made again.
    pub references: PathBuf,
}

impl Places {
    /// Those of this user; none where the user has no home directory.
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
        let places = Places::with_home(Some("/somewhere/own".into())).expect("places");
        assert_eq!(places.preferences, PathBuf::from("/somewhere/own"));
        assert_eq!(places.recovery, PathBuf::from("/somewhere/own").join("recovery"));
        assert_eq!(places.references, PathBuf::from("/somewhere/own").join("references"));
        let system = Places::with_home(None);
        assert_ne!(system.as_ref(), Some(&places));
        assert_eq!(Places::with_home(Some(OsString::new())), system, "empty is as if not set");
    }
}
