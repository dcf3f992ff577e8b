//! The order of the house: which rooms may import which, and where unsafe code may live.

use std::fs;
use std::path::{Path, PathBuf};

/// Each room with those it may import. Data flows one way: text → syntax → formula → {bytecode, compiled code}; scene → world → hits →
/// evaluation → picture; what a user edits sits on top, and the program above all.
const ROOMS: [(&str, &[&str]); 18] = [
    ("files", &[]),
    ("lang", &[]),
    ("formula", &["lang"]),
    ("scene", &["lang"]),
    ("world", &["scene"]),
    ("segment", &[]),
    ("trace", &["lang", "scene", "world", "segment"]),
    ("bytecode", &["lang", "formula", "scene", "world", "trace"]),
    ("plan", &["lang", "formula"]),
    ("jit", &["lang", "formula", "plan", "segment"]),
    ("transfer", &[]),
    ("evaluate", &["lang", "formula", "scene", "world", "trace", "plan", "transfer"]),
    ("backends", &["lang", "formula", "scene", "world", "trace", "bytecode", "plan", "jit", "transfer", "evaluate"]),
    ("engine", &["formula", "scene", "world", "trace", "evaluate", "backends"]),
    ("picture", &["evaluate", "files", "transfer"]),
    ("presets", &[]),
    ("workspace", &["files", "lang", "formula", "scene", "trace", "engine", "presets", "transfer"]),
    (
        "preview",
        &[
            "files",
            "lang",
            "formula",
            "scene",
            "world",
            "trace",
            "plan",
            "evaluate",
            "backends",
            "engine",
            "picture",
            "presets",
            "workspace",
        ],
    ),
];

/// What widgets are made with, and what windows, with where they may be named beside the program. Widgets know no window: tests drive them
/// without one.
const WIDGETS: (&[&str], &str) = (&["egui"], "src/preview");
const WINDOWS: (&[&str], &str) = (&["minifb", "x11rb", "arboard"], "src/preview/window");

/// The one room with unsafe code.
const UNSAFE: &str = "src/jit/call.rs";

fn sources() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    let mut folders = vec![root.join("src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|suffix| suffix == "rs") {
                let text = fs::read_to_string(&path).expect("a source file");
                found.push((path.strip_prefix(root).expect("below the root").to_owned(), text));
            }
        }
    }
    assert!(found.len() > 30, "the sources are found");
    found
}

/// The text up to the tests, without comments.
fn code(path: &Path, text: &str) -> String {
    if path.file_name().is_some_and(|name| name == "tests.rs") {
        return String::new();
    }
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect()
}

/// The room that a file belongs to.
fn room(path: &Path) -> String {
    let part = path.iter().nth(1).expect("a file below src").to_string_lossy().into_owned();
    part.trim_end_matches(".rs").to_owned()
}

#[test]
fn imports_go_one_way() {
    for (path, text) in sources() {
        let own = room(&path);
        let code = code(&path, &text);
        let Some((_, allowed)) = ROOMS.iter().find(|(name, _)| *name == own) else {
            assert!(["lib", "main", "cli"].contains(&own.as_str()), "{}: a room that is not in the plan", path.display());
            continue;
        };
        for (place, _) in code.match_indices("crate::") {
            let imported: String = code[place + 7..].chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
            let known = ROOMS.iter().any(|(name, _)| *name == imported);
            assert!(
                !known || imported == own || allowed.contains(&imported.as_str()),
                "{} imports `{imported}`, which `{own}` may not",
                path.display()
            );
        }
    }
}

#[test]
fn the_library_knows_nothing_of_terminals_and_windows() {
    for (path, text) in sources() {
        if ["cli", "main"].contains(&room(&path).as_str()) {
            continue;
        }
        let code = code(&path, &text);
        for stranger in ["clap", "indicatif", "println!"] {
            assert!(!code.contains(stranger), "{} names {stranger}", path.display());
        }
        for (strangers, home) in [WIDGETS, WINDOWS] {
            let at_home = path.with_extension("").starts_with(home);
            let named = strangers.iter().find(|stranger| code.contains(*stranger));
            assert!(at_home || named.is_none(), "{} names {}", path.display(), named.unwrap_or(&""));
        }
    }
}

#[test]
fn unsafe_code_lives_in_one_room() {
    for (path, text) in sources() {
        let holds = code(&path, &text).split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(|word| word == "unsafe");
        assert_eq!(holds, path == Path::new(UNSAFE), "unsafe code in {}", path.display());
    }
}
