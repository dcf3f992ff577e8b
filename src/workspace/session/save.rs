//! Writing a session as text.

use crate::picture::{ToneCurve, Transfer};
use crate::workspace::session::{OwnerName, Session};
use crate::workspace::spanned_toml::{TomlNumber, VERSION};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The file, key by key.
#[derive(Serialize)]
struct SessionFile<'s> {
    version: i64,
    formula: String,
    scene: String,
    size: [u32; 2],
    depth: u32,
    shadows: bool,
    ior: f64,
    /// Left out if the session does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u32>,
    srgb: bool,
    /// Left out if it is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    exposure: Option<TomlNumber>,
    /// Left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    curve: Option<&'static str>,
    global: OwnerValues<'s>,
    bodies: BTreeMap<&'s str, OwnerValues<'s>>,
    lights: BTreeMap<&'s str, OwnerValues<'s>>,
}

/// The values of one owner by parameter name.
type OwnerValues<'s> = BTreeMap<&'s str, TomlNumber>;

pub(super) fn to_toml(session: &Session, folder: &Path) -> Result<String, toml::ser::Error> {
    let view = session.picture.view;
    let mut file = SessionFile {
        version: VERSION,
        formula: session.formula.relative_to(folder),
        scene: session.scene.relative_to(folder),
        size: session.picture.size,
        depth: session.picture.depth,
        shadows: session.picture.shadows,
        ior: session.picture.default_index,
        samples: session.picture.samples,
        srgb: view.transfer == Transfer::Srgb,
        exposure: Some(view.exposure).filter(|stops| *stops != 0.0).map(TomlNumber::Scalar),
        curve: Some(view.curve).filter(|curve| *curve != ToneCurve::None).map(ToneCurve::name),
        global: OwnerValues::new(),
        bodies: BTreeMap::new(),
        lights: BTreeMap::new(),
    };
    for value in &session.values {
        let group = match &value.owner {
            OwnerName::Global => &mut file.global,
            OwnerName::Body(name) => file.bodies.entry(name).or_default(),
            OwnerName::Light(name) => file.lights.entry(name).or_default(),
        };
        group.insert(&value.parameter, (&value.value.clone().relative_to(folder)).into());
    }
    toml::to_string(&file)
}
