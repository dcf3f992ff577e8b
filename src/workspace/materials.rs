//! Materials: named sets of body parameter values, in the library that a formula names with `#uses` (thesis 8.2.1).
//!
//! A library names parameters. Whether they exist is only known for a material together with a formula. [`Library`]
//! holds the contents of one file, [`LibraryLocation`] says where the materials of a formula are, and [`Materials`]
//! has all materials of a formula: the built-in ones, overlaid with those that the user saved. [`Values`] decides what
//! the values of a body become.

mod assignment;
mod library_location;
mod overlay;
mod read;
mod save;

use crate::lang::diagnostic::Diagnostics;
use crate::lang::source::{Source, SourceSpan};
use crate::lang::variables::Owner;
use crate::scene::BodyId;
use crate::workspace::Location;
use crate::workspace::assignment::{Assignment, FileValue, hint, number_in_quotes};
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::spanned_toml::VERSION_KEY;
use crate::workspace::textures;
use crate::workspace::values::Values;
use std::io;
use std::path::Path;

pub use assignment::{BodySelection, MaterialAssignment, MaterialAssignmentError};
pub use library_location::LibraryLocation;
pub use overlay::{Materials, SourceDiagnostics};

/// A value of a material, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// The parameter.
    pub parameter: String,
    /// The value.
    pub value: FileValue,
    /// Where the library's text names the parameter; empty if there is no text.
    pub span: SourceSpan,
}

/// A named set of body parameter values. The name is one that a library can hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: String,
    /// The values, in the order of the file.
    pub properties: Vec<Property>,
}

/// Why a text cannot be the name of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// It is empty, or only white space.
    #[error("a material needs a name")]
    Empty,
    /// Libraries use this key for something else.
    #[error("`version` cannot be the name of a material: in a library it is the key of the version")]
    Reserved,
    /// It has line breaks or other control characters, or white space around it.
    #[error("the name of a material must be one line, without spaces at its ends")]
    Form,
}

impl Material {
    /// A material without values.
    ///
    /// # Errors
    /// The text cannot be a name.
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

    /// A material with all values that a body has now; without values if the scene has no such body.
    ///
    /// # Errors
    /// The text cannot be a name.
    pub fn of_body(name: impl Into<String>, values: &Values, body: BodyId) -> Result<Material, NameError> {
        let mut material = Material::new(name)?;
        let table = values.table();
        for id in table.parameters_of(Owner::Body) {
            let numbers = values.material_value(OwnerId::Body(body), id);
            if numbers.is_empty() {
                continue;
            }
            let value = FileValue::of(table.parameter(id).ty, numbers);
            let parameter = table.parameter(id).name.clone();
            material.properties.push(Property { parameter, value, span: SourceSpan::default() });
        }
        Ok(material)
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether a body has all the values of this material that the formula knows.
    pub fn is_of(&self, values: &Values, body: BodyId) -> bool {
        let (table, owner) = (values.table(), OwnerId::Body(body));
        let known = |property: &Property| {
            table.parameter_named(&property.parameter).filter(|id| table.parameter(*id).owner == Owner::Body)
        };
        let near = |(one, other): (&f32, &f32)| (one - other).abs() <= 1e-5 * one.abs().max(1.0);
        let mut compared = self.properties.iter().filter_map(|property| known(property).map(|id| (id, property))).peekable();
        compared.peek().is_some()
            && compared.all(|(id, property)| {
                let has = values.material_value(owner, id);
                match &property.value {
                    FileValue::Constant(wanted) => {
                        let wanted = wanted.components();
                        has.is_empty() || has.len() == wanted.len() && has.iter().zip(wanted).all(near)
                    }
                    image @ FileValue::Image(_) => FileValue::of(table.parameter(id).ty, has) == *image,
                }
            })
    }

    /// The assignments for [`Values::assign`] that give the material to a body, and a warning for each value that does
    /// not fit the formula. The warnings refer to the library's text. Values that the material does not have stay
    /// unchanged.
    pub fn assignments(&self, table: &ParameterTable, body: BodyId) -> (Vec<Assignment>, Diagnostics) {
        let owner = OwnerId::Body(body);
        let mut assignments = Vec::new();
        let mut warnings = Diagnostics::new();
        for Property { parameter, value, span } in &self.properties {
            match Assignment::by_name(table, owner, parameter, value, *span) {
                // It is expected of a material that it has values which follow from others and have no effect on this
                // body.
                Ok(given) if is_idle(table, given) => {}
                Ok(given) => assignments.push(given),
                Err(warning) => warnings.push(warning),
            }
        }
        (assignments, warnings)
    }
}

fn is_idle(table: &ParameterTable, given: Assignment) -> bool {
    table.fixed(given.owner, given.parameter).is_some() && table.system(Owner::Body).is_locked(given.parameter)
}

/// The materials of one file, in the order of the file. No two have the same name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Library {
    materials: Vec<Material>,
}

