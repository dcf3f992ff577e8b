//! Sessions: a formula on a scene, with the values of all parameters, and its pictures.

mod arguments;
mod names;
mod open;
mod tracing;

use crate::arrays;
use crate::diagnostics::{engine_failure, failure, warn};
use crate::drag::Drag;
use crate::formula::Formula;
use crate::hits;
use crate::sweep::{self, Sweep};
use crate::work::{interruptible, lock};
use arguments::SessionArguments;
use illuminator::engine::Subject;
use illuminator::files::{Readable, reason};
use illuminator::lang::source::Source;
use illuminator::picture::{Format, Frame, file_bytes, quantise, save};
use illuminator::workspace::session::PictureSettings;
use illuminator::workspace::{FileKind, Location, NamedAssignment, Session as SessionFile, Values};
use names::assignment;
pub(crate) use names::{find, named_value, numbers};
use numpy::PyArray3;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyIterator};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
pub(crate) use tracing::{Tracing, mean, on_threads};

/// A formula on a scene, with the values of all parameters.
#[pyclass(module = "illuminator", frozen)]
pub(crate) struct Session {
    pub(crate) subject: Subject,
    pub(crate) picture: PictureSettings,
    /// The formula and the scene with their texts.
    formula: (Location, Source),
    scene: (Location, Source),
    pub(crate) values: Mutex<Values>,
    pub(crate) tracing: Mutex<Tracing>,
}

#[pymethods]
impl Session {
    /// Opens a session: a path, or `preset:NAME`. Without one, the default session; or with both a formula and a scene,
    /// these with default values. `formula` and `scene` are paths, `preset:NAME`, or objects. The other arguments
    /// change the settings of the session.
    #[new]
    #[pyo3(signature = (session=None, *, formula=None, scene=None, size=None, samples=None, depth=None, shadows=None,
        ior=None, background=None, set=None, materials=None, backend=None, threads=None, memory=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn new(
        py: Python<'_>,
        session: Option<Bound<'_, PyAny>>,
        formula: Option<Bound<'_, PyAny>>,
        scene: Option<Bound<'_, PyAny>>,
        size: Option<Bound<'_, PyAny>>,
        samples: Option<Bound<'_, PyAny>>,
        depth: Option<Bound<'_, PyAny>>,
        shadows: Option<Bound<'_, PyAny>>,
        ior: Option<Bound<'_, PyAny>>,
        background: Option<Bound<'_, PyAny>>,
        set: Option<Bound<'_, PyAny>>,
        materials: Option<Bound<'_, PyAny>>,
        backend: Option<&str>,
        threads: Option<Bound<'_, PyAny>>,
        memory: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let arguments = SessionArguments {
            session,
            formula,
            scene,
            size,
            samples,
            depth,
            shadows,
            ior,
            background,
            set,
            materials,
            threads,
            memory,
        };
        let given = arguments.given()?;
        let means = tracing::Means { backend, threads: given.threads, memory: given.memory };
        let (project, set) = open::open(py, given)?;
        let session = Self {
            tracing: Mutex::new(Tracing::new(project.subject.clone(), project.picture.passes(), means)?),
            subject: project.subject,
            picture: project.picture,
            formula: (project.formula_location, project.formula_text),
            scene: (project.scene_location, project.scene_text),
            values: Mutex::new(project.values),
        };
        session.assign(py, &set)?;
        Ok(session)
    }

