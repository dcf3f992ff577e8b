//! Materials for bodies, as users write them: `ball=gold`.

use crate::lang::diagnostic::Diagnostics;
use crate::lang::variables::Owner;
use crate::workspace::assignment::{Assignment, hint};
use crate::workspace::materials::{Materials, unknown_material};
use crate::workspace::owner::OwnerId;
use crate::workspace::parameter_table::ParameterTable;
use std::fmt;
use std::str::FromStr;

/// The bodies that a material is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BodySelection {
    /// `*=gold`: all bodies.
    All,
    /// `ball=gold`: the body of this name.
    Named(String),
}

/// A material for bodies, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MaterialAssignment {
    /// The bodies.
    pub bodies: BodySelection,
    /// The name of the material.
    pub material: String,
}

/// What is wrong with a material for a body.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MaterialAssignmentError {
    /// It has no `=`, or nothing on one side of it.
    #[error("`{0}` is not of the form BODY=MATERIAL; write for example `ball=gold`, or `*=gold` for all bodies")]
    Form(String),
    /// There is no body of this name.
    #[error("there is no body `{name}`{hint}")]
    Body {
        /// The name.
        name: String,
        /// The nearest name, or the names that exist.
        hint: String,
    },
    /// The name is that of a light.
    #[error("`{0}` is a light; only bodies have materials")]
    Light(String),
    /// There is no material of this name. The message names the nearest.
    #[error("{0}")]
    Material(String),
}

impl FromStr for MaterialAssignment {
    type Err = MaterialAssignmentError;

    fn from_str(text: &str) -> Result<Self, MaterialAssignmentError> {
        let sides = text.split_once('=').map(|(body, material)| (body.trim(), material.trim()));
        match sides {
            Some((body, material)) if !body.is_empty() && !material.is_empty() => Ok(MaterialAssignment {
                bodies: if body == "*" { BodySelection::All } else { BodySelection::Named(body.to_owned()) },
                material: material.to_owned(),
            }),
            Some(_) | None => Err(MaterialAssignmentError::Form(text.to_owned())),
        }
    }
}

impl MaterialAssignment {
    /// Resolves the names on a scene. Returns the assignments, and a warning for each value that does not fit the
    /// formula. The warnings refer to the text of [`Materials::source_of`].
    ///
    /// # Errors
    /// There is no such body or no such material.
    pub fn resolve(
        &self,
        materials: &Materials,
        table: &ParameterTable,
    ) -> Result<(Vec<Assignment>, Diagnostics), MaterialAssignmentError> {
        let owners = table.owners();
        let bodies: Vec<OwnerId> = match &self.bodies {
            BodySelection::All => owners.of_kind(Owner::Body).collect(),
            BodySelection::Named(name) => match owners.named(name) {
                Some(body @ OwnerId::Body(_)) => vec![body],
                Some(OwnerId::Light(_) | OwnerId::Global) => return Err(MaterialAssignmentError::Light(name.clone())),
                None => {
                    let names: Vec<&str> = owners.of_kind(Owner::Body).filter_map(|body| owners.name(body)).collect();
                    return Err(MaterialAssignmentError::Body { name: name.clone(), hint: hint(name, &names) });
                }
            },
        };
        let unknown =
            || MaterialAssignmentError::Material(unknown_material(&self.material, materials.library(), materials.location()));
        let material = materials.get(&self.material).ok_or_else(unknown)?;
        let mut assignments = Vec::new();
        let mut warnings = Diagnostics::new();
        for body in bodies {
            if let OwnerId::Body(body) = body {
                let (given, left_out) = material.assignments(table, body);
                assignments.extend(given);
                // `extend` leaves out diagnostics that are there already, so several bodies give each warning once.
                warnings.extend(left_out);
            }
        }
        Ok((assignments, warnings))
    }
}

impl fmt::Display for MaterialAssignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.bodies {
            BodySelection::All => write!(f, "*={}", self.material),
            BodySelection::Named(name) => write!(f, "{name}={}", self.material),
        }
    }
}
