//! Parsing the text of a session.

use crate::lang::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::lang::source::{Source, SourceSpan};
use crate::picture::{EXPOSURES, ToneCurve, Transfer};
use crate::trace::{MAX_DEPTH, MAX_PASSES, MAX_SIDE};
use crate::workspace::Location;
use crate::workspace::session::{NamedValue, OwnerName, PictureSettings, Session};
use crate::workspace::spanned_toml::{
    TomlEntry, VERSION, Value, check_version, entries, missing, parse_in_parts as parse_toml_in_parts, unknown_key,
};

/// The keys of a session, outside of tables.
pub(in crate::workspace) const KEYS: [&str; 14] = [
    "version", "formula", "scene", "size", "depth", "shadows", "ior", "samples", "srgb", "exposure", "curve", "global", "bodies",
    "lights",
];

/// The keys that every session has, each with a line as an example.
const NEEDED: [(&str, &str); 2] = [("formula", "formula = \"preset:phong\""), ("scene", "scene = \"preset:glass\"")];

pub(super) fn parse(source: &Source) -> Result<(Session, Diagnostics), Diagnostics> {
    match parse_in_parts(source) {
        (Some(session), diagnostics) if !diagnostics.has_errors() => Ok((session, diagnostics)),
        (_, diagnostics) => Err(diagnostics),
    }
}

pub(super) fn parse_in_parts(source: &Source) -> (Option<Session>, Diagnostics) {
    let (table, syntax_errors) = parse_toml_in_parts(source);
    let is_whole = syntax_errors.is_empty();
    let mut reader = SessionReader::default();
    let mut version = None;
    for entry in entries(&table) {
        match entry.key {
            "version" => version = Some(entry.value),
            "formula" => reader.formula = reader.report_error(location(entry.value)),
            "scene" => reader.scene = reader.report_error(location(entry.value)),
            "size" => reader.size(entry.value),
            "depth" => {
                if let Some(depth) = reader.report_error(entry.value.whole(1..i64::from(MAX_DEPTH) + 1)) {
                    reader.picture.depth = depth as u32;
                }
            }
            "shadows" => {
                if let Some(shadows) = reader.report_error(entry.value.truth()) {
                    reader.picture.shadows = shadows;
                }
            }
            "ior" => reader.index(entry.value),
            "samples" => {
                if let Some(samples) = reader.report_error(entry.value.whole(1..i64::from(MAX_PASSES) + 1)) {
                    reader.picture.samples = Some(samples as u32);
                }
            }
            "srgb" => {
                if let Some(srgb) = reader.report_error(entry.value.truth()) {
                    reader.picture.view.transfer = if srgb { Transfer::Srgb } else { Transfer::Linear };
                }
            }
            "exposure" => reader.exposure(entry.value),
            "curve" => {
                if let Some(curve) = reader.report_error(curve(entry.value)) {
                    reader.picture.view.curve = curve;
                }
            }
            "global" => reader.values(&OwnerName::Global, entry.key_span, entry.value),
            "bodies" => reader.owners(entry.value, OwnerName::Body),
            "lights" => reader.owners(entry.value, OwnerName::Light),
            key => {
                let meant = nearest(key, KEYS).and_then(|near| NEEDED.iter().find(|(needed, _)| *needed == near));
                match meant.filter(|(needed, _)| !entries(&table).iter().any(|entry| entry.key == *needed)) {
                    Some((needed, line)) => reader.diagnostics.push(
                        Diagnostic::error(format!("the session names no {needed}"))
                            .at(entry.key_span, "unknown key")
                            .help(format!("did you mean `{needed}`? Expected a line such as `{line}`")),
                    ),
                    None => reader.diagnostics.push(unknown_key(&entry, &KEYS)),
                }
            }
        }
    }
    let is_of_other_version = version.is_some_and(|value| value.whole(0..i64::MAX).is_ok_and(|version| version != VERSION));
    check_version(version, &mut reader.diagnostics);
    let (session, diagnostics) = reader.finish(&table);
    // What follows an error of the syntax may be read in a wrong way, so more errors would be misleading.
    (session.filter(|_| !is_of_other_version), if is_whole { diagnostics } else { syntax_errors })
}

