//! Which body gets which material, as users say it: `ball=gold`.

use crate::lang::diagnostic::Diagnostics;
use crate::lang::variables::Owner;
use crate::workspace::assignment::{Assignment, hint};
use crate::workspace::materials::{Shelf, unknown};
use crate::workspace::owner::OwnerId;
use crate::workspace::roster::Roster;
use std::fmt;
use std::str::FromStr;

/// The bodies that a material is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Bodies {
    /// `*=gold`: all.
    All,
    /// `ball=gold`: the one of this name.
    Named(String),
}

/// A material for bodies, by names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// The bodies.
    pub bodies: Bodies,
    /// The name of the material.
    pub material: String,
}

/// What is wrong with a choice.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ChoiceError {
    /// It has no `=`, or nothing on a side of it.
    #[error("`{0}` is not of the form BODY=MATERIAL; write for example `ball=gold`, or `*=gold` for all bodies")]
    Form(String),
    /// There is no body of this name.
    #[error("there is no body `{name}`{hint}")]
    Body {
        /// The name.
        name: String,
        /// The nearest name, or those that exist.
        hint: String,
    },
    /// It is a light's name.
    #[error("`{0}` is a light; only bodies have materials")]
    Light(String),
    /// There is no material of this name; the text says which are near.
    #[error("{0}")]
    Material(String),
}

impl FromStr for Choice {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let sides = text.split_once('=').map(|(body, material)| (body.trim(), material.trim()));
        match sides {
            Some((body, material)) if !body.is_empty() && !material.is_empty() => Ok(Choice {
                bodies: if body == "*" { Bodies::All } else { Bodies::Named(body.to_owned()) },
                material: material.to_owned(),
            }),
            Some(_) | None => Err(ChoiceError::Form(text.to_owned())),
        }
    }
}

impl Choice {
    /// What this means on a scene; with it a warning for each value that has no place in the formula, said of the text that
    /// [`Shelf::source_of`] gives.
    ///
    /// # Errors
    /// There is no such body or material.
    pub fn resolve(&self, shelf: &Shelf, roster: &Roster) -> Result<(Vec<Assignment>, Diagnostics), ChoiceError> {
        let owners = roster.owners();
        let bodies: Vec<OwnerId> = match &self.bodies {
            Bodies::All => owners.of_kind(Owner::Body).collect(),
            Bodies::Named(name) => match owners.named(name) {
                Some(body @ OwnerId::Body(_)) => vec![body],
                Some(OwnerId::Light(_) | OwnerId::Global) => return Err(ChoiceError::Light(name.clone())),
                None => {
                    let names: Vec<&str> = owners.of_kind(Owner::Body).filter_map(|body| owners.name(body)).collect();
                    return Err(ChoiceError::Body { name: name.clone(), hint: hint(name, &names) });
                }
            },
        };
        let unknown = || ChoiceError::Material(unknown(&self.material, shelf.library(), shelf.place()));
        let material = shelf.get(&self.material).ok_or_else(unknown)?;
        let mut assignments = Vec::new();
        let mut warnings = Diagnostics::new();
        for body in bodies {
            if let OwnerId::Body(body) = body {
                let (given, left_out) = material.assignments(roster, body);
                assignments.extend(given);
                // Of several bodies the same is said once.
                warnings.extend(left_out);
            }
        }
        Ok((assignments, warnings))
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.bodies {
            Bodies::All => write!(f, "*={}", self.material),
            Bodies::Named(name) => write!(f, "{name}={}", self.material),
        }
    }
}
