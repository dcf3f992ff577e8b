//! Where the materials of a formula are: which file its `#uses` means, and what is built in.

use crate::lang::diagnostic::Diagnostic;
use crate::workspace::location::{Location, unknown_preset};
use crate::workspace::{FileKind, presets};
use std::fmt;
use std::path::{Path, PathBuf};

/// Where the materials of a formula are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The name of the built-in library, which nothing is saved to.
    built_in: Option<String>,
    /// The file that is read where it exists, and saved to. None where the platform has no folder for it.
    file: Option<PathBuf>,
}

impl Place {
    /// The place that `#uses` of the formula at a location names. A formula that is nowhere yet has no folder of its own.
    ///
    /// A path is looked up from the formula's folder, then from the working directory; a file that is in neither is to be made in
    /// the first. `preset:NAME` is a built-in library; what is saved for it, and what is saved for a built-in formula whose path
    /// leads nowhere, goes to the `data` folder.
    ///
    /// # Errors
    /// Why materials are off: nothing is named, or no library that is built in.
    pub fn of(uses: Option<&str>, formula: Option<&Location>, data: Option<&Path>) -> Result<Place, Diagnostic> {
        let Some(uses) = uses else { return Err(off()) };
        let kept = |name: &Path| data.map(|data| data.join("materials").join(name));
        let path = match Location::new(uses) {
            Location::Preset(name) if presets::text(FileKind::Material, &name).is_none() => {
                return Err(unknown_preset(FileKind::Material, &name));
            }
            Location::Preset(name) => {
                let file = kept(Path::new(&format!("{name}.toml")));
                return Ok(Place { built_in: Some(name), file });
            }
            Location::File(path) => path,
        };
        // What cannot be looked at is there: reading it says why.
        let exists = |path: &Path| path.try_exists().unwrap_or(true);
        let file = match formula {
            Some(Location::File(formula)) => {
                let beside = formula.parent().unwrap_or(Path::new("")).join(&path);
                if !exists(&beside) && exists(&path) { Some(path) } else { Some(beside) }
            }
            // Nothing is beside a formula that is built in.
            Some(Location::Preset(_)) if !exists(&path) => match path.file_name() {
                Some(name) => kept(Path::new(name)),
                None => Some(path),
            },
            Some(Location::Preset(_)) | None => Some(path),
        };
        Ok(Place { built_in: None, file })
    }

    /// The name of the built-in library, if it is one.
    pub fn built_in(&self) -> Option<&str> {
        self.built_in.as_deref()
    }

    /// The file that materials are saved to; it may not exist yet. None where the platform has no folder for it.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.built_in, &self.file) {
            (Some(name), _) => write!(f, "`{}`", Location::Preset(name.clone())),
            (None, Some(file)) => write!(f, "`{}`", file.display()),
            (None, None) => write!(f, "the material library"),
        }
    }
}

/// Why a formula without `#uses` has no materials.
fn off() -> Diagnostic {
    Diagnostic::error("materials are off: the formula names no file for them").help(
        "write `#uses FILE;` at its top, such as `#uses materials.toml;`; a file that does not exist is made when a material is saved",
    )
}
