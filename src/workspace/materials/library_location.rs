//! Where the materials of a formula are: the file that its `#uses` means, and the built-in library.

use crate::lang::diagnostic::Diagnostic;
use crate::workspace::location::{Location, unknown_preset};
use crate::workspace::{FileKind, presets};
use std::fmt;
use std::path::{Path, PathBuf};

/// Where the materials of a formula are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LibraryLocation {
    /// The name of the built-in library. Nothing is saved to it.
    built_in: Option<String>,
    /// The file that is read if it exists, and that materials are saved to. `None` if the platform has no folder for
    /// it.
    file: Option<PathBuf>,
}

impl LibraryLocation {
    /// Finds the library that the `#uses` of a formula names. `formula` is the formula's location; `None` for a
    /// formula that is not in a file.
    ///
    /// A path is relative to the formula's folder. If there is no such file, it is relative to the working directory.
    /// If there is none either, the file will be created in the formula's folder. `preset:NAME` is a built-in library.
    /// What is saved for a built-in library, and for a built-in formula whose path leads nowhere, goes to the `data`
    /// folder.
    ///
    /// # Errors
    /// The formula names no library, or a built-in library that does not exist. The error says that materials are off.
    pub fn find(uses: Option<&str>, formula: Option<&Location>, data: Option<&Path>) -> Result<LibraryLocation, Diagnostic> {
        let Some(uses) = uses else { return Err(off()) };
        let kept = |name: &Path| data.map(|data| data.join("materials").join(name));
        let path = match Location::new(uses) {
            Location::Preset(name) if presets::text(FileKind::Material, &name).is_none() => {
                return Err(unknown_preset(Some(FileKind::Material), &name));
            }
            Location::Preset(name) => {
                let file = kept(Path::new(&format!("{name}.toml")));
                return Ok(LibraryLocation { built_in: Some(name), file });
            }
            Location::File(path) => path,
        };
        // A path that cannot be examined counts as existing: reading it gives the reason.
        let exists = |path: &Path| path.try_exists().unwrap_or(true);
        let file = match formula {
            Some(Location::File(formula)) => {
                let beside = formula.parent().unwrap_or(Path::new("")).join(&path);
                if !exists(&beside) && exists(&path) { Some(path) } else { Some(beside) }
            }
            // A built-in formula has no folder.
            Some(Location::Preset(_)) if !exists(&path) => match path.file_name() {
                Some(name) => kept(Path::new(name)),
                None => Some(path),
            },
            Some(Location::Preset(_)) | None => Some(path),
        };
        Ok(LibraryLocation { built_in: None, file })
    }

    /// The name of the built-in library, if there is one.
    pub fn built_in(&self) -> Option<&str> {
        self.built_in.as_deref()
    }

    /// The file that materials are saved to, which may not exist yet. `None` if the platform has no folder for it.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }
}

impl fmt::Display for LibraryLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.built_in, &self.file) {
            (Some(name), _) => write!(f, "`{}`", Location::Preset(name.clone())),
            (None, Some(file)) => write!(f, "`{}`", file.display()),
            (None, None) => write!(f, "the material library"),
        }
    }
}

/// The error that a formula without `#uses` has no materials.
fn off() -> Diagnostic {
    Diagnostic::error("materials are off: the formula names no file for them").help(
        "write `#uses FILE;` at its top, such as `#uses materials.toml;`; a file that does not exist is made when a material is saved",
    )
}
