//! Machine code for pixels, for each width: it adds contributions to the pixels of their hits, and writes pixels.
//!
//! Cranelift and portable code do not do this well:
//! - Each segment adds other lanes of a line. A loop over lanes, or a choice between vectors of several widths, would
//!   be mispredicted at nearly every segment. Masks need no branch.
//! - Written pixels bypass the caches. They are not read again before the columns of all records have passed through
//!   the caches, and an ordinary store would first load what it overwrites.

mod adding;
mod assembler;
mod writing;

pub(super) use adding::{Gaps, Strides, adding_code};
pub(super) use writing::{Writing, writing_code};
