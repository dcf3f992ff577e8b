//! Opening a session with the arguments of Python.

use crate::diagnostics::Found;
use crate::formula::Formula;
use crate::scene::Scene;
use crate::texts::location;
use crate::work::interruptible;
use illuminator::lang::source::Source;
use illuminator::workspace::materials::MaterialAssignment;
use illuminator::workspace::presets::DEFAULT_SESSION;
use illuminator::workspace::project::{Project, Request, SessionText};
use illuminator::workspace::session::PictureSettings;
use illuminator::workspace::{FileKind, Location, NamedAssignment};
use pyo3::prelude::*;

/// Where a formula or a scene is, and its text if Python has it.
pub(super) type Place = (Location, Option<Source>);

/// The arguments that say what to open.
pub(super) struct Given {
    pub(super) session: Option<Location>,
    pub(super) formula: Option<Place>,
    pub(super) scene: Option<Place>,
    pub(super) size: Option<[u32; 2]>,
    pub(super) samples: Option<u32>,
    pub(super) depth: Option<u32>,
    pub(super) shadows: Option<bool>,
    pub(super) ior: Option<f64>,
    pub(super) background: Option<[f32; 3]>,
    pub(super) set: Vec<NamedAssignment>,
    pub(super) materials: Vec<MaterialAssignment>,
    pub(super) threads: Option<usize>,
    /// In bytes.
    pub(super) memory: Option<u64>,
}

/// Where the formula is that an argument names.
pub(super) fn formula(given: &Bound<'_, PyAny>) -> PyResult<Place> {
    match given.cast::<Formula>() {
        Ok(formula) => Ok((formula.get().location.clone(), Some(formula.get().source.clone()))),
        Err(_) => Ok((location(given, FileKind::Formula)?, None)),
    }
}

/// Where the scene is that an argument names.
pub(super) fn scene(given: &Bound<'_, PyAny>) -> PyResult<Place> {
    match given.cast::<Scene>() {
        Ok(scene) => Ok((scene.get().location.clone(), Some(scene.get().source.clone()))),
        Err(_) => Ok((location(given, FileKind::Scene)?, None)),
    }
}

/// Opens the session. Returns it with the values that are to be set in it. Python gets a warning for each thing that is
/// accepted and probably not meant.
pub(super) fn open(py: Python<'_>, given: Given) -> PyResult<(Project, Vec<NamedAssignment>)> {
    let session = match (&given.session, &given.formula, &given.scene) {
        (None, Some(_), Some(_)) => None,
        (None, ..) => Some(Location::Preset(DEFAULT_SESSION.to_owned())),
        (Some(session), ..) => Some(session.clone()),
    };
    let text = |place: &Option<Place>| place.as_ref().and_then(|(_, source)| source.clone());
    let texts = |kind: FileKind| match kind {
        FileKind::Formula => text(&given.formula),
        FileKind::Scene => text(&given.scene),
        FileKind::Session | FileKind::Material => None,
    };
    let place = |place: &Option<Place>| place.as_ref().map(|(location, _)| location.clone());
    let change = |picture: &mut PictureSettings| {
        picture.size = given.size.unwrap_or(picture.size);
        picture.samples = given.samples.or(picture.samples);
        picture.depth = given.depth.unwrap_or(picture.depth);
        picture.shadows = given.shadows.unwrap_or(picture.shadows);
        picture.default_index = given.ior.unwrap_or(picture.default_index);
    };
    let mut found = Found::default();
    let outcome = interruptible(py, |task| {
        let request = Request {
            session: session.map(SessionText::At),
            formula: place(&given.formula),
            scene: place(&given.scene),
            texts: Some(&texts),
            materials: &given.materials,
            picture: Some(&change),
            background: given.background,
            memory: given.memory,
            task: Some(*task),
            ..Request::default()
        };
        Project::open(&request, &mut found)
    })?;
    Ok((found.settle(py, outcome)?, given.set))
}
