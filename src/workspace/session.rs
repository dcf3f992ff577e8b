//! Sessions: formula, scene, picture settings and all parameter values, in a TOML file (thesis 8.4).
//!
//! A session names owners and parameters. Whether they exist is only known together with a formula and a scene.

mod read;
mod save;

use crate::files::replace_text;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::source::{Source, SourceSpan};
use crate::lang::variables::Owner;
use crate::picture::ViewTransform;
use crate::workspace::Location;
use crate::workspace::assignment::{Assignment, FileValue};
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use crate::workspace::values::Values;
use std::collections::BTreeSet;
use std::io;
use std::path::Path;

pub(super) use read::KEYS;

/// What is shown, how, and with which values.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    /// The formula file.
    pub formula: Location,
    /// The scene file.
    pub scene: Location,
    /// How the picture is made.
    pub picture: PictureSettings,
    /// The parameter values, by name.
    pub values: Vec<NamedValue>,
}

/// How a picture of a formula on a scene is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureSettings {
    /// Width and height in pixels, each 1..=[`MAX_SIDE`](crate::trace::MAX_SIDE).
    pub size: [u32; 2],
    /// The maximum depth of rays, 1..=[`MAX_DEPTH`](crate::trace::MAX_DEPTH).
    pub depth: u32,
    /// Whether shadow rays are sent.
    pub shadows: bool,
    /// The refractive index of bodies that have none of their own, greater than 0.
    pub default_index: f64,
    /// How many passes the picture is the mean of, 1..=[`MAX_PASSES`](crate::trace::MAX_PASSES); `None`: the session
    /// does not say.
    pub samples: Option<u32>,
    /// How linear colours become those of an 8-bit picture.
    pub view: ViewTransform,
}

impl PictureSettings {
    /// How many passes the picture is the mean of: 1 if the session does not say. The window has a default of its own.
    pub fn passes(&self) -> u32 {
        self.samples.unwrap_or(1)
    }
}

impl Default for PictureSettings {
    fn default() -> Self {
        let view = ViewTransform::default();
        Self { size: [640, 480], depth: 5, shadows: true, default_index: 1.5, samples: None, view }
    }
}

/// An owner by name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum OwnerName {
    /// The scene.
    Global,
    /// The body of this name.
    Body(String),
    /// The light of this name.
    Light(String),
}

impl OwnerName {
    /// The owner with this kind and name in a scene.
    fn find(&self, table: &ParameterTable) -> Option<OwnerId> {
        match self {
            OwnerName::Global => Some(OwnerId::Global),
            OwnerName::Body(name) => table.owners().named(name).filter(|owner| owner.kind() == Owner::Body),
            OwnerName::Light(name) => table.owners().named(name).filter(|owner| owner.kind() == Owner::Light),
        }
    }
}

/// A parameter value by name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedValue {
    /// The owner.
    pub owner: OwnerName,
    /// The parameter.
    pub parameter: String,
    /// The value.
    pub value: FileValue,
    /// Where the session's text names owner and parameter; empty if there is no text.
    pub spans: [SourceSpan; 2],
}

impl Session {
    /// Parses a session. Returns it with warnings. Its paths stay as written: see [`Location::from_folder`].
    ///
    /// # Errors
    /// The errors of the text, as many as can be found at once, and the warnings.
    pub fn parse(source: &Source) -> Result<(Session, Diagnostics), Diagnostics> {
        read::parse(source)
    }

    /// What can be used of the text of a session, with all errors and warnings. There is nothing if the text does not
    /// say which formula and which scene it is of, or is of another version.
    pub fn parse_in_parts(source: &Source) -> (Option<Session>, Diagnostics) {
        read::parse_in_parts(source)
    }

    /// The session with relative paths taken from `folder`, if there is one.
    #[must_use]
    pub fn with_paths_from(self, folder: Option<&Path>) -> Session {
        let Some(folder) = folder else { return self };
        let (formula, scene) = (self.formula.from_folder(folder), self.scene.from_folder(folder));
        let placed = |value: NamedValue| NamedValue { value: value.value.taken_from(folder), ..value };
        Session { formula, scene, values: self.values.into_iter().map(placed).collect(), ..self }
    }

