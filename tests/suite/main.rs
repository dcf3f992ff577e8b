//! What the project promises, tested through its public interface.
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod agreement;
mod grammars;
mod house;
mod inspection;
mod materials;
mod models;
mod presets;
mod reference;
mod round_trip;
