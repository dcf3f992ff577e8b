//! The rules of the source tree: which rooms may import which, no cycles of imports, one meaning for each type name,
//! where unsafe code may be, and the style of comments and documents.

mod modules;
mod prose;
mod tokens;

use modules::Modules;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use tokens::{Token, tokens, without_tests};

/// Each room with the rooms that it may import. Data flows one way: text → AST → formula → plans → backends; scene →
/// world → hits → evaluation → picture. The workspace and the window use all of this, and the program uses them.
const ROOMS: [(&str, &[&str]); 30] = [
    ("files", &[]),
    ("simd", &[]),
    ("texture", &["files"]),
    ("measured", &["files"]),
    ("sampling", &[]),
    ("lang", &["texture", "measured"]),
    ("formula", &["lang"]),
    ("scene", &["lang"]),
    ("mesh", &["files", "lang"]),
    ("bvh", &["simd", "mesh"]),
    ("environment", &[]),
    ("world", &["sampling", "scene", "mesh", "bvh", "environment"]),
    ("trace", &["sampling", "lang", "scene", "world"]),
    ("picture", &["files", "lang"]),
    ("bytecode", &["lang", "formula", "scene", "world", "trace"]),
    ("plan", &["lang", "formula"]),
    // Machine code knows the layout of hits, and how components become bytes.
    ("jit", &["simd", "texture", "measured", "lang", "formula", "plan", "trace", "picture"]),
    ("evaluate", &["texture", "lang", "formula", "scene", "world", "trace", "plan", "picture"]),
    ("export", &["lang", "formula"]),
    // The kernels of a graphics device are written in WGSL, and it has textures of its own.
    (
        "backends",
        &["texture", "lang", "formula", "scene", "world", "trace", "bytecode", "plan", "jit", "picture", "evaluate", "export"],
    ),
    // Instruments make charts of what they find.
    ("plot", &["picture"]),
    ("instrument", &["sampling", "measured", "lang", "formula", "plan", "jit", "evaluate", "plot"]),
    ("engine", &["lang", "formula", "scene", "world", "trace", "picture", "evaluate", "backends"]),
    ("sensitivity", &["lang", "formula", "world", "trace", "picture", "evaluate", "engine"]),
    (
        "workspace",
        &[
            "files",
            "texture",
            "measured",
            "lang",
            "formula",
            "scene",
            "mesh",
            "bvh",
            "environment",
            "world",
            "trace",
            "engine",
            "picture",
        ],
    ),
    (
        "fit",
        &[
            "sampling",
            "measured",
            "lang",
            "formula",
            "trace",
            "picture",
            "plot",
            "engine",
            "instrument",
            "sensitivity",
            "workspace",
        ],
    ),
    ("import", &["files", "lang", "mesh", "scene", "trace", "picture", "workspace"]),
    ("assist", &["lang", "formula", "scene", "workspace"]),
    // Settings name a backend, and the transfer of new sessions.
    ("user_data", &["files", "lang", "trace", "picture", "backends", "workspace"]),
    (
        "preview",
        &[
            "files",
            "texture",
            "measured",
            "lang",
            "formula",
            "scene",
            "mesh",
            "world",
            "trace",
            "plan",
            "evaluate",
            "backends",
            "engine",
            "picture",
            "plot",
            "instrument",
            "sensitivity",
            "workspace",
            "fit",
            "assist",
            "user_data",
        ],
    ),
];

/// The libraries of widgets and of windows, each with the folder that may name them. Tests drive widgets without a
/// window.
const WIDGETS: (&[&str], &str) = (&["egui"], "src/preview");
const WINDOWS: (&[&str], &str) = (&["minifb", "x11rb", "arboard"], "src/preview/window");
/// The same for the library of graphics devices.
const DEVICES: (&[&str], &str) = (&["wgpu"], "src/backends/gpu");

/// The only file that writes to the terminal, and the file that draws progress with a library.
const REPORT: &str = "src/cli/report.rs";
const PROGRESS: &str = "src/cli/progress.rs";

/// The room with unsafe code: a folder and the file of its name.
const UNSAFE: &str = "src/jit/call";

/// Type names that are declared more than once: by each command, and by the stand-in for compiled code on processors
/// that have none.
const SHARED_NAMES: [&str; 4] = ["Options", "Kernel", "CallList", "PixelCode"];

/// All source files: their paths, and their texts.
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

fn modules(sources: &[(PathBuf, String)]) -> Modules {
    let name = |path: &'_ Path| path.strip_prefix("src").expect("below src").to_str().expect("UTF-8").to_owned();
    let names: Vec<String> = sources.iter().map(|(path, _)| name(path)).collect();
    Modules::new(names.iter().zip(sources).map(|(name, (_, text))| (name.as_str(), text.as_str())))
}

