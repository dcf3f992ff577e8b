//! What every backend must do: the pictures of the reference interpreter, on built-in and random formulas, and the same pictures while
//! sliders are dragged in any way.
//!
//! The tests know backends by their traits only; [`backends`] lists those that are tested, one of them written for this purpose. Beside
//! them, every operation of compiled code is held against its meaning, and elementary functions against double precision.

mod accuracy;
mod columns;
mod drags;
mod formulas;
mod operations;
mod sessions;

use columns::ColumnsBackend;
use illuminator::backends::DEFAULT;
use illuminator::evaluate::Backend;
use std::sync::Arc;

/// The backends under test, those that need not be the reference.
pub(super) fn backends() -> Vec<Arc<dyn Backend>> {
    vec![DEFAULT.make(), Arc::new(ColumnsBackend)]
}
