//! Where the program keeps what it remembers from one run to the next: which folders, and how they are made.
//!
//! What is kept in them is the business of the rooms that keep it, and so are the names of the files.

use crate::files::reason;
use crate::lang::diagnostic::Diagnostic;
use directories::ProjectDirs;
use std::ffi::OsString;
use std::fs::DirBuilder;
use std::io::{self, ErrorKind};
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

/// Makes a folder that only its user can look into, with those above it; one that is there stays as it is.
pub(super) fn make_folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// The error that something cannot be kept in a file, with what can be done about it.
pub(super) fn cannot_keep(what: &str, path: &Path, error: &io::Error) -> Diagnostic {
    let name = path.display();
    let folder = path.parent().unwrap_or(path).display();
    let diagnostic = Diagnostic::error(format!("cannot keep {what} in `{name}`: {}", reason(error)));
    let kind = error.kind();
    if matches!(kind, ErrorKind::StorageFull | ErrorKind::QuotaExceeded) {
        diagnostic.help("what was kept there before is unharmed; make room")
    } else if matches!(kind, ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem) {
        diagnostic.help(format!("make `{folder}` writable, or name another folder in `{HOME_VARIABLE}`"))
    } else {
        diagnostic.help(format!("see that `{folder}` is a folder, or name another in `{HOME_VARIABLE}`"))
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

    #[cfg(unix)]
    #[test]
    fn folders_are_the_users_alone() {
        use std::os::unix::fs::PermissionsExt;
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("a/b");
        make_folder(&folder).unwrap();
        make_folder(&folder).unwrap();
        assert_eq!(std::fs::metadata(&folder).unwrap().permissions().mode() & 0o777, 0o700);
    }

    #[test]
    fn errors_say_what_helps() {
        let text = |kind: ErrorKind| {
            let error = cannot_keep("the settings", Path::new("/c/settings.toml"), &kind.into());
            format!("{}; {}", error.message(), error.hints().join(" "))
        };
        assert_eq!(
            text(ErrorKind::StorageFull),
            "cannot keep the settings in `/c/settings.toml`: the disk is full; what was kept there before is unharmed; make room"
        );
        assert!(text(ErrorKind::PermissionDenied).contains("make `/c` writable"));
        assert!(text(ErrorKind::NotADirectory).contains("see that `/c` is a folder"));
    }
}
