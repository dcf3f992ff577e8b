//! What every backend must do: the pictures of the reference interpreter, on built-in and random formulas, and the same
//! pictures while sliders are dragged in any way.
//!
//! The tests know backends by their traits only; [`backends`] lists those that are tested, one of them written for this
//! purpose. Beside them, every operation of compiled code is held against its meaning, and elementary functions against
//! double precision.

mod accuracy;
mod columns;
mod drags;
mod formulas;
mod operations;
mod sessions;

use columns::ColumnsBackend;
use illuminator::backends::compiled::Jit;
use illuminator::evaluate::Backend;
use illuminator::jit::Width;
use std::sync::Arc;

/// The backends under test, those that need not be the reference: compiled code for vectors of each width that the
/// machine has, narrowest first, and columns.
pub(super) fn backends() -> Vec<Arc<dyn Backend>> {
    let of_width = |width| -> Arc<dyn Backend> { Arc::new(Jit::with_width(width)) };
    Width::supported().map(of_width).chain([Arc::new(ColumnsBackend) as Arc<dyn Backend>]).collect()
}
