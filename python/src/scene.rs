//! Scenes: their text and what they declare.

use crate::texts;
use illuminator::lang::source::Source;
use illuminator::scene::Scene as EngineScene;
use illuminator::workspace::{FileKind, Location};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A scene. Files that it names are read when a session opens it.
#[pyclass(module = "illuminator", frozen)]
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) location: Location,
    pub(crate) source: Source,
    scene: EngineScene,
}

#[pymethods]
impl Scene {
    /// Reads a scene: a path, or `preset:NAME`.
    #[new]
    #[pyo3(signature = (location))]
    fn new(location: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::read(location.py(), texts::location(location, FileKind::Scene)?, None)
    }

    /// Parses a text. `name` is what messages call it, and paths in the text start from its folder.
    #[staticmethod]
    #[pyo3(signature = (text, name=PathBuf::from("scene")))]
    fn parse(py: Python<'_>, text: String, name: PathBuf) -> PyResult<Self> {
        Self::read(py, Location::new(name), Some(text))
    }

    /// Where it comes from: a path, `preset:NAME`, or the name of the text.
    #[getter]
    fn name(&self) -> String {
        self.location.to_string()
    }

    /// Its text.
    #[getter]
    fn text(&self) -> &str {
        self.source.text()
    }

    /// The names of its bodies, in the order of the text.
    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.scene.bodies.iter().map(|body| body.name.as_str()).collect()
    }

    /// The names of its lights, in the order of the text.
    #[getter]
    fn lights(&self) -> Vec<&str> {
        self.scene.lights.iter().map(|light| light.name.as_str()).collect()
    }

    /// Scenes can be pickled, to go to other processes.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (&str, String))> {
        Ok((py.get_type::<Self>().getattr("parse")?, (self.source.text(), self.name())))
    }

    fn __repr__(&self) -> String {
        format!("<Scene {}: {} bodies, {} lights>", self.location, self.scene.bodies.len(), self.scene.lights.len())
    }
}

impl Scene {
    fn read(py: Python<'_>, location: Location, text: Option<String>) -> PyResult<Self> {
        let (source, scene) = texts::read(py, &location, FileKind::Scene, text, EngineScene::parse)?;
        Ok(Self { location, source, scene })
    }
}
