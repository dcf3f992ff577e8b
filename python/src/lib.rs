//! The Python package `illuminator`: formulas, scenes, sessions and drags, with pictures as NumPy arrays.
//!
//! This crate translates between Python and the engine, and computes nothing itself. [`work`] runs the engine without
//! the lock of the interpreter, and lets Ctrl+C end it.

mod arrays;
mod at_point;
mod diagnostics;
mod drag;
mod formula;
mod hits;
mod scene;
mod session;
mod sweep;
mod texts;
mod work;

use illuminator::workspace::{FileKind, presets};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The built-in files: `{"session": {"default": "…", …}, "formula": …, "scene": …, "material": …}`, each name with a
/// line about it.
#[pyfunction]
#[pyo3(name = "presets")]
fn presets_by_kind(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for kind in FileKind::ALL {
        let of_kind = PyDict::new(py);
        for preset in presets::all(kind) {
            of_kind.set_item(preset.name, preset.about)?;
        }
        all.set_item(kind.word(), of_kind)?;
    }
    Ok(all)
}

/// The compiled part of the package.
#[pymodule]
fn _illuminator(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("IlluminatorError", py.get_type::<diagnostics::IlluminatorError>())?;
    module.add("TextError", py.get_type::<diagnostics::TextError>())?;
    module.add("IlluminatorWarning", py.get_type::<diagnostics::IlluminatorWarning>())?;
    module.add_class::<diagnostics::Diagnostic>()?;
    module.add_class::<diagnostics::Place>()?;
    module.add_class::<formula::Formula>()?;
    module.add_class::<formula::Parameter>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<session::Session>()?;
    module.add_class::<drag::Drag>()?;
    module.add_class::<sweep::Sweep>()?;
    module.add_function(wrap_pyfunction!(presets_by_kind, module)?)?;
    module.add_function(wrap_pyfunction!(diagnostics::check, module)?)?;
    Ok(())
}
