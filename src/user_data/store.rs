//! What all files of user data need: creating their folder, and errors for files that cannot be written.

use crate::files::reason;
use crate::lang::diagnostic::Diagnostic;
use crate::user_data::folders::HOME_VARIABLE;
use std::fs::DirBuilder;
use std::io::{self, ErrorKind};
use std::path::Path;

/// Creates a folder that only its user can look into, with its parents. An existing folder stays as it is.
pub(super) fn create_folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// The error that something cannot be saved in a file, with a hint at what helps.
pub(super) fn cannot_save(what: &str, path: &Path, error: &io::Error) -> Diagnostic {
    let name = path.display();
    let folder = path.parent().unwrap_or(path).display();
    let diagnostic = Diagnostic::error(format!("cannot save {what} in `{name}`: {}", reason(error)));
    let kind = error.kind();
    if matches!(kind, ErrorKind::StorageFull | ErrorKind::QuotaExceeded) {
        diagnostic.help("what was saved there before is unchanged; free some space")
    } else if matches!(kind, ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem) {
        diagnostic.help(format!("make `{folder}` writable, or name another folder in `{HOME_VARIABLE}`"))
    } else {
        diagnostic.help(format!("make sure that `{folder}` is a folder, or name another one in `{HOME_VARIABLE}`"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn folders_are_the_users_alone() {
        use std::os::unix::fs::PermissionsExt;
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("a/b");
        create_folder(&folder).unwrap();
        create_folder(&folder).unwrap();
        assert_eq!(std::fs::metadata(&folder).unwrap().permissions().mode() & 0o777, 0o700);
    }

    #[test]
    fn errors_say_what_helps() {
        let text = |kind: ErrorKind| {
            let error = cannot_save("the settings", Path::new("/c/settings.toml"), &kind.into());
            format!("{}; {}", error.message(), error.hints().join(" "))
        };
        assert_eq!(
            text(ErrorKind::StorageFull),
            "cannot save the settings in `/c/settings.toml`: the disk is full; what was saved there before is unchanged; free some space"
        );
        assert!(text(ErrorKind::PermissionDenied).contains("make `/c` writable"));
        assert!(text(ErrorKind::NotADirectory).contains("make sure that `/c` is a folder"));
    }
}
