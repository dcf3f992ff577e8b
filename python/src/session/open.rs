//! Opening a session with the arguments of Python.

use crate::diagnostics::{Found, failure};
use crate::formula::Formula;
use crate::scene::Scene;
use crate::work::interruptible;
use illuminator::lang::source::Source;
use illuminator::workspace::materials::MaterialAssignment;
use illuminator::workspace::presets::DEFAULT_SESSION;
use illuminator::workspace::project::{Project, Request, SessionText};
use illuminator::workspace::session::PictureSettings;
use illuminator::workspace::{FileKind, Location, NamedAssignment, kind_of};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;
use std::path::PathBuf;

/// Where a formula or a scene is, and its text if Python has it.
pub(super) type Place = (Location, Option<Source>);

/// The arguments that say what to open.
pub(super) struct Given {
    pub(super) session: Option<PathBuf>,
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

/// An object that stands for a text.
pub(super) trait Text: PyClass<Frozen = True> + Sync {
    /// The name of the class.
    const CLASS: &'static str;

    fn place(&self) -> Place;
}

impl Text for Formula {
    const CLASS: &'static str = "Formula";

    fn place(&self) -> Place {
        (self.location.clone(), Some(self.source.clone()))
    }
}

impl Text for Scene {
    const CLASS: &'static str = "Scene";

    fn place(&self) -> Place {
        (self.location.clone(), Some(self.source.clone()))
    }
}

/// Where a text is that an argument names: an object, a path, or `preset:NAME`.
pub(super) fn location<T: Text>(given: &Bound<'_, PyAny>) -> PyResult<Place> {
    match given.cast::<T>() {
        Ok(text) => Ok(text.get().place()),
        Err(_) => {
            let path = given.extract::<PathBuf>().map_err(|_| {
                let shown = given.repr().map_or_else(|_| "that".to_owned(), |text| text.to_string());
                failure(format!("{shown} is no {0}; give a path, `preset:NAME`, or a {0}", T::CLASS))
            })?;
            match path.to_str().and_then(kind_of) {
                Some(kind) => Err(failure(format!("that is the text of a {}; use `{}.parse(text)`", kind.noun(), T::CLASS))),
                None => Ok((Location::new(path), None)),
            }
        }
    }
}

/// Opens the session. Returns the values that are to be set in it. There is a warning of Python for everything that is accepted and probably not meant.
pub(super) fn open(py: Python<'_>, given: Given) -> PyResult<(Project, Vec<NamedAssignment>)> {
    let session = match (&given.session, &given.formula, &given.scene) {
        (None, Some(_), Some(_)) => None,
        (None, ..) => Some(Location::Preset(DEFAULT_SESSION.to_owned())),
        (Some(session), ..) => Some(Location::new(session)),
    };
    let text = |place: &Option<Place>| place.as_ref().and_then(|(_, source)| source.clone());
    let texts = |kind: FileKind| match kind {
        FileKind::Formula => text(&given.formula),
        FileKind::Scene => text(&given.scene),
        FileKind::Session | FileKind::Material => None,
    };
    let location = |place: &Option<Place>| place.as_ref().map(|(location, _)| location.clone());
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
            formula: location(&given.formula),
            scene: location(&given.scene),
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