/// The words of a file outside of comments, literals and tests.
fn words(path: &Path, text: &str) -> BTreeSet<String> {
    if path.file_name().is_some_and(|name| name == "tests.rs") {
        return BTreeSet::new();
    }
    without_tests(&tokens(text)).iter().filter_map(Token::word).map(str::to_owned).collect()
}

/// The room that a file belongs to.
fn room(path: &Path) -> String {
    let part = path.iter().nth(1).expect("a file below src").to_string_lossy().into_owned();
    part.trim_end_matches(".rs").to_owned()
}

#[test]
fn imports_go_one_way() {
    let modules = modules(&sources());
    for path in modules.paths() {
        let own = path[0].as_str();
        let Some((_, allowed)) = ROOMS.iter().find(|(name, _)| *name == own) else {
            assert_eq!(own, "cli", "a room that is not in the table");
            continue;
        };
        for named in modules.rooms_named_by(path) {
            assert!(
                named == own || allowed.contains(&named.as_str()),
                "{} names `{named}`, which `{own}` may not",
                path.join("::")
            );
        }
    }
}

#[test]
fn rooms_have_no_cycles_of_imports() {
    let mut problems = Vec::new();
    for cycle in modules(&sources()).cycles() {
        let (members, reasons) = (Vec::from_iter(&cycle.members), cycle.reasons.join("\n  "));
        problems.push(format!("modules of `{}` import each other: {members:?}\n  {reasons}", cycle.parent));
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn a_type_name_has_one_meaning() {
    let mut declared: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for (path, text) in sources() {
        if path.file_name().is_some_and(|name| name == "tests.rs") {
            continue;
        }
        let tokens = without_tests(&tokens(&text));
        // A table of declarations names an enumeration.
        for four in tokens.windows(4) {
            let [Token::Word(table), Token::Mark('!'), Token::Mark('{'), Token::Word(name)] = four else { continue };
            if table == "declarations" {
                declared.entry(name.clone()).or_default().push(path.clone());
            }
        }
        let mut depth = 0;
        for pair in tokens.windows(2) {
            match pair[0] {
                Token::Mark('{') => depth += 1,
                Token::Mark('}') => depth -= 1,
                Token::Mark(_) | Token::PathSeparator | Token::Word(_) => {}
            }
            let (Some(keyword), Some(name)) = (pair[0].word(), pair[1].word()) else { continue };
            // A trait names the types in braces.
            let is_alias = keyword == "type" && depth == 0;
            if is_alias || ["struct", "enum", "trait", "union"].contains(&keyword) {
                declared.entry(name.to_owned()).or_default().push(path.clone());
            }
        }
    }
    assert!(declared.len() > 100, "the types are found");
    declared.retain(|name, places| places.len() > 1 && !SHARED_NAMES.contains(&name.as_str()));
    assert!(declared.is_empty(), "declared more than once: {declared:#?}");
}

#[test]
fn the_library_knows_nothing_of_terminals_and_windows() {
    for (path, text) in sources() {
        if ["cli", "main"].contains(&room(&path).as_str()) {
            continue;
        }
        let words = words(&path, &text);
        for stranger in ["ariadne", "clap", "indicatif", "println", "eprintln", "stderr", "stdout"] {
            assert!(!words.contains(stranger), "{} names {stranger}", path.display());
        }
        for (strangers, home) in [WIDGETS, WINDOWS, DEVICES] {
            let at_home = path.with_extension("").starts_with(home);
            let named = strangers.iter().find(|stranger| words.contains(**stranger));
            assert!(at_home || named.is_none(), "{} names {}", path.display(), named.unwrap_or(&""));
        }
    }
}

#[test]
fn text_leaves_the_program_in_one_place() {
    for (path, text) in sources() {
        if !path.starts_with("src/cli") || path == Path::new(REPORT) || path == Path::new(PROGRESS) {
            continue;
        }
        let words = words(&path, &text);
        let writes = ["println", "eprint", "eprintln", "stderr", "stdout"];
        let named = writes.into_iter().find(|word| words.contains(*word));
        assert_eq!(named, None, "{}", path.display());
    }
}

#[test]
fn unsafe_code_is_in_one_room() {
    let room = Path::new(UNSAFE);
    let holds = |(path, text): &(PathBuf, String)| words(path, text).contains("unsafe");
    let (inside, outside): (Vec<_>, Vec<_>) =
        sources().into_iter().filter(holds).map(|(path, _)| path).partition(|path| path.with_extension("").starts_with(room));
    assert_eq!(outside, Vec::<PathBuf>::new(), "unsafe code outside its room");
    assert!(!inside.is_empty(), "the room of unsafe code has moved");
}
