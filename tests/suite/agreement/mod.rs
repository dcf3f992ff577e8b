//! What every backend must do: draw the pictures of the reference interpreter, for built-in and random formulas, also
//! while sliders are dragged.
//!
//! The tests know backends by their traits only. [`backends`] lists those under test; one of them is written for this
//! purpose. Other tests compare every compiled operation with its meaning, and elementary functions with double
//! precision.

mod accuracy;
mod choices;
mod columns;
mod derivatives;
mod drags;
mod formulas;
#[cfg(feature = "gpu")]
mod gpu;
mod measured;
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
use std::cell::RefCell;
use std::sync::Arc;

thread_local! {
    /// The only backend under test in this thread, if the others are left out.
    static ONLY: RefCell<Option<Arc<dyn Backend>>> = const { RefCell::new(None) };
}

/// Whether the only backend under test draws every picture of a drag in full.
pub(super) fn only_draws_in_full() -> bool {
    ONLY.with_borrow(|only| only.as_ref().is_some_and(|only| only.name() == "gpu"))
}

/// The backends under test: compiled code for each width of vectors that the machine has, narrowest first, and columns.
pub(super) fn backends() -> Vec<Arc<dyn Backend>> {
    let columns = || vec![Arc::new(ColumnsBackend) as Arc<dyn Backend>];
    let others = if ONLY.with_borrow(Option::is_none) { columns() } else { Vec::new() };
    compiled().into_iter().chain(others).collect()
}

/// Those of them that give the weights of rays: compiled code for each width of vectors that the machine has.
pub(super) fn compiled() -> Vec<Arc<dyn Backend>> {
    let all = || Width::supported().map(|width| Arc::new(Jit::with_width(width)) as Arc<dyn Backend>).collect();
    ONLY.with_borrow(|only| only.as_ref().map_or_else(all, |only| vec![Arc::clone(only)]))
}