impl Library {
    /// Parses a library. Returns it with warnings.
    ///
    /// # Errors
    /// The errors of the text, as many as can be found at once, and the warnings.
    pub fn parse(source: &Source) -> Result<(Library, Diagnostics), Diagnostics> {
        read::parse(source)
    }

    /// An error for each image that cannot be read, in the text of the library, which is at this location.
    pub fn unreadable_images(&self, location: &Location) -> Diagnostics {
        let folder = location.file().and_then(Path::parent).unwrap_or(Path::new(""));
        let mut errors = Diagnostics::new();
        for Property { parameter, value, span } in self.materials.iter().flat_map(|material| &material.properties) {
            if let FileValue::Image(path) = value.clone().taken_from(folder)
                && let Err(error) = textures::load(&path)
            {
                errors.push(error.at(*span, format!("the image of `{parameter}`")).help_if(number_in_quotes(&path)));
            }
        }
        errors
    }

    /// The library with other values.
    fn with_values(mut self, change: impl Fn(FileValue) -> FileValue) -> Library {
        for property in self.materials.iter_mut().flat_map(|material| &mut material.properties) {
            property.value = change(property.value.clone());
        }
        self
    }

    /// The library as text.
    ///
    /// # Errors
    /// None for libraries that were parsed or made from values: TOML can hold their names and numbers.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        save::to_toml(self)
    }

    /// Writes the library to a file, whole or not at all. Missing folders are created.
    ///
    /// # Errors
    /// The file is read-only or cannot be written. An existing file is then unchanged.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        save::save(&self.clone().with_values(|value| value.relative_to(folder)), path)
    }

    /// The materials, in order.
    pub fn iter(&self) -> impl Iterator<Item = &Material> {
        self.materials.iter()
    }

    /// The number of materials.
    pub fn len(&self) -> usize {
        self.materials.len()
    }

    /// Whether there are no materials.
    pub fn is_empty(&self) -> bool {
        self.materials.is_empty()
    }

    /// The material of this name.
    pub fn get(&self, name: &str) -> Option<&Material> {
        self.materials.iter().find(|material| material.name == name)
    }

    /// Adds a material at the end, or replaces the one of the same name, which is returned.
    pub fn put(&mut self, material: Material) -> Option<Material> {
        match self.materials.iter_mut().find(|known| known.name == material.name) {
            Some(known) => Some(std::mem::replace(known, material)),
            None => {
                self.materials.push(material);
                None
            }
        }
    }

    /// Removes the material of this name, if there is one, and returns it.
    pub fn remove(&mut self, name: &str) -> Option<Material> {
        let index = self.materials.iter().position(|material| material.name == name)?;
        Some(self.materials.remove(index))
    }
}

/// The message that there is no material of this name, with the nearest name.
fn unknown_material(name: &str, known: &Library, location: &LibraryLocation) -> String {
    let names: Vec<&str> = known.iter().map(Material::name).collect();
    let missing = |path: &Path| !path.try_exists().unwrap_or(true);
    let hint = match names.as_slice() {
        [] if location.file().is_some_and(missing) => "; there is no such file yet".to_owned(),
        [] => "; it holds none".to_owned(),
        names => hint(name, names),
    };
    format!("there is no material `{name}` in {location}{hint}")
}

#[cfg(test)]
mod tests;
