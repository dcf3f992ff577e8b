//! What every backend must do: draw the pictures of the reference interpreter, for built-in and random formulas, also
//! while sliders are dragged.
//!
//! The tests know backends by their traits only. [`backends`] lists those under test; one of them is written for this
//! purpose. Other tests compare every compiled operation with its meaning, and elementary functions with double
//! precision.

mod accuracy;
mod choices;
mod columns;
mod drags;
mod formulas;
mod operations;
mod passes;
mod sessions;
mod surface;
mod textures;
mod visible;

use columns::ColumnsBackend;
use illuminator::backends::compiled::Jit;
use illuminator::evaluate::Backend;
use illuminator::jit::Width;
use std::sync::Arc;

/// The backends under test: compiled code for each width of vectors that the machine has, narrowest first, and columns.
pub(super) fn backends() -> Vec<Arc<dyn Backend>> {
    let of_width = |width| -> Arc<dyn Backend> { Arc::new(Jit::with_width(width)) };
    Width::supported().map(of_width).chain([Arc::new(ColumnsBackend) as Arc<dyn Backend>]).collect()
}

/// Compiled code for each width of vectors that the machine has.
pub(super) fn compiled() -> Vec<Arc<dyn Backend>> {
    Width::supported().map(|width| Arc::new(Jit::with_width(width)) as Arc<dyn Backend>).collect()
}
