//! The folders for what the program keeps between runs.
//!
//! The modules that keep something there know the names of their files.

use crate::lang::diagnostic::Diagnostic;
use directories::ProjectDirs;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The environment variable that names a folder to use instead of the platform's.
pub const HOME_VARIABLE: &str = "ILLUMINATOR_HOME";

/// The folders for user data. They need not exist; they are created when something is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// For what the user chose: settings.
    pub configuration: PathBuf,
    /// For what the user made: materials.
    pub data: PathBuf,
    /// For what the program records: recent files and drafts.
    pub state: PathBuf,
}

impl Folders {
    /// The platform's folders for this user, or the folders in the one that [`HOME_VARIABLE`] names.
    ///
    /// # Errors
    /// The user has no home.
    pub fn platform() -> Result<Folders, Diagnostic> {
        Self::chosen(std::env::var_os(HOME_VARIABLE))
    }

    fn chosen(home: Option<OsString>) -> Result<Folders, Diagnostic> {
        if let Some(home) = home.filter(|home| !home.is_empty()) {
            let home = PathBuf::from(home);
            return Ok(Self::below(&std::path::absolute(&home).unwrap_or(home)));
        }
        let project = ProjectDirs::from("", "", "illuminator").ok_or_else(|| {
            Diagnostic::error("there is no home folder for settings, recent files and drafts")
                .help(format!("set `HOME`, or name a folder in `{HOME_VARIABLE}`"))
        })?;
        Ok(Folders {
            configuration: project.config_dir().to_owned(),
            data: project.data_dir().to_owned(),
            // Some platforms have no separate folder for state.
            state: project.state_dir().unwrap_or(project.data_local_dir()).to_owned(),
        })
    }

    /// Three folders in one.
    pub fn below(home: &Path) -> Folders {
        Folders { configuration: home.join("configuration"), data: home.join("data"), state: home.join("state") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_folder_takes_the_place_of_the_platforms() {
        let folders = Folders::chosen(Some("/some/where".into())).unwrap();
        assert_eq!(folders, Folders::below(Path::new("/some/where")));
        assert!(folders.configuration.starts_with("/some/where"));
        let relative = Folders::chosen(Some("here".into())).unwrap();
        assert!(relative.state.is_absolute(), "{relative:?}");
        assert_eq!(Folders::chosen(Some("".into())), Folders::chosen(None));
    }
}
