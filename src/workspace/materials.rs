//! Materials: named sets of body parameter values, kept in the library that a formula's `#uses` names (thesis 8.2.1).
//!
//! A library names parameters; whether they exist is seen only when a material meets a formula. [`Library`] is the contents of one
//! file, [`Place`] says where a formula's materials are, [`Shelf`] is what a user sees of them: what is built in, with what was
//! saved on top. What values become on a body is decided by [`Values`].

mod choice;
mod place;
mod read;
mod save;
mod shelf;

use crate::lang::ast::Constant;
use crate::lang::diagnostic::Diagnostics;
use crate::lang::source::{Source, Span};
use crate::lang::variables::Owner;
use crate::scene::BodyId;
use crate::workspace::assignment::{Assignment, hint};
use crate::workspace::owner::OwnerId;
use crate::workspace::roster::Roster;
use crate::workspace::spanned_toml::VERSION_KEY;
use crate::workspace::values::Values;
use std::io;
use std::path::Path;

pub use choice::{Bodies, Choice, ChoiceError};
pub use place::Place;
pub use shelf::{Findings, Shelf};

/// A value of a material, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Of which parameter.
    pub parameter: String,
    /// The value.
    pub value: Constant,
    /// Where the parameter is named in the library's text; an empty place where it has none.
    pub span: Span,
}

/// A named set of body parameter values. Its name is one that a library can hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: String,
    /// Its values, in the order of the file.
    pub properties: Vec<Property>,
}

/// Why a text cannot name a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// It is empty, or nothing but white space.
    #[error("a material needs a name")]
    Empty,
    /// Libraries have a key of this name already.
    #[error("no material can be called `version`: material libraries say so which version they are of")]
    Reserved,
    /// It has line breaks or the like, or white space around it.
    #[error("the name of a material is one line without blanks around it")]
    Form,
}

impl Material {
    /// A material without values.
    ///
    /// # Errors
    /// What cannot be its name.
    pub fn new(name: impl Into<String>) -> Result<Material, NameError> {
        let name = name.into();
        if name.trim().is_empty() {
            Err(NameError::Empty)
        } else if name == VERSION_KEY {
            Err(NameError::Reserved)
        } else if name.trim() != name || name.contains(char::is_control) {
            Err(NameError::Form)
        } else {
            Ok(Material { name, properties: Vec::new() })
        }
    }

    /// A material of all values that a body has at present; without values where the scene has no such body.
    ///
    /// # Errors
    /// What cannot be its name.
    pub fn of_body(name: impl Into<String>, values: &Values, body: BodyId) -> Result<Material, NameError> {
        let mut material = Material::new(name)?;
        let roster = values.roster();
        for id in roster.parameters_of(Owner::Body) {
            let value = match values.as_material(OwnerId::Body(body), id) {
                [] => continue,
                [x, y, z] => Constant::Vector([*x, *y, *z]),
                [number, ..] => Constant::Scalar(*number),
            };
            let parameter = roster.parameter(id).name.clone();
            material.properties.push(Property { parameter, value, span: Span::default() });
        }
        Ok(material)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What [`Values::assign`] takes to give the material to a body; with it a warning for each value that has no place in the
    /// formula, which is said of the library's text. Values that the material does not have stay as they are.
    pub fn assignments(&self, roster: &Roster, body: BodyId) -> (Vec<Assignment>, Diagnostics) {
        let owner = OwnerId::Body(body);
        let mut assignments = Vec::new();
        let mut warnings = Diagnostics::new();
        for Property { parameter, value, span } in &self.properties {
            match Assignment::by_name(roster, owner, parameter, *value, *span) {
                // What follows from others and counts for nothing on this body is no news in a material.
                Ok(given) if is_idle(roster, given) => {}
                Ok(given) => assignments.push(given),
                Err(warning) => warnings.push(warning),
            }
        }
        (assignments, warnings)
    }
}

fn is_idle(roster: &Roster, given: Assignment) -> bool {
    roster.fixed(given.owner, given.parameter).is_some() && roster.system(Owner::Body).is_locked(given.parameter)
}

/// The materials of one file, in its order. No two have the same name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Library {
    materials: Vec<Material>,
}

impl Library {
    /// Reads a library; with it come the warnings.
    ///
    /// # Errors
    /// Everything wrong with the text that can be found in one go, warnings among it.
    pub fn parse(source: &Source) -> Result<(Library, Diagnostics), Diagnostics> {
        read::parse(source)
    }

    /// The library as text.
    ///
    /// # Errors
    /// Never for libraries that were read or made from values: names and finite numbers can all be written in TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        save::to_toml(self)
    }

    /// Writes the library to a file, whole or not at all; folders that are missing on the way are made.
    ///
    /// # Errors
    /// The file is read-only or cannot be written; what was there before is unharmed.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        save::save(self, path)
    }

    /// The materials in their order.
    pub fn iter(&self) -> impl Iterator<Item = &Material> {
        self.materials.iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.materials.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.materials.is_empty()
    }

    /// The material of this name.
    pub fn get(&self, name: &str) -> Option<&Material> {
        self.materials.iter().find(|material| material.name == name)
    }

    /// Adds a material at the end, or puts it in the place of the one of the same name, which is handed back.
    pub fn put(&mut self, material: Material) -> Option<Material> {
        match self.materials.iter_mut().find(|known| known.name == material.name) {
            Some(known) => Some(std::mem::replace(known, material)),
            None => {
                self.materials.push(material);
                None
            }
        }
    }

    /// Takes the material of this name out, if there is one.
    pub fn remove(&mut self, name: &str) -> Option<Material> {
        let index = self.materials.iter().position(|material| material.name == name)?;
        Some(self.materials.remove(index))
    }
}

/// That there is no material of this name among those at a place, with the nearest.
fn unknown(name: &str, known: &Library, place: &Place) -> String {
    let names: Vec<&str> = known.iter().map(Material::name).collect();
    let missing = |path: &Path| !path.try_exists().unwrap_or(true);
    let hint = match names.as_slice() {
        [] if place.file().is_some_and(missing) => "; there is no such file yet".to_owned(),
        [] => "; it holds none".to_owned(),
        names => hint(name, names),
    };
    format!("there is no material `{name}` in {place}{hint}")
}

#[cfg(test)]
mod tests;