fn location(value: Value) -> Result<Location, Diagnostic> {
    let text = value.text()?;
    if text.trim().is_empty() {
        return Err(Diagnostic::error("the path is empty").at(value.span, "expected a path or `preset:NAME`"));
    }
    Ok(Location::new(text))
}

fn curve(value: Value) -> Result<ToneCurve, Diagnostic> {
    ToneCurve::named(value.text()?).ok_or_else(|| {
        let names = ToneCurve::ALL.map(|curve| format!("`{}`", curve.name())).join(", ");
        Diagnostic::error("there is no such tone curve").at(value.span, format!("expected one of {names}"))
    })
}

/// What has been parsed so far.
#[derive(Default)]
struct SessionReader {
    formula: Option<Location>,
    scene: Option<Location>,
    picture: PictureSettings,
    values: Vec<NamedValue>,
    diagnostics: Diagnostics,
}

impl SessionReader {
    /// The value of an outcome; `None` after reporting an error.
    fn report_error<T>(&mut self, outcome: Result<T, Diagnostic>) -> Option<T> {
        outcome.map_err(|diagnostic| self.diagnostics.push(diagnostic)).ok()
    }

    fn size(&mut self, value: Value) {
        let Some(sides) = self.report_error(value.list::<2>("width and height, `[640, 480]`")) else { return };
        for (index, side) in sides.into_iter().enumerate() {
            if let Some(side) = self.report_error(side.whole(1..i64::from(MAX_SIDE) + 1)) {
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
        if let Some(index) = self.report_error(positive) {
            self.picture.default_index = index;
        }
    }

    fn exposure(&mut self, value: Value) {
        let within = value.number().and_then(|stops| {
            let wrong = || {
                let [low, high] = [EXPOSURES.start(), EXPOSURES.end()];
                Diagnostic::error(format!("the exposure {stops} is out of range"))
                    .at(value.span, format!("expected stops from {low} to {high}"))
            };
            if EXPOSURES.contains(&(stops as f32)) { Ok(stops as f32) } else { Err(wrong()) }
        });
        if let Some(exposure) = self.report_error(within) {
            self.picture.view.exposure = exposure;
        }
    }

    /// The table `[bodies]` or `[lights]`, which has a table for each owner.
    fn owners(&mut self, value: Value, owner: impl Fn(String) -> OwnerName) {
        let Some(table) = self.report_error(value.table()) else { return };
        for entry in entries(table) {
            self.values(&owner(entry.key.to_owned()), entry.key_span, entry.value);
        }
    }

    /// The values of one owner.
    fn values(&mut self, owner: &OwnerName, owner_span: SourceSpan, value: Value) {
        let Some(table) = self.report_error(value.table()) else { return };
        for TomlEntry { key, key_span, value } in entries(table) {
            if let Some(given) = self.report_error(value.given()) {
                let spans = [owner_span, key_span];
                self.values.push(NamedValue { owner: owner.clone(), parameter: key.to_owned(), value: given, spans });
            }
        }
    }

    fn finish(mut self, table: &toml::de::DeTable) -> (Option<Session>, Diagnostics) {
        for (key, line) in NEEDED {
            // A misspelt key has been reported.
            let is_there = |entry: &TomlEntry| entry.key == key || nearest(entry.key, KEYS) == Some(key);
            if !entries(table).iter().any(is_there) {
                self.diagnostics.push(missing(&format!("the session names no {key}"), line));
            }
        }
        self.diagnostics.sort();
        let (picture, values) = (self.picture, self.values);
        let session = self.formula.zip(self.scene).map(|(formula, scene)| Session { formula, scene, picture, values });
        (session, self.diagnostics)
    }
}
