//! What a user edits: parameter values, sessions, materials, and the files that hold them.
//!
//! Values are kept by owner and parameter, within their ranges and invariants. The engine makes pictures of them.
//! Nothing here knows of windows or command lines; both are built on it.

mod asset_store;
pub mod assignment;
pub mod carried;
mod file_kind;
mod images;
mod location;
pub mod materials;
pub mod measured_files;
pub mod owner;
pub mod parameter_table;
pub mod presets;
pub mod project;
mod recognise;
pub mod session;
pub(crate) mod spanned_toml;
pub mod textures;
pub mod values;
pub mod variation;
pub mod warning;

pub use asset_store::{AssetLoadError, AssetStore};
pub use assignment::{Assignment, FileValue, NamedAssignment};
pub use file_kind::FileKind;
#[cfg(feature = "window")]
pub(crate) use images::LINEAR_SUFFIXES;
pub(crate) use location::PRESET;
pub use location::{Location, read_source, unknown_preset};
pub use materials::{Library, Material, Materials};
pub use owner::{OwnerId, Owners};
pub use parameter_table::ParameterTable;
pub use recognise::{kind_of, kind_of_file};
pub use session::Session;
pub use values::Values;
pub use variation::{Variation, VariedValues};
pub use warning::ValueWarning;
