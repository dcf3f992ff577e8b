//! Files into what the workshop shows: read, checked, and nothing taken unless all of it can be.

use crate::files::Readable;
use crate::formula::Formula;
use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::Source;
use crate::presets::Kind;
use crate::scene::Scene;
use crate::workspace::files::Location;
use crate::workspace::session::PictureSettings;
use crate::workspace::{Roster, Session, Values};
use crate::world::World;
use std::path::Path;
use std::sync::Arc;

/// What was opened.
#[derive(Debug)]
pub struct Opened {
    /// Where the formula is, its text, and what it is.
    pub formula_location: Location,
    /// Its text.
    pub formula_text: Source,
    /// The formula.
    pub formula: Arc<Formula>,
    /// Where the scene is.
    pub scene_location: Location,
    /// Its text.
    pub scene_text: Source,
    /// The scene, ready for rays.
    pub world: Arc<World>,
    /// The values.
    pub values: Values,
    /// Size, depth and the like.
    pub picture: PictureSettings,
    /// What was not taken as it was given, for people.
    pub warnings: Vec<String>,
}

impl Opened {
    /// Opens a session with its files. `readable` says which files the session itself may be; those that it names must be
    /// regular.
    ///
    /// # Errors
    /// What is wrong with any of the files, as text with the places marked.
    pub fn session(location: &Location, readable: Readable) -> Result<Opened, String> {
        let folder = match location {
            Location::File(path) => path.parent().unwrap_or(Path::new("")),
            Location::Preset(_) => Path::new(""),
        };
        Self::session_of(&read(location, Kind::Session, readable)?, folder, |_| None)
    }

    /// Opens a session whose text this is, in `folder`, with other texts of its formula and its scene where there are any.
    ///
    /// # Errors
    /// As for [`session`](Self::session).
    pub fn session_of(source: &Source, folder: &Path, other: impl Fn(Kind) -> Option<Source>) -> Result<Opened, String> {
        let (mut session, told) = checked(Session::parse(source), source)?;
        session.formula = session.formula.from_folder(folder);
        session.scene = session.scene.from_folder(folder);
        let text_of = |location: &Location, kind| other(kind).map_or_else(|| read(location, kind, Readable::Regular), Ok);
        let formula_text = text_of(&session.formula, Kind::Formula)?;
        let (formula, more) = checked(Formula::parse(&formula_text), &formula_text)?;
        let scene_text = text_of(&session.scene, Kind::Scene)?;
        let (scene, most) = checked(Scene::parse(&scene_text), &scene_text)?;
        let (given, leftovers) = session.assignments(&Roster::new(&formula, &scene));
        let (values, changed) = Values::new(&formula, &scene, &given);
        let mut warnings = [told, more, most].concat();
        warnings.extend(leftovers.iter().map(|leftover| text(&leftover.warning)));
        warnings.extend(changed.iter().map(ToString::to_string));
        Ok(Opened {
            formula_location: session.formula,
            formula_text,
            formula: Arc::new(formula),
            scene_location: session.scene,
            scene_text,
            world: Arc::new(World::new(scene)),
            values,
            picture: session.picture,
            warnings,
        })
    }
}

/// Reads a text.
fn read(location: &Location, kind: Kind, readable: Readable) -> Result<Source, String> {
    location.read(kind, readable).map_err(|error| text(&error))
}

/// What a text was parsed into, and its warnings.
fn checked<T>(parsed: Result<(T, Diagnostics), Diagnostics>, source: &Source) -> Result<(T, Vec<String>), String> {
    let (parsed, warnings) = parsed.map_err(|errors| errors.render(source, false))?;
    Ok((parsed, warnings.iter().map(text).collect()))
}

/// What a diagnostic says, without its place.
fn text(diagnostic: &Diagnostic) -> String {
    let hints = diagnostic.hints().iter().map(|hint| format!(" ({hint})"));
    std::iter::once(diagnostic.message().to_owned()).chain(hints).collect()
}
