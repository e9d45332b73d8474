//! Directories for preferences, recovery files and references.
//!
//! They are the system's standard directories, or subdirectories of the one that the environment variable
//! `PATHMARCH_HOME` names, for tests and portable installations.

use directories::ProjectDirs;
use std::ffi::OsString;
use std::path::PathBuf;

/// Environment variable that names one directory for everything.
pub const HOME_VARIABLE: &str = "PATHMARCH_HOME";

/// Directories of the program; they need not exist.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AppDirs {
    /// Preferences.
    pub preferences: PathBuf,
    /// Recovery files of unsaved work.
    pub recovery: PathBuf,
    /// Converged reference pictures; they can be rendered again.
    pub references: PathBuf,
    /// Distance fields of meshes; they can be built again.
    pub meshes: PathBuf,
}

impl AppDirs {
    /// Directories of the current user; `None` if there is no home directory.
    pub fn of_user() -> Option<Self> {
        Self::with_home(std::env::var_os(HOME_VARIABLE))
    }

    fn with_home(home: Option<OsString>) -> Option<Self> {
        if let Some(home) = home.filter(|home| !home.is_empty()) {
            let home = PathBuf::from(home);
            let [recovery, references, meshes] = ["recovery", "references", "meshes"].map(|name| home.join(name));
            return Some(Self { preferences: home, recovery, references, meshes });
        }
        let system = ProjectDirs::from("org", "pathmarch", "pathmarch")?;
        Some(Self {
            preferences: system.config_dir().to_owned(),
            recovery: system.data_local_dir().join("recovery"),
            references: system.cache_dir().join("references"),
            meshes: system.cache_dir().join("meshes"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_directory_can_replace_all() {
        let dirs = AppDirs::with_home(Some("/somewhere/own".into())).expect("directories");
        assert_eq!(dirs.preferences, PathBuf::from("/somewhere/own"));
        assert_eq!(dirs.recovery, PathBuf::from("/somewhere/own").join("recovery"));
        assert_eq!(dirs.references, PathBuf::from("/somewhere/own").join("references"));
        let system = AppDirs::with_home(None);
        assert_ne!(system.as_ref(), Some(&dirs));
        assert_eq!(AppDirs::with_home(Some(OsString::new())), system, "empty is as if not set");
    }
}
