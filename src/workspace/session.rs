//! Sessions: formula, scene, picture settings and every parameter value, as a TOML file (thesis 8.4).
//!
//! A session names owners and parameters; whether they exist is seen only when it meets a formula and a scene.

mod read;
mod save;

use crate::files::replace_text;
use crate::lang::ast::Constant;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::{Source, Span};
use crate::lang::variables::Owner;
use crate::transfer::Transfer;
use crate::workspace::Location;
use crate::workspace::assignment::Assignment;
use crate::workspace::owner::OwnerId;
use crate::workspace::roster::Roster;
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

/// How a picture is made of a formula and a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureSettings {
    /// Width and height in pixels, each 1..=[`MAX_SIDE`](crate::trace::MAX_SIDE).
    pub size: [u32; 2],
    /// The maximum depth of rays, 1..=[`MAX_DEPTH`](crate::trace::MAX_DEPTH).
    pub depth: u32,
    /// Whether shadow rays are sent.
    pub shadows: bool,
    /// The refractive index of bodies that give none, greater than 0.
    pub default_index: f64,
    /// Whether pictures are stored with the sRGB transfer function.
    pub srgb: bool,
}

impl PictureSettings {
    /// How its colours become bytes.
    pub fn transfer(&self) -> Transfer {
        if self.srgb { Transfer::Srgb } else { Transfer::Linear }
    }
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self { size: [640, 480], depth: 5, shadows: true, default_index: 1.5, srgb: false }
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
    /// The owner of this name and kind in a scene.
    fn find(&self, roster: &Roster) -> Option<OwnerId> {
        match self {
            OwnerName::Global => Some(OwnerId::Global),
            OwnerName::Body(name) => roster.owners().named(name).filter(|owner| owner.kind() == Owner::Body),
            OwnerName::Light(name) => roster.owners().named(name).filter(|owner| owner.kind() == Owner::Light),
        }
    }
}

/// A parameter value by names.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedValue {
    /// Whose.
    pub owner: OwnerName,
    /// Of which parameter.
    pub parameter: String,
    /// The value.
    pub value: Constant,
    /// Where owner and parameter are named in the session's text; empty places where it has none.
    pub spans: [Span; 2],
}

impl Session {
    /// Reads a session; with it come the warnings. Its paths are as written: see [`Location::from_folder`].
    ///
    /// # Errors
    /// Everything wrong with the text that can be found in one go, warnings among it.
    pub fn parse(source: &Source) -> Result<(Session, Diagnostics), Diagnostics> {
        read::parse(source)
    }

    /// The session as it is written to a file in `folder`, to which its paths become relative.
    ///
    /// # Errors
    /// Never for sessions that were read or made from values: texts and numbers can all be written in TOML.
    pub fn to_toml(&self, folder: &Path) -> Result<String, toml::ser::Error> {
        save::to_toml(self, folder)
    }

    /// Writes the session to a file, whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written; what was there before is unharmed.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        replace_text(path, &self.to_toml(folder).map_err(io::Error::other)?)
    }

    /// The values as names, for a session.
    pub fn name_values(values: &Values) -> Vec<NamedValue> {
        let roster = values.roster();
        let named = values.iter().map(|(owner, id, numbers)| {
            let name = roster.owners().name(owner).unwrap_or_default().to_owned();
            NamedValue {
                owner: match owner {
                    OwnerId::Global => OwnerName::Global,
                    OwnerId::Body(_) => OwnerName::Body(name),
                    OwnerId::Light(_) => OwnerName::Light(name),
                },
                parameter: roster.parameter(id).name.clone(),
                value: match numbers {
                    [x, y, z] => Constant::Vector([*x, *y, *z]),
                    numbers => Constant::Scalar(numbers.first().copied().unwrap_or_default()),
                },
                spans: [Span::default(); 2],
            }
        });
        named.collect()
    }

    /// The values for a formula on a scene, and those that have no place there: one for each owner that does not exist, and one
    /// for each parameter of an owner that does.
    pub fn assignments(&self, roster: &Roster) -> (Vec<Assignment>, Vec<Leftover>) {
        let mut leftovers = Vec::new();
        let mut missing: BTreeSet<&OwnerName> = BTreeSet::new();
        let mut assignments = Vec::new();
        for value in &self.values {
            match value.owner.find(roster) {
                Some(owner) => match Assignment::by_name(roster, owner, &value.parameter, value.value, value.spans[1]) {
                    Ok(assignment) => assignments.push(assignment),
                    Err(warning) => leftovers.push(Leftover { lacking: Lacking::Parameter, warning }),
                },
                None if missing.insert(&value.owner) => {
                    leftovers.push(Leftover { lacking: Lacking::Owner, warning: no_owner(value) });
                }
                None => {}
            }
        }
        (assignments, leftovers)
    }
}

/// Values of a session that have no place in a formula on a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// What does not exist.
    pub lacking: Lacking,
    /// What is to be said of it where that is a surprise.
    pub warning: Diagnostic,
}

/// What does not exist for a session's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lacking {
    /// The scene has no such body or light.
    Owner,
    /// The formula has no such parameter, or it is of the other type.
    Parameter,
}

fn no_owner(value: &NamedValue) -> Diagnostic {
    let what = match &value.owner {
        OwnerName::Global => "global part".to_owned(),
        OwnerName::Body(name) => format!("body `{name}`"),
        OwnerName::Light(name) => format!("light `{name}`"),
    };
    Diagnostic::warning(format!("the scene has no {what}; its values are left out")).at(value.spans[0], "not in the scene")
}

#[cfg(test)]
mod tests;
