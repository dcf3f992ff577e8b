//! Where the program keeps what it remembers from one run to the next: which folders, and how they are made.
//!
//! What is kept in them is the business of the rooms that keep it, and so are the names of the files.

use crate::lang::diagnostic::Diagnostic;
use directories::ProjectDirs;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The environment variable that names a folder to be used instead of the platform's.
pub const HOME_VARIABLE: &str = "ILLUMINATOR_HOME";

/// The folders of what the program remembers. They need not exist: whoever writes makes them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// What the user chose: settings.
    pub configuration: PathBuf,
    /// What the user made and would miss on another machine.
    pub data: PathBuf,
    /// What the program noted by itself: recent files, unsaved texts.
    pub state: PathBuf,
}

impl Folders {
    /// The platform's folders for this user, or those below the folder that [`HOME_VARIABLE`] names.
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
            Diagnostic::error("there is no home folder to keep settings, recent files and unsaved texts in")
                .help(format!("set `HOME`, or name a folder in `{HOME_VARIABLE}`"))
        })?;
        Ok(Folders {
            configuration: project.config_dir().to_owned(),
            data: project.data_dir().to_owned(),
            // Not every platform tells state from data.
            state: project.state_dir().unwrap_or(project.data_local_dir()).to_owned(),
        })
    }

    /// All three below one folder.
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
