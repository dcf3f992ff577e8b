//! What a user edits: parameter values, sessions, materials and the files they name.
//!
//! No window, no command line: both are served by these. Held are values by owner and parameter, settled so that ranges and
//! invariants hold; how they reach a picture is the engine's business. And what a window remembers for its user: settings, recent
//! files, unsaved texts.

pub mod assignment;
mod document;
pub mod drafts;
pub mod files;
pub mod folders;
pub mod materials;
pub mod owner;
pub mod project;
pub mod recent;
pub mod roster;
pub mod session;
pub mod settings;
pub mod values;
pub mod warning;

pub use assignment::{Assignment, Setting};
pub use materials::{Library, Material, Shelf};
pub use owner::{OwnerId, Owners};
pub use roster::Roster;
pub use session::Session;
pub use values::Values;
pub use warning::Warning;
