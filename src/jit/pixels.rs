//! What becomes of contributions, as machine code for each width: adding them to the pixels of their hits, and writing pixels.
//!
//! Neither Cranelift nor portable code does this well:
//! - Which lanes of a line are added where differs from segment to segment. A loop over lanes, or a choice between vectors of several widths,
//!   would be mispredicted at nearly every segment. Masks need no branch.
//! - Written pixels go past the caches. They are not read again before the columns of all records have gone through the caches, which would first
//!   fetch what is overwritten.

mod adding;
mod assembler;
mod writing;

pub(super) use adding::{Strides, adding_code};
pub(super) use writing::writing_code;
