//! The forms of the Language Server Protocol that the server and `check --json` share: [`positions`] are places in
//! texts, [`reports`] are diagnostics.

pub(super) mod positions;
pub(super) mod reports;
