//! Writing a draft as text, and parsing it.

use crate::files::{Readable, open, reason};
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::source::Source;
use crate::user_data::drafts::Draft;
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::spanned_toml::{VERSION, Value, check_version, entries, missing, parse};
use serde::Serialize;
use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The file, key by key.
#[derive(Serialize)]
struct DraftText<'d> {
    version: i64,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    location: Option<&'d str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    session: Option<&'d str>,
    /// Seconds since 1970.
    time: u64,
    text: &'d str,
}

pub(super) fn to_toml(draft: &Draft) -> io::Result<String> {
    let written = |location: &Location| match location {
        Location::Preset(_) => Some(location.to_string()),
        // TOML cannot hold all paths. The text matters more than its path.
        Location::File(path) => path.to_str().map(str::to_owned),
    };
    let [location, session] = [&draft.location, &draft.session].map(|location| location.as_ref().and_then(written));
    let time = draft.time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let (location, session) = (location.as_deref(), session.as_deref());
    let text = DraftText { version: VERSION, kind: draft.kind.word(), location, session, time, text: &draft.text };
    toml::to_string(&text).map_err(io::Error::other)
}

/// Reads a draft of any size.
pub(super) fn read(path: &Path) -> Result<Draft, Diagnostic> {
    let unreadable = |why: &str| {
        Diagnostic::error(format!("cannot read the draft in `{}`: {why}", path.display()))
            .help("look at it with another program, or discard it")
    };
    let mut bytes = Vec::new();
    let (mut file, _) = open(path, Readable::Regular).map_err(|error| unreadable(&reason(&error.into())))?;
    file.read_to_end(&mut bytes).map_err(|error| unreadable(&reason(&error)))?;
    let text = String::from_utf8(bytes).map_err(|_| unreadable("it is not UTF-8 text"))?;
    let source = Source::new(path.display().to_string(), text);
    parse_draft(&source).map_err(|diagnostics| {
        let error = diagnostics.iter().find(|diagnostic| diagnostic.severity() == Severity::Error);
        unreadable(error.map_or("it is damaged", Diagnostic::message))
    })
}

fn parse_draft(source: &Source) -> Result<Draft, Diagnostics> {
    let table = parse(source)?;
    let mut diagnostics = Diagnostics::new();
    let [mut version, mut kind, mut location, mut session, mut time, mut text] = [None; 6];
    for entry in entries(&table) {
        match entry.key {
            "version" => version = Some(entry.value),
            "kind" => kind = Some(entry.value),
            "location" => location = Some(entry.value),
            "session" => session = Some(entry.value),
            "time" => time = Some(entry.value),
            "text" => text = Some(entry.value),
            // A later version may add keys. Ignoring them loses nothing.
            _ => {}
        }
    }
    check_version(version, &mut diagnostics);
    let mut take = |value: Option<Value>, line: &str| {
        let outcome =
            value.ok_or_else(|| missing("the draft is incomplete", line)).and_then(|value| value.text().map(str::to_owned));
        outcome.map_err(|diagnostic| diagnostics.push(diagnostic)).ok()
    };
    let text = take(text, "text = \"formula; = Cd;\"");
    let word = take(kind, "kind = \"formula\"");
    let [location, session] =
        [location, session].map(|location| location.and_then(|location| take(Some(location), "")).map(Location::new));
    let seconds = time.and_then(|time| time.whole(0..i64::MAX).ok()).unwrap_or_default();
    let kind = word.and_then(|word| FileKind::ALL.into_iter().find(|kind| kind.word() == word));
    let time: Option<SystemTime> = UNIX_EPOCH.checked_add(Duration::from_secs(seconds.unsigned_abs()));
    match (kind, text) {
        (Some(kind), Some(text)) if !diagnostics.has_errors() => {
            Ok(Draft { kind, location, session, text, time: time.unwrap_or(UNIX_EPOCH) })
        }
        _ => {
            if !diagnostics.has_errors() {
                diagnostics.push(missing("the draft has no valid kind", "kind = \"formula\""));
            }
            Err(diagnostics)
        }
    }
}