    /// The session as the text of a file in `folder`. Paths become relative to the folder.
    ///
    /// # Errors
    /// None for sessions that were parsed or made from values: TOML can hold their texts and numbers.
    pub fn to_toml(&self, folder: &Path) -> Result<String, toml::ser::Error> {
        save::to_toml(self, folder)
    }

    /// Writes the session to a file, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written. An existing file is then unchanged.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        replace_text(path, &self.to_toml(folder).map_err(io::Error::other)?)
    }

    /// All values by name, for a session.
    pub fn name_values(values: &Values) -> Vec<NamedValue> {
        let table = values.table();
        let named = values.iter().map(|(owner, id, numbers)| {
            let name = table.owners().name(owner).unwrap_or_default().to_owned();
            NamedValue {
                owner: match owner {
                    OwnerId::Global => OwnerName::Global,
                    OwnerId::Body(_) => OwnerName::Body(name),
                    OwnerId::Light(_) => OwnerName::Light(name),
                },
                parameter: table.parameter(id).name.clone(),
                value: FileValue::of(table.parameter(id).ty, numbers),
                spans: [SourceSpan::default(); 2],
            }
        });
        named.collect()
    }

    /// The values for a formula on a scene, and the values that do not fit: one entry for each owner that does not
    /// exist, and one for each parameter that an existing owner does not have.
    pub fn assignments(&self, table: &ParameterTable) -> (Vec<Assignment>, Vec<UnusedValue>) {
        let mut leftovers = Vec::new();
        let mut missing: BTreeSet<&OwnerName> = BTreeSet::new();
        let mut assignments = Vec::new();
        for value in &self.values {
            match value.assignment(table) {
                Ok(assignment) => assignments.push(assignment),
                Err(leftover) if leftover.missing == MissingTarget::Parameter => leftovers.push(leftover),
                Err(leftover) if missing.insert(&value.owner) => leftovers.push(leftover),
                Err(_) => {}
            }
        }
        (assignments, leftovers)
    }
}

impl NamedValue {
    /// The value for a formula on a scene.
    ///
    /// # Errors
    /// The owner does not exist, or it has no such parameter of this type.
    pub fn assignment(&self, table: &ParameterTable) -> Result<Assignment, UnusedValue> {
        let unused = |missing, owner, warning| UnusedValue { missing, owner, parameter: self.parameter.clone(), warning };
        let owner = self.owner.find(table).ok_or_else(|| unused(MissingTarget::Owner, None, no_owner(self, table)))?;
        Assignment::by_name(table, owner, &self.parameter, &self.value, self.spans[1])
            .map_err(|warning| unused(MissingTarget::Parameter, Some(owner), warning))
    }
}

/// Values of a session that do not fit a formula on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct UnusedValue {
    /// What does not exist.
    pub missing: MissingTarget,
    /// The owner, if it exists.
    pub owner: Option<OwnerId>,
    /// The name of the parameter.
    pub parameter: String,
    /// A warning about it, for users who do not expect it.
    pub warning: Diagnostic,
}

/// What is missing for a value of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MissingTarget {
    /// The scene has no such body or light.
    Owner,
    /// The formula has no such parameter, or it has the other type.
    Parameter,
}

fn no_owner(value: &NamedValue, table: &ParameterTable) -> Diagnostic {
    let owners = table.owners();
    let near = |name: &str, kind: Owner| {
        let of_kind = |other: &&str| owners.named(other).is_some_and(|owner| owner.kind() == kind);
        nearest(name, owners.names().filter(of_kind)).map(|near| format!("did you mean `{near}`?"))
    };
    let (what, hint) = match &value.owner {
        OwnerName::Global => ("global part".to_owned(), None),
        OwnerName::Body(name) => (format!("body `{name}`"), near(name, Owner::Body)),
        OwnerName::Light(name) => (format!("light `{name}`"), near(name, Owner::Light)),
    };
    Diagnostic::warning(format!("the scene has no {what}; its values are ignored"))
        .at(value.spans[0], "not in the scene")
        .help_if(hint)
}

#[cfg(test)]
mod tests;
