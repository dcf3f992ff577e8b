//! Environments: the light that comes from all around a scene, as maps of radiance over the sphere of directions.
//!
//! 1. A [`RadianceMap`] says how much light comes from a direction, and draws directions in proportion to it.
//! 2. A [`Heading`] turns a map about the vertical axis. Maps themselves are never turned.
//! 3. The built-in maps are computed when they are needed, see [`PRESETS`].
//!
//! Files and the formats of images are not known here; see [`crate::workspace`]. Which light of a scene sends the
//! radiance is known in [`crate::world`].

mod cells;
mod compact;
mod heading;
mod latitude_longitude;
mod presets;
mod radiance_map;
mod texels;

pub use heading::Heading;
pub use presets::{EnvironmentPreset, PRESETS};
pub use radiance_map::{MAX_MAP_SIDE, RadianceMap, RadianceSample};
pub use texels::MapRepairs;
