//! Sessions: a formula on a scene, with the values of all parameters, and its pictures.

mod names;
mod open;
mod passes;

use crate::arrays;
use crate::diagnostics::{failure, warn};
use crate::drag::Drag;
use crate::formula::Formula;
use crate::scene::Scene;
use crate::sweep::{self, Sweep};
use crate::work::{interruptible, lock};
use illuminator::picture::{Format, Frame, ViewTransform, file_bytes, quantise, save};
use illuminator::workspace::{NamedAssignment, Session as SessionFile, Values};
use names::assignment;
pub(crate) use names::{find, named_value, numbers};
use numpy::PyArray3;
use open::{Given, open};
pub(crate) use passes::{State, mean};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Mutex;

/// A formula on a scene, with the values of all parameters.
#[pyclass(module = "illuminator", frozen)]
pub(crate) struct Session {
    pub(crate) state: Mutex<State>,
}

impl From<State> for Session {
    fn from(state: State) -> Self {
        Self { state: Mutex::new(state) }
    }
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
        session: Option<PathBuf>,
        formula: Option<Bound<'_, PyAny>>,
        scene: Option<Bound<'_, PyAny>>,
        size: Option<[u32; 2]>,
        samples: Option<u32>,
        depth: Option<u32>,
        shadows: Option<bool>,
        ior: Option<f64>,
        background: Option<[f32; 3]>,
        set: Option<Bound<'_, PyDict>>,
        materials: Option<HashMap<String, String>>,
        backend: Option<&str>,
        threads: Option<usize>,
        memory: Option<u64>,
    ) -> PyResult<Self> {
        let set = set.iter().flat_map(|set| set.iter());
        let set = set.map(|(name, value)| assignment(&name.extract::<String>()?, &value)).collect::<PyResult<_>>()?;
        let materials = materials.unwrap_or_default();
        let materials = materials.iter().map(|(body, name)| format!("{body}={name}").parse().map_err(failure));
        let given = Given {
            session,
            formula: formula.map(|formula| open::location::<Formula>(&formula)).transpose()?,
            scene: scene.map(|scene| open::location::<Scene>(&scene)).transpose()?,
            size,
            samples,
            depth,
            shadows,
            ior,
            background,
            set,
            materials: materials.collect::<PyResult<_>>()?,
            memory,
        };
        Ok(State::new(open(py, given)?, backend, threads, memory)?.into())
    }

    /// Width and height of the picture, in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let [width, height] = lock(&self.state).picture.size;
        (width, height)
    }

    /// How many passes the picture is the mean of.
    #[getter]
    fn samples(&self) -> u32 {
        lock(&self.state).picture.passes()
    }

    /// The formula.
    #[getter]
    fn formula(&self) -> Formula {
        let state = lock(&self.state);
        let (location, source) = state.formula.clone();
        Formula { location, source, formula: state.subject.formula.as_ref().clone() }
    }

    /// The names of the bodies.
    #[getter]
    fn bodies(&self) -> Vec<String> {
        lock(&self.state).subject.world.scene().bodies.iter().map(|body| body.name.clone()).collect()
    }

    /// The names of the lights.
    #[getter]
    fn lights(&self) -> Vec<String> {
        lock(&self.state).subject.world.scene().lights.iter().map(|light| light.name.clone()).collect()
    }

    /// The values of all parameters, by name: `{"ka": 0.1, "ball.kd": 0.6, …}`.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = lock(&self.state);
        let all = PyDict::new(py);
        for (owner, id, numbers) in state.values.iter() {
            let table = state.values.table();
            all.set_item(table.label(owner, id), named_value(py, table.parameter(id), numbers)?)?;
        }
        Ok(all)
    }

    /// Sets values: `set("ball.kd", 0.3)`, `set({"ball.kd": 0.3, "*.Cd": "#ff8000"})` or `set("ball.kd=0.3")`. A value
    /// is a number, three numbers, a colour `#rrggbb`, the name of a choice, or the path of an image. There is a warning
    /// for each value that is not used as given, because it is outside its range or breaks an invariant.
    #[pyo3(signature = (name, value=None))]
    fn set(&self, py: Python<'_>, name: &Bound<'_, PyAny>, value: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let given: Vec<NamedAssignment> = match (name.cast::<PyDict>(), value) {
            (Ok(several), None) => {
                several.iter().map(|(name, value)| assignment(&name.extract::<String>()?, &value)).collect::<PyResult<_>>()?
            }
            (Ok(_), Some(_)) => return Err(failure("give names with values, or one name and its value")),
            (Err(_), Some(value)) => vec![assignment(&name.extract::<String>()?, value)?],
            (Err(_), None) => vec![name.extract::<String>()?.parse().map_err(failure)?],
        };
        let warnings = self.assign(py, &given)?;
        warnings.iter().try_for_each(|warning| warn(py, warning))
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let state = lock(&self.state);
        let (owner, id) = find(state.values.table(), name)?;
        named_value(py, state.values.table().parameter(id), state.values.get(owner, id))
    }

    fn __setitem__(&self, py: Python<'_>, name: &Bound<'_, PyAny>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set(py, name, Some(value))
    }

    /// Moves a value as a slider does: to the nearest value that its range and the invariants allow while other values
    /// stay. Values that follow from it change too.
    #[pyo3(name = "move")]
    fn move_to(&self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let mut state = lock(&self.state);
        let (owner, id) = find(state.values.table(), name)?;
        let value = numbers(state.values.table().parameter(id), value)?;
        state.values.move_to(owner, id, value);
        Ok(())
    }

    /// The range of a slider, as invariants and the other values leave it; `None` without limits.
    fn range(&self, name: &str) -> PyResult<Option<(f32, f32)>> {
        let state = lock(&self.state);
        let (owner, id) = find(state.values.table(), name)?;
        Ok(state.values.range_of(owner, id).map(|[low, high]| (low, high)))
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
        let view = self.view();
        let bytes = py.detach(|| quantise(&frame.linear, view));
        arrays::bytes(py, bytes, [frame.width, frame.height])
    }

    /// Writes the picture, whole or not at all: .png or .bmp, or .exr with linear numbers.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let mut frame = self.frame(py)?;
        let view = self.view();
        py.detach(|| {
            frame.clean();
            save(&path, &frame, view)
        })
        .map_err(failure)
    }

    /// Writes the session with all values, as a file that every part of Illuminator opens.
    fn save_session(&self, path: PathBuf) -> PyResult<()> {
        let state = lock(&self.state);
        let session = SessionFile {
            formula: state.formula.0.clone(),
            scene: state.scene.clone(),
            picture: state.picture,
            values: SessionFile::name_values(&state.values),
        };
        session.save(&path).map_err(|error| failure(format!("cannot write `{}`: {error}", path.display())))
    }

    /// Pictures that differ in one value or two, as the command `sweep` makes them: `sweep("ball.kd=0..1:5")`. The last
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
        sweep::hits(py, self)
    }

    /// Holds a slider: `with session.drag("ball.kd") as drag: picture = drag(0.3)`. A picture computes only what the
    /// slider can change.
    fn drag(slf: Bound<'_, Self>, name: &str) -> PyResult<Drag> {
        Drag::new(slf, name)
    }

    /// The same scene, view and settings with another formula, and the values that both have. Rays are not traced again.
    fn with_formula(&self, formula: &Bound<'_, PyAny>) -> PyResult<Session> {
        let py = formula.py();
        let formula = match formula.cast::<Formula>() {
            Ok(formula) => formula.get().clone(),
            Err(_) => py.get_type::<Formula>().call1((formula,))?.cast::<Formula>().map_err(PyErr::from)?.get().clone(),
        };
        let (state, warnings) = lock(&self.state).with_formula(formula);
        warnings.iter().try_for_each(|warning| warn(py, warning))?;
        Ok(state.into())
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let mut frame = self.frame(py)?;
        let view = self.view();
        let bytes = py.detach(|| {
            frame.clean();
            file_bytes(&frame, Format::Png, view)
        });
        Ok(PyBytes::new(py, &bytes.map_err(failure)?))
    }

    fn __repr__(&self) -> String {
        let state = lock(&self.state);
        let [width, height] = state.picture.size;
        format!("<Session: {} on {}, {width}×{height}>", state.formula.0, state.scene)
    }
}

impl Session {
    /// How colours become bytes.
    pub(crate) fn view(&self) -> ViewTransform {
        lock(&self.state).picture.view
    }

    /// The picture.
    fn frame(&self, py: Python<'_>) -> PyResult<Frame> {
        interruptible(py, |task| lock(&self.state).frame(task))?.map_err(crate::diagnostics::engine_failure)
    }

    /// Sets values. Returns warnings.
    pub(crate) fn assign(&self, py: Python<'_>, given: &[NamedAssignment]) -> PyResult<Vec<String>> {
        py.detach(|| {
            let mut state = lock(&self.state);
            let mut resolved = Vec::new();
            for given in given {
                resolved.extend(given.resolve(state.values.table()).map_err(failure)?);
            }
            Ok(state.values.assign(&resolved).iter().map(ToString::to_string).collect())
        })
    }

    /// The values now.
    pub(crate) fn values_now(&self) -> Values {
        lock(&self.state).values.clone()
    }
}
