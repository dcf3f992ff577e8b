//! The materials of a formula: the built-in ones, overlaid with those that the user saved.

use crate::files::{Readable, reason};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::display_text::one_line;
use crate::lang::source::Source;
use crate::workspace::materials::{Library, LibraryLocation, Material, unknown_material};
use crate::workspace::session::Session;
use crate::workspace::spanned_toml;
use crate::workspace::{FileKind, Location, kind_of, read_source};
use std::fmt;
use std::path::Path;

/// Diagnostics with the text that they refer to. The text is empty if they refer to none.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceDiagnostics {
    /// The text.
    pub source: Source,
    /// The diagnostics.
    pub diagnostics: Diagnostics,
}

impl SourceDiagnostics {
    fn without_text(diagnostic: Diagnostic) -> Self {
        Self { source: Source::new("", ""), diagnostics: diagnostic.into() }
    }
}

impl fmt::Display for SourceDiagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.diagnostics.located(&self.source), f)
    }
}

/// A library with its text.
#[derive(Debug, Clone, PartialEq)]
struct Layer {
    library: Library,
    source: Source,
}

/// The materials of a formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    location: LibraryLocation,
    built_in: Layer,
    own: Layer,
    /// The built-in library, overlaid with the user's.
    all: Library,
}

impl Materials {
    /// Reads the materials at a location. Returns them with warnings. A file that does not exist is an empty library.
    ///
    /// # Errors
    /// The file exists and cannot be read, is not of an allowed file type, or is not a library.
    pub fn open(location: LibraryLocation, readable: Readable) -> Result<(Materials, SourceDiagnostics), SourceDiagnostics> {
        let built_in = match location.built_in() {
            Some(name) => {
                let location = Location::Preset(name.to_owned());
                Layer::parse(location.read(FileKind::Material, readable).map_err(SourceDiagnostics::without_text)?)?.0
            }
            None => Layer::empty(""),
        };
        let (own, warnings) = match location.file() {
            Some(path) => Layer::read(path, readable)?,
            None => (Layer::empty(""), Diagnostics::new()),
        };
        let found = SourceDiagnostics { source: own.source.clone(), diagnostics: warnings };
        let all = merged(&built_in.library, &own.library);
        Ok((Materials { location, built_in, own, all }, found))
    }

    /// Where the materials are.
    pub fn location(&self) -> &LibraryLocation {
        &self.location
    }

    /// All materials: the built-in ones, each replaced by the user's of the same name if there is one, then the other
    /// materials of the user.
    pub fn library(&self) -> &Library {
        &self.all
    }

    /// The material of this name.
    pub fn get(&self, name: &str) -> Option<&Material> {
        self.all.get(name)
    }

    /// Whether the material of this name is built in, so it cannot be deleted. The user can replace it.
    pub fn is_built_in(&self, name: &str) -> bool {
        self.own.library.get(name).is_none() && self.built_in.library.get(name).is_some()
    }

    /// The text that the spans in the material of this name refer to.
    pub fn source_of(&self, name: &str) -> &Source {
        if self.is_built_in(name) { &self.built_in.source } else { &self.own.source }
    }

    /// Adds a material, or replaces the one of the same name, and saves. The file is read again first, so what other
    /// programs saved is kept.
    ///
    /// # Errors
    /// The file cannot be read, is no longer a library, or cannot be written. The file and these materials are then
    /// unchanged.
    pub fn put(&mut self, material: Material) -> Result<(), SourceDiagnostics> {
        self.change(|library| {
            library.put(material);
            Ok(())
        })
    }

    /// Deletes a material and saves. If it replaced a built-in one, that one is there again.
    ///
    /// # Errors
    /// There is no such material, or it is built in; otherwise as for [`put`](Self::put).
    pub fn remove(&mut self, name: &str) -> Result<(), SourceDiagnostics> {
        let built_in = self.built_in.library.get(name).is_some();
        let missing = unknown_material(name, &self.all, &self.location);
        self.change(|library| match library.remove(name) {
            Some(_) => Ok(()),
            None if built_in => Err(Diagnostic::error(format!("the material `{name}` is built in and cannot be deleted"))),
            None => Err(Diagnostic::error(missing)),
        })
    }

    /// Changes the user's library and its file.
    fn change(&mut self, change: impl FnOnce(&mut Library) -> Result<(), Diagnostic>) -> Result<(), SourceDiagnostics> {
        let Some(path) = self.location.file() else {
            let message = format!("materials for {} cannot be saved: there is no folder for data of this user", self.location);
            return Err(SourceDiagnostics::without_text(
                Diagnostic::error(message).help("name a file of your own after `#uses`"),
            ));
        };
        let (Layer { mut library, .. }, _) = Layer::read(path, Readable::Regular)?;
        change(&mut library).map_err(SourceDiagnostics::without_text)?;
        library.save(path).map_err(|error| {
            let message = format!("cannot write the material library `{}`: {}", path.display(), reason(&error));
            SourceDiagnostics::without_text(Diagnostic::error(message).help("the file is unchanged"))
        })?;
        // The new text has other spans.
        self.own = Layer::read(path, Readable::Regular)?.0;
        self.all = merged(&self.built_in.library, &self.own.library);
        Ok(())
    }
}

impl Layer {
    fn empty(name: &str) -> Self {
        Self { library: Library::default(), source: Source::new(name, "") }
    }

    fn parse(source: Source) -> Result<(Self, Diagnostics), SourceDiagnostics> {
        match Library::parse(&source) {
            Ok((library, warnings)) => Ok((Self { library, source }, warnings)),
            Err(diagnostics) => Err(match another_kind(&source) {
                Some(mistake) => SourceDiagnostics::without_text(mistake),
                None => SourceDiagnostics { source, diagnostics },
            }),
        }
    }

    /// The library of a file; empty if there is no such file.
    fn read(path: &Path, readable: Readable) -> Result<(Self, Diagnostics), SourceDiagnostics> {
        if !path.try_exists().unwrap_or(true) {
            return Ok((Self::empty(&path.display().to_string()), Diagnostics::new()));
        }
        let source = read_source(path, Some(FileKind::Material), readable).map_err(SourceDiagnostics::without_text)?;
        let (layer, warnings) = Self::parse(source)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let library = layer.library.with_values(|value| value.taken_from(folder));
        Ok((Self { library, ..layer }, warnings))
    }
}

/// The one mistake about a text with mistakes that was never meant as a library.
fn another_kind(source: &Source) -> Option<Diagnostic> {
    let name = one_line(source.name());
    let what = match kind_of(source.text()) {
        Some(kind @ (FileKind::Formula | FileKind::Scene)) => Some(kind),
        Some(FileKind::Session) if Session::parse(source).is_ok() => Some(FileKind::Session),
        Some(FileKind::Session | FileKind::Material) => return None,
        None if source.text().trim_start().starts_with(['"', '\'']) || spanned_toml::parse(source).is_ok() => return None,
        None => None,
    };
    let message = match what {
        Some(kind) => format!("`{name}` is a {}, not a material library", kind.noun()),
        None => format!("`{name}` is not a material library"),
    };
    Some(
        Diagnostic::error(message)
            .help("a library is a TOML file with a table for each material: `[gold]`, then values such as `kr = 0.3`"),
    )
}

/// The materials of both libraries. Of two materials with one name, the second library's counts.
fn merged(lower: &Library, upper: &Library) -> Library {
    let mut all = lower.clone();
    upper.iter().for_each(|material| {
        all.put(material.clone());
    });
    all
}
