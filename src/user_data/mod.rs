//! What the program keeps for its user between runs: settings, recent files, drafts of unsaved work, and the folders
//! for them.
//!
//! The window alone needs settings, recent files and drafts, so they are compiled with it only. The window decides
//! when something is kept or read.

#[cfg(feature = "window")]
pub mod desktop_theme;
#[cfg(feature = "window")]
pub mod drafts;
pub mod folders;
#[cfg(feature = "window")]
pub mod recent;
#[cfg(feature = "window")]
pub mod settings;
#[cfg(feature = "window")]
mod store;

pub use folders::Folders;
