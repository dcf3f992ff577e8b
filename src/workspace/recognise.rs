//! Recognising the kind of a text by its first words.

use crate::lang::lines::LINE_ENDS;
use crate::workspace::file_kind::FileKind;
use crate::workspace::session;
use crate::workspace::spanned_toml::VERSION_KEY;
use std::path::Path;

/// The kind of file that a text is, by its first words and the suffix of its path. Without either it is a formula.
pub fn kind_of_file(path: &Path, text: &str) -> FileKind {
    let suffix = match path.extension().and_then(|suffix| suffix.to_str()) {
        Some("formula") => Some(FileKind::Formula),
        Some("scene") => Some(FileKind::Scene),
        Some("toml") => Some(FileKind::Session),
        Some(_) | None => None,
    };
    // A formula or a scene with a mistake in its first line may look like TOML. For a file of unknown kind the parser
    // of formulas has the best messages.
    let told = kind_of(text).filter(|kind| match kind {
        FileKind::Formula | FileKind::Scene => true,
        FileKind::Session | FileKind::Material => suffix.is_none_or(|suffix| suffix == FileKind::Session),
    });
    told.or(suffix).unwrap_or(FileKind::Formula)
}

/// The kind of file that a text is, if its first words tell.
pub fn kind_of(text: &str) -> Option<FileKind> {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    loop {
        let comment = if rest.starts_with("/*") {
            rest.find("*/").map(|end| end + 2)
        } else if rest.starts_with("//") || (rest.starts_with('#') && !rest.starts_with("#uses")) {
            rest.find(LINE_ENDS)
        } else {
            None
        };
        match comment {
            Some(end) => rest = rest[end..].trim_start(),
            None => break,
        }
    }
    if rest.starts_with("#uses") {
        return Some(FileKind::Formula);
    }
    let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
    let (word, behind) = rest.split_at(end);
    match (word, behind.trim_start_matches([' ', '\t']).chars().next()) {
        // Only TOML starts with `[table]` or with `key = value` on one line.
        ("", Some('[')) => Some(kind_of_toml(rest)),
        (key, Some('=')) if !key.is_empty() => Some(kind_of_toml(rest)),
        ("bodies" | "lights" | "camera", _) => Some(FileKind::Scene),
        ("global" | "body_specific" | "light_specific" | "invariants" | "formula", _) => Some(FileKind::Formula),
        _ => None,
    }
}

/// The kind of a TOML text, by its first distinctive key. Sessions have some fixed keys; libraries of materials have
/// only tables with other names. A text with neither counts as a session.
fn kind_of_toml(text: &str) -> FileKind {
    const TABLES: [&str; 3] = ["global", "bodies", "lights"];
    for line in text.lines().map(str::trim_start).filter(|line| !line.starts_with('#')) {
        let (is_table, line) = line.strip_prefix('[').map_or((false, line), |line| (true, line));
        let (key, value) = if is_table { (line, "") } else { line.split_once('=').unwrap_or((line, "")) };
        let mut parts = key.split(['.', ']']).map(str::trim);
        let first = parts.next().unwrap_or_default();
        if is_table || value.trim_start().starts_with('{') || parts.next().is_some() {
            return if TABLES.contains(&first) { FileKind::Session } else { FileKind::Material };
        }
        if first != VERSION_KEY && session::KEYS.contains(&first) {
            return FileKind::Session;
        }
    }
    FileKind::Session
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_reported_by_first_words() {
        assert_eq!(kind_of("\u{feff}/* a */ // b\n bodies;"), Some(FileKind::Scene));
        assert_eq!(kind_of("#uses m.txt;\nformula;"), Some(FileKind::Formula));
        assert_eq!(kind_of("formula; = Cd;"), Some(FileKind::Formula));
        assert_eq!(kind_of("// a\rformula;\r= Cd;"), Some(FileKind::Formula));
        assert_eq!(kind_of("// a\u{2028}formula;\nbodies;"), Some(FileKind::Scene));
        assert_eq!(kind_of("# a session\nformula = \"x\""), Some(FileKind::Session));
        assert_eq!(kind_of("version = 1"), Some(FileKind::Session));
        assert_eq!(kind_of("[global]"), Some(FileKind::Session));
        assert_eq!(kind_of("version = 1\n\n# values\n[bodies.ball]"), Some(FileKind::Session));
        assert_eq!(kind_of("version = 1\nshadows = true\n[gold]"), Some(FileKind::Session));
        assert_eq!(kind_of("\u{feff}# metals\nversion = 1\r\n\r\n# yellow\r\n[gold]"), Some(FileKind::Material));
        assert_eq!(kind_of("[\"red plastic\"]\nkd = 1"), Some(FileKind::Material));
        assert_eq!(kind_of("version = 1\ngold = { kr = 1 }"), Some(FileKind::Material));
        assert_eq!(kind_of("version = 1\ngold.kr = 1"), Some(FileKind::Material));
        assert_eq!(kind_of("version = 1\nshine = 1\n[gold]"), Some(FileKind::Material));
        assert_eq!(kind_of("kd: scalar;"), None);
        assert_eq!(kind_of("// no end"), None);
        assert_eq!(kind_of("/* no end"), None);
    }

    #[test]
    fn first_words_count_before_suffixes_but_toml_is_not_taken_for_a_formula() {
        let kind = |name: &str, text: &str| kind_of_file(Path::new(name), text);
        assert_eq!(kind("a.formula", "bodies;"), FileKind::Scene);
        assert_eq!(kind("a.formula", "a = 1;"), FileKind::Formula);
        assert_eq!(kind("a.scene", "ball: sphere;"), FileKind::Scene);
        assert_eq!(kind("a.toml", "[gold]"), FileKind::Material);
        assert_eq!(kind("a", "version = 1"), FileKind::Session);
        assert_eq!(kind("a", "kd: scalar;"), FileKind::Formula);
    }
}
