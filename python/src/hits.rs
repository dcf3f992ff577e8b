//! The hits of all passes of a session, as arrays.

use crate::arrays;
use crate::diagnostics::{engine_failure, failure};
use crate::session::Session;
use crate::work::{interruptible, lock};
use illuminator::engine::Task;
use illuminator::lang::memory_size::MemorySize;
use illuminator::trace::tables::{ColumnStore, ColumnType, HitColumn, HitTables};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::io;

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
