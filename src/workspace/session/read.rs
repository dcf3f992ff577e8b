//! The text of a session into names and numbers.

use crate::lang::diagnostic::{Diagnostic, Diagnostics};
use crate::lang::source::{Source, Span};
use crate::trace::{MAX_DEPTH, MAX_SIDE};
use crate::workspace::Location;
use crate::workspace::session::{NamedValue, OwnerName, PictureSettings, Session};
use crate::workspace::spanned_toml::{Entry, Value, check_version, entries, missing, parse as parse_toml, unknown_key};

/// What may stand in a session, outside of tables.
pub(in crate::workspace) const KEYS: [&str; 11] =
    ["version", "formula", "scene", "size", "depth", "shadows", "ior", "srgb", "global", "bodies", "lights"];

pub(super) fn parse(source: &Source) -> Result<(Session, Diagnostics), Diagnostics> {
    let table = parse_toml(source)?;
    let mut reader = Reader::default();
    let mut version = None;
    for entry in entries(&table) {
        match entry.key {
            "version" => version = Some(entry.value),
            "formula" => reader.formula = reader.take(location(entry.value)),
            "scene" => reader.scene = reader.take(location(entry.value)),
            "size" => reader.size(entry.value),
            "depth" => {
                if let Some(depth) = reader.take(entry.value.whole(1..i64::from(MAX_DEPTH) + 1)) {
                    reader.picture.depth = depth as u32;
                }
            }
            "shadows" => {
                if let Some(shadows) = reader.take(entry.value.truth()) {
                    reader.picture.shadows = shadows;
                }
            }
            "ior" => reader.index(entry.value),
            "srgb" => {
                if let Some(srgb) = reader.take(entry.value.truth()) {
                    reader.picture.srgb = srgb;
                }
            }
            "global" => reader.values(&OwnerName::Global, entry.key_span, entry.value),
            "bodies" => reader.owners(entry.value, OwnerName::Body),
            "lights" => reader.owners(entry.value, OwnerName::Light),
            _ => reader.diagnostics.push(unknown_key(&entry, &KEYS)),
        }
    }
    check_version(version, &mut reader.diagnostics);
    reader.finish(&table)
}

fn location(value: Value) -> Result<Location, Diagnostic> {
    let text = value.text()?;
    if text.trim().is_empty() {
        return Err(Diagnostic::error("no file is named").at(value.span, "expected a path or `preset:NAME`"));
    }
    Ok(Location::new(text))
}

/// What has been read so far.
#[derive(Default)]
struct Reader {
    formula: Option<Location>,
    scene: Option<Location>,
    picture: PictureSettings,
    values: Vec<NamedValue>,
    diagnostics: Diagnostics,
}

impl Reader {
    /// What was read, or nothing after reporting why.
    fn take<T>(&mut self, outcome: Result<T, Diagnostic>) -> Option<T> {
        outcome.map_err(|diagnostic| self.diagnostics.push(diagnostic)).ok()
    }

    fn size(&mut self, value: Value) {
        let Some(sides) = self.take(value.list::<2>("width and height, `[640, 480]`")) else { return };
        for (index, side) in sides.into_iter().enumerate() {
            if let Some(side) = self.take(side.whole(1..i64::from(MAX_SIDE) + 1)) {
                self.picture.size[index] = side as u32;
            }
        }
    }

    fn index(&mut self, value: Value) {
        let positive = value.number().and_then(|index| {
            let wrong = || {
                Diagnostic::error(format!("the refractive index {index} is not positive")).at(value.span, "expected more than 0")
            };
            if index > 0.0 { Ok(index) } else { Err(wrong()) }
        });
        if let Some(index) = self.take(positive) {
            self.picture.default_index = index;
        }
    }

    /// `[bodies.NAME]` or `[lights.NAME]`: the table of tables.
    fn owners(&mut self, value: Value, owner: impl Fn(String) -> OwnerName) {
        let Some(table) = self.take(value.table()) else { return };
        for entry in entries(table) {
            self.values(&owner(entry.key.to_owned()), entry.key_span, entry.value);
        }
    }

    /// The values of one owner.
    fn values(&mut self, owner: &OwnerName, owner_span: Span, value: Value) {
        let Some(table) = self.take(value.table()) else { return };
        for Entry { key, key_span, value } in entries(table) {
            if let Some(constant) = self.take(value.constant()) {
                let spans = [owner_span, key_span];
                self.values.push(NamedValue { owner: owner.clone(), parameter: key.to_owned(), value: constant, spans });
            }
        }
    }

    fn finish(mut self, table: &toml::de::DeTable) -> Result<(Session, Diagnostics), Diagnostics> {
        for (key, example) in [("formula", "preset:phong"), ("scene", "preset:glass")] {
            if !entries(table).iter().any(|entry| entry.key == key) {
                let line = format!("{key} = \"{example}\"");
                self.diagnostics.push(missing(&format!("the session names no {key}"), &line));
            }
        }
        self.diagnostics.sort();
        match (self.formula, self.scene) {
            (Some(formula), Some(scene)) if !self.diagnostics.has_errors() => {
                Ok((Session { formula, scene, picture: self.picture, values: self.values }, self.diagnostics))
            }
            _ => Err(self.diagnostics),
        }
    }
}
