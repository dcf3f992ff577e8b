//! The materials of a formula as users have them: what is built in, and over it what was saved.

use crate::files::{Readable, reason};
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::workspace::materials::{Library, Material, Place, unknown};
use crate::workspace::{FileKind, Location, read_source};
use std::fmt;
use std::path::Path;

/// What is said of a text, with the text; of none where it is empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    /// The text.
    pub source: Source,
    /// What is said of it.
    pub diagnostics: Diagnostics,
}

impl Findings {
    fn of_no_text(diagnostic: Diagnostic) -> Self {
        Self { source: Source::new("", ""), diagnostics: diagnostic.into() }
    }
}

impl fmt::Display for Findings {
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
pub struct Shelf {
    place: Place,
    built_in: Layer,
    own: Layer,
    /// Both, the second over the first.
    all: Library,
}

impl Shelf {
    /// Reads the materials at a place; with them come the warnings. A file that does not exist is an empty library.
    ///
    /// # Errors
    /// The file exists and cannot be read, is not of an allowed file type, or is no library.
    pub fn open(place: Place, readable: Readable) -> Result<(Shelf, Findings), Findings> {
        let built_in = match place.built_in() {
            Some(name) => {
                let location = Location::Preset(name.to_owned());
                Layer::parse(location.read(FileKind::Material, readable).map_err(Findings::of_no_text)?)?.0
            }
            None => Layer::empty(""),
        };
        let (own, warnings) = match place.file() {
            Some(path) => Layer::read(path, readable)?,
            None => (Layer::empty(""), Diagnostics::new()),
        };
        let found = Findings { source: own.source.clone(), diagnostics: warnings };
        let all = merged(&built_in.library, &own.library);
        Ok((Shelf { place, built_in, own, all }, found))
    }

    /// Where the materials are.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// All materials: the built-in ones, those of the user's that have their names in their stead, then the others of the user's.
    pub fn library(&self) -> &Library {
        &self.all
    }

    /// The material of this name.
    pub fn get(&self, name: &str) -> Option<&Material> {
        self.all.get(name)
    }

    /// Whether the material of this name is a built-in one, so that it cannot be deleted. It can be replaced by one of the user's.
    pub fn is_built_in(&self, name: &str) -> bool {
        self.own.library.get(name).is_none() && self.built_in.library.get(name).is_some()
    }

    /// The text that the places in the material of this name are of.
    pub fn source_of(&self, name: &str) -> &Source {
        if self.is_built_in(name) { &self.built_in.source } else { &self.own.source }
    }

    /// Adds a material, or replaces the one of its name, and saves. The file is read anew before: what others have saved meanwhile
    /// stays.
    ///
    /// # Errors
    /// The file cannot be read, is no library any more, or cannot be written. It is then as it was, and so is the shelf.
    pub fn put(&mut self, material: Material) -> Result<(), Findings> {
        self.change(|library| {
            library.put(material);
            Ok(())
        })
    }

    /// Deletes a material and saves. Where it replaced a built-in one, that one is back.
    ///
    /// # Errors
    /// There is no such material, or it is built in; else as with [`put`](Self::put).
    pub fn remove(&mut self, name: &str) -> Result<(), Findings> {
        let built_in = self.built_in.library.get(name).is_some();
        let missing = unknown(name, &self.all, &self.place);
        self.change(|library| match library.remove(name) {
            Some(_) => Ok(()),
            None if built_in => Err(Diagnostic::error(format!("the material `{name}` is built in and cannot be deleted"))),
            None => Err(Diagnostic::error(missing)),
        })
    }

    /// Changes the user's materials in their file.
    fn change(&mut self, change: impl FnOnce(&mut Library) -> Result<(), Diagnostic>) -> Result<(), Findings> {
        let Some(path) = self.place.file() else {
            let message = format!("materials for {} cannot be saved: there is no folder for data of this user", self.place);
            return Err(Findings::of_no_text(Diagnostic::error(message).help("name a file of your own behind `#uses`")));
        };
        let (Layer { mut library, .. }, _) = Layer::read(path, Readable::Regular)?;
        change(&mut library).map_err(Findings::of_no_text)?;
        library.save(path).map_err(|error| {
            let message = format!("cannot write the material library `{}`: {}", path.display(), reason(&error));
            Findings::of_no_text(Diagnostic::error(message).help("the file is as it was before"))
        })?;
        // Read back for the places in the new text.
        self.own = Layer::read(path, Readable::Regular)?.0;
        self.all = merged(&self.built_in.library, &self.own.library);
        Ok(())
    }
}

impl Layer {
    fn empty(name: &str) -> Self {
        Self { library: Library::default(), source: Source::new(name, "") }
    }

    fn parse(source: Source) -> Result<(Self, Diagnostics), Findings> {
        match Library::parse(&source) {
            Ok((library, warnings)) => Ok((Self { library, source }, warnings)),
            Err(diagnostics) => Err(Findings { source, diagnostics }),
        }
    }

    /// The library of a file; an empty one if there is no such file.
    fn read(path: &Path, readable: Readable) -> Result<(Self, Diagnostics), Findings> {
        if !path.try_exists().unwrap_or(true) {
            return Ok((Self::empty(&path.display().to_string()), Diagnostics::new()));
        }
        Self::parse(read_source(path, Some(FileKind::Material), readable).map_err(Findings::of_no_text)?)
    }
}

/// The materials of both libraries; of two with one name the upper counts.
fn merged(lower: &Library, upper: &Library) -> Library {
    let mut all = lower.clone();
    upper.iter().for_each(|material| {
        all.put(material.clone());
    });
    all
}
