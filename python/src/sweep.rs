//! Several pictures at once: sweeps. And the hits of all passes as arrays.

use crate::arrays;
use crate::diagnostics::{engine_failure, failure, warn_of_several};
use crate::session::{Session, named_value};
use crate::work::{interruptible, lock};
use illuminator::engine::{EngineError, Task};
use illuminator::lang::memory_size::MemorySize;
use illuminator::picture::Frame;
use illuminator::trace::tables::{ColumnStore, ColumnType, HitColumn, HitTables};
use illuminator::workspace::{Values, Variation, VariedValues};
use numpy::{IntoPyArray, PyArray4, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::io;

/// A sweep has at most this many pictures.
const MOST_PICTURES: usize = 10_000;

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
    let count = varied.iter().try_fold(1_usize, |count, varied| count.checked_mul(varied.count() as usize));
    let count = count.filter(|count| *count <= MOST_PICTURES && !varied.is_empty());
    let count =
        count.ok_or_else(|| failure(format!("give one to {MOST_PICTURES} pictures, as in `sweep(\"ball.kd=0..1:5\")`")))?;
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
    index: usize,
) -> PyResult<(Values, Bound<'py, PyDict>, Vec<String>)> {
    let mut rest = index;
    let mut steps = vec![0; varied.len()];
    for (step, varied) in steps.iter_mut().zip(varied).rev() {
        *step = (rest % varied.count() as usize) as u32;
        rest /= varied.count() as usize;
    }
    let mut assignments = Vec::new();
    for (varied, step) in varied.iter().zip(&steps) {
        varied.assign(*step, base, &mut assignments);
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

/// A column in memory.
enum Numbers {
    Whole(Vec<u32>),
    Real(Vec<f32>),
}

impl ColumnStore for Numbers {
    fn whole(&mut self, number: u32) -> io::Result<()> {
        if let Numbers::Whole(numbers) = self {
            numbers.push(number);
        }
        Ok(())
    }

    fn real(&mut self, numbers: &[f32]) -> io::Result<()> {
        if let Numbers::Real(all) = self {
            all.extend_from_slice(numbers);
        }
        Ok(())
    }
}

/// The hits of all passes as arrays by name, see [`Session`].
pub(crate) fn hits<'py>(py: Python<'py>, session: &Session) -> PyResult<Bound<'py, PyDict>> {
    let tables = interruptible(py, |task| filled(session, task))??;
    let all = PyDict::new(py);
    for table in tables.tables() {
        for (column, numbers) in table.columns {
            let array = match numbers {
                Numbers::Whole(numbers) => arrays::rows(py, numbers, column.components)?,
                Numbers::Real(numbers) => arrays::rows(py, numbers, column.components)?,
            };
            all.set_item(format!("{}.{}", table.name, column.name), array)?;
        }
    }
    Ok(all)
}

/// The tables of the hits of all passes.
fn filled(session: &Session, task: &Task) -> PyResult<HitTables<Numbers>> {
    let mut tracing = lock(&session.tracing);
    let mut tables = HitTables::new(&mut |_, column: &HitColumn| {
        Ok(match column.ty {
            ColumnType::U32 => Numbers::Whole(Vec::new()),
            ColumnType::F32 => Numbers::Real(Vec::new()),
        })
    })
    .map_err(failure)?;
    let allowed = tracing.memory();
    for pass in 0..session.picture.passes() {
        let hits = tracing.traced(pass, task).map_err(engine_failure)?;
        let needed = tables.bytes_with(&hits.counts());
        if needed > allowed {
            let (needed, allowed) = (MemorySize(needed), MemorySize(allowed));
            return Err(failure(format!("the hits take {needed} of memory, and {allowed} may be used; `memory=` allows more")));
        }
        tables.add_pass(&hits, task.cancelled).map_err(failure)?;
    }
    Ok(tables)
}
