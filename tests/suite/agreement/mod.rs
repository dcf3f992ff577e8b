//! Compiled code against the reference interpreter: every operation on awkward inputs, and random formulas on random hits; and the
//! elementary functions against double precision.

mod accuracy;
mod drags;
mod formulas;
mod operations;
mod sessions;
