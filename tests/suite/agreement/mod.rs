//! Compiled code against the reference interpreter: every operation on awkward inputs, and random formulas on random hits.

mod formulas;
mod operations;