    /// Width and height of the picture, in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let [width, height] = self.picture.size;
        (width, height)
    }

    /// How many passes the picture is the mean of.
    #[getter]
    fn samples(&self) -> u32 {
        self.picture.passes()
    }

    /// The formula.
    #[getter]
    fn formula(&self) -> Formula {
        let (location, source) = self.formula.clone();
        Formula { location, source, formula: self.subject.formula.as_ref().clone() }
    }

    /// The names of the bodies.
    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.subject.world.scene().bodies.iter().map(|body| body.name.as_str()).collect()
    }

    /// The names of the lights.
    #[getter]
    fn lights(&self) -> Vec<&str> {
        self.subject.world.scene().lights.iter().map(|light| light.name.as_str()).collect()
    }

    /// The values of all parameters, by name: `{"ka": 0.1, "ball.kd": 0.6, …}`.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = self.values_now();
        let all = PyDict::new(py);
        for (owner, id, numbers) in values.iter() {
            let table = values.table();
            all.set_item(table.label(owner, id), named_value(py, table.parameter(id), numbers)?)?;
        }
        Ok(all)
    }

    /// Sets values: `set("ball.kd", 0.3)`, `set({"ball.kd": 0.3, "*.Cd": "#ff8000"})` or `set("ball.kd=0.3")`. A value
    /// is a number, three numbers, a colour `#rrggbb`, the name of a choice, or the path of an image. There is a
    /// warning for each value that is not used as given, because it is outside its range or breaks an invariant.
    #[pyo3(signature = (name, value=None))]
    fn set(&self, py: Python<'_>, name: &Bound<'_, PyAny>, value: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let given: Vec<NamedAssignment> = match (name.cast::<PyDict>(), value) {
            (Ok(several), None) => {
                several.iter().map(|(name, value)| assignment(&name.extract::<String>()?, &value)).collect::<PyResult<_>>()?
            }
            (Ok(_), Some(_)) => return Err(failure("give names with values, or one name and its value")),
            (Err(_), Some(value)) => vec![assignment(&name.extract::<String>()?, value)?],
            (Err(_), None) => {
                let text = name.extract::<String>()?;
                if !text.contains('=') {
                    return Err(failure(format!("give `{text}` a value: a number, three numbers, or a text")));
                }
                vec![text.parse().map_err(failure)?]
            }
        };
        self.assign(py, &given)
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let values = self.values_now();
        let (owner, id) = find(values.table(), name)?;
        named_value(py, values.table().parameter(id), values.get(owner, id))
    }

    fn __setitem__(&self, py: Python<'_>, name: &Bound<'_, PyAny>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set(py, name, Some(value))
    }

    /// Whether there is a value of this name.
    fn __contains__(&self, name: &Bound<'_, PyAny>) -> bool {
        name.extract::<String>().is_ok_and(|name| find(self.values_now().table(), &name).is_ok())
    }

    /// The names of all values.
    fn keys(&self) -> Vec<String> {
        let values = self.values_now();
        values.iter().map(|(owner, id, _)| values.table().label(owner, id)).collect()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.keys().into_pyobject(py)?.try_iter()
    }

    /// Moves a value as a slider does: to the nearest value that its range and the invariants allow while other values
    /// stay. Values that follow from it change too.
    #[pyo3(name = "move")]
    fn move_to(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let (owner, id) = find(self.values_now().table(), name)?;
        let value = numbers(self.values_now().table().parameter(id), value)?;
        lock(&self.values).move_to(owner, id, value);
        Ok(())
    }

    /// The range of a slider, as invariants and the other values leave it; `None` without limits.
    fn range(&self, name: &str) -> PyResult<Option<(f32, f32)>> {
        let values = self.values_now();
        let (owner, id) = find(values.table(), name)?;
        Ok(values.range_of(owner, id).map(|[low, high]| (low, high)))
    }

    /// The picture: linear RGB, float32, height × width × 3, row by row from the top, not clamped. The first picture
    /// traces the rays. Later ones evaluate the formula only.
    fn render<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        arrays::picture(py, self.frame(py)?)
    }

    /// The picture as bytes, uint8, height × width × 3, with the exposure, the tone curve and the transfer function of
    /// the session.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let frame = self.frame(py)?;
        let view = self.picture.view;
        let bytes = py.detach(|| quantise(&frame.linear, view));
        arrays::bytes(py, bytes, [frame.width, frame.height])
    }

    /// Writes the picture, whole or not at all: .png or .bmp, or .exr with linear numbers.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let mut frame = self.frame(py)?;
        let view = self.picture.view;
        py.detach(|| {
            frame.clean();
            save(&path, &frame, view)
        })
        .map_err(failure)
    }

    /// Writes the session with all values to a file, for the window and the command line too. Its formula and its scene
    /// must be files, or built in.
    fn save_session(&self, path: PathBuf) -> PyResult<()> {
        for (kind, (location, source)) in [(FileKind::Formula, &self.formula), (FileKind::Scene, &self.scene)] {
            let there = location.read(kind, Readable::Regular);
            if there.is_ok_and(|there| there.text() == source.text()) {
                continue;
            }
            let noun = kind.noun();
            return Err(failure(format!(
                "the {noun} of this session is a text, and `{location}` does not hold it; write the text to a file, and open \
                 the session with it"
            )));
        }
        let session = SessionFile {
            formula: self.formula.0.clone(),
            scene: self.scene.0.clone(),
            picture: self.picture,
            values: SessionFile::name_values(&self.values_now()),
        };
        session.save(&path).map_err(|error| failure(format!("cannot write `{}`: {}", path.display(), reason(&error))))
    }

    /// Pictures that differ in some values, as the command `sweep` makes them: `sweep("ball.kd=0..1:5")`. The last
    /// value changes fastest. The values of the session stay as they are.
    #[pyo3(signature = (*vary))]
    fn sweep(&self, py: Python<'_>, vary: Vec<String>) -> PyResult<Sweep> {
        sweep::sweep(py, self, &vary)
    }

    /// The varied values of the pictures of a sweep, by name, without the pictures: what workers share out.
    #[pyo3(signature = (*vary))]
    fn variations(&self, py: Python<'_>, vary: Vec<String>) -> PyResult<Vec<Py<PyDict>>> {
        sweep::variations(py, self, &vary)
    }

    /// Everything that tracing found, as arrays by name: `hits.pixel`, `hits.N`, `records.L`, `misses.direction`,
    /// `paths.parent` and others. A row of `records` is a pair of a hit and a light. The largest number of a column of
    /// whole numbers stands for none.
    fn hits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        hits::hits(py, self)
    }

    /// Holds a slider: `with session.drag("ball.kd") as drag: picture = drag(0.3)`. A picture computes only what the
    /// slider can change.
    fn drag(slf: Bound<'_, Self>, name: &str) -> PyResult<Drag> {
        Drag::new(slf, name)
    }

    /// The same scene, view and settings with another formula, and the values that both have. Rays are not traced
    /// again.
    fn with_formula(&self, formula: &Bound<'_, PyAny>) -> PyResult<Session> {
        let py = formula.py();
        let Formula { location, source, formula } = Formula::of(formula)?;
        let (values, warnings) = self.values_now().carry_over(&formula, self.subject.world.scene());
        let subject = Subject { formula: Arc::new(formula), ..self.subject.clone() };
        let tracing = py.detach(|| lock(&self.tracing).with_subject(subject.clone()));
        warnings.iter().try_for_each(|warning| warn(py, &warning.to_string()))?;
        Ok(Session {
            subject,
            picture: self.picture,
            formula: (location, source),
            scene: self.scene.clone(),
            values: Mutex::new(values),
            tracing: Mutex::new(tracing),
        })
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut frame = self.frame(py)?;
        let view = self.picture.view;
        let bytes = py.detach(|| {
            frame.clean();
            file_bytes(&frame, Format::Png, view)
        });
        Ok(PyBytes::new(py, &bytes.map_err(failure)?))
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.picture.size;
        format!("<Session: {} on {}, {width}×{height}>", self.formula.0, self.scene.0)
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(failure("a session cannot be pickled; open it in each process"))
    }
}

impl Session {
    /// The picture of the values now.
    fn frame(&self, py: Python<'_>) -> PyResult<Frame> {
        let numbers = vec![self.values_now().numbers().to_vec()];
        let mut picture = Frame::black(0, 0);
        let drawn = interruptible(py, |task| lock(&self.tracing).frames(&numbers, task, |frame| picture = frame))?;
        drawn.map_err(engine_failure)?;
        Ok(picture)
    }

    /// Sets values. There is a warning for each that is not used as given.
    pub(crate) fn assign(&self, py: Python<'_>, given: &[NamedAssignment]) -> PyResult<()> {
        let warnings = py.detach(|| {
            let mut values = lock(&self.values);
            let mut resolved = Vec::new();
            for given in given {
                resolved.extend(given.resolve(values.table()).map_err(failure)?);
            }
            Ok::<_, PyErr>(values.assign(&resolved))
        })?;
        warnings.iter().try_for_each(|warning| warn(py, &warning.to_string()))
    }

    /// The values now.
    pub(crate) fn values_now(&self) -> Values {
        lock(&self.values).clone()
    }
}
