//! Sweeps: pictures that differ in some values.

use crate::diagnostics::{engine_failure, failure, warn_of_several};
use crate::session::{Session, named_value};
use crate::work::{interruptible, lock};
use illuminator::engine::EngineError;
use illuminator::lang::memory_size::MemorySize;
use illuminator::picture::Frame;
use illuminator::workspace::variation::{MOST_PICTURES, count_pictures, steps_of_picture};
use illuminator::workspace::{Values, Variation, VariedValues};
use numpy::{IntoPyArray, PyArray4, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The pictures of a sweep.
#[pyclass(module = "illuminator", frozen, get_all)]
pub(crate) struct Sweep {
    /// The varied values of each picture, by name, as they are used.
    values: Vec<Py<PyDict>>,
    /// The pictures: linear RGB, float32, picture × height × width × 3.
    pictures: Py<PyArray4<f32>>,
}

#[pymethods]
impl Sweep {
    fn __len__(&self) -> usize {
        self.values.len()
    }

    /// The values and the picture of this index.
    fn __getitem__<'py>(&self, py: Python<'py>, index: isize) -> PyResult<(Py<PyDict>, Bound<'py, PyAny>)> {
        let count = self.values.len() as isize;
        let at = if index < 0 { index + count } else { index };
        let values = usize::try_from(at).ok().and_then(|at| self.values.get(at));
        let values = values.ok_or_else(|| pyo3::exceptions::PyIndexError::new_err(format!("there are {count} pictures")))?;
        Ok((values.clone_ref(py), self.pictures.bind(py).get_item(at)?))
    }

    fn __repr__(&self) -> String {
        format!("<Sweep of {} pictures>", self.values.len())
    }
}

/// The values of all pictures of a sweep, and the varied ones by name.
fn cells(py: Python<'_>, session: &Session, vary: &[String]) -> PyResult<Vec<(Values, Py<PyDict>)>> {
    let base = session.values_now();
    let varied = vary
        .iter()
        .map(|text| text.parse::<Variation>().and_then(|variation| variation.resolve(&base)).map_err(failure))
        .collect::<PyResult<Vec<VariedValues>>>()?;
    if varied.is_empty() {
        return Err(failure("give what is varied, as in `sweep(\"ball.kd=0..1:5\")`"));
    }
    let most = format!("pictures; a sweep can have {MOST_PICTURES}");
    let count = count_pictures(&varied).map_err(|count| failure(format!("that would be {count} {most}")))?;
    let mut warnings = Vec::new();
    let cells = (0..count)
        .map(|index| {
            let (values, names, found) = cell(py, &base, &varied, index)?;
            warnings.extend(found);
            Ok((values, names.unbind()))
        })
        .collect::<PyResult<_>>()?;
    warn_of_several(py, &warnings)?;
    Ok(cells)
}

/// The varied values of all pictures of a sweep, see [`Session`].
pub(crate) fn variations(py: Python<'_>, session: &Session, vary: &[String]) -> PyResult<Vec<Py<PyDict>>> {
    Ok(cells(py, session, vary)?.into_iter().map(|(_, names)| names).collect())
}

/// Makes the pictures of a sweep, see [`Session`].
pub(crate) fn sweep(py: Python<'_>, session: &Session, vary: &[String]) -> PyResult<Sweep> {
    let (cells, values): (Vec<Values>, Vec<Py<PyDict>>) = cells(py, session, vary)?.into_iter().unzip();
    let all: Vec<Vec<f32>> = cells.iter().map(|values| values.numbers().to_vec()).collect();
    let count = all.len();
    let (size, length) = room(py, session, count)?;
    let numbers = interruptible(py, |task| -> Result<Vec<f32>, EngineError> {
        let mut pictures = Vec::with_capacity(length);
        let add = |frame: Frame| pictures.extend_from_slice(frame.linear.as_flattened());
        lock(&session.tracing).frames(&all, task, add)?;
        Ok(pictures)
    })?
    .map_err(engine_failure)?;
    let [width, height] = size.map(|side| side as usize);
    let pictures = numbers.into_pyarray(py).reshape([count, height, width, 3])?.unbind();
    Ok(Sweep { values, pictures })
}

/// The size of the pictures, and how many numbers this many have, if there is memory for them.
fn room(py: Python<'_>, session: &Session, count: usize) -> PyResult<([u32; 2], usize)> {
    let [width, height] = session.picture.size;
    let memory = py.detach(|| lock(&session.tracing).memory());
    let numbers = count as u64 * u64::from(width) * u64::from(height) * 3;
    let (needed, allowed) = (numbers * size_of::<f32>() as u64, memory);
    match usize::try_from(numbers) {
        Ok(length) if needed <= allowed => Ok(([width, height], length)),
        Ok(_) | Err(_) => {
            let (needed, allowed) = (MemorySize(needed), MemorySize(allowed));
            Err(failure(format!("{count} pictures take {needed} of memory, and {allowed} may be used; make fewer at once")))
        }
    }
}

/// The values of a picture, the varied ones by name, and warnings. The last variation changes fastest.
fn cell<'py>(
    py: Python<'py>,
    base: &Values,
    varied: &[VariedValues],
    index: u32,
) -> PyResult<(Values, Bound<'py, PyDict>, Vec<String>)> {
    let mut assignments = Vec::new();
    for (varied, step) in varied.iter().zip(steps_of_picture(index, varied)) {
        varied.assign(step, base, &mut assignments);
    }
    let mut values = base.clone();
    let warnings = values.assign(&assignments).iter().map(ToString::to_string).collect();
    let names = PyDict::new(py);
    for assignment in &assignments {
        let (owner, id) = (assignment.owner, assignment.parameter);
        let table = values.table();
        names.set_item(table.label(owner, id), named_value(py, table.parameter(id), values.get(owner, id))?)?;
    }
    Ok((values, names, warnings))
}
