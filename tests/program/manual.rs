//! The manual in docs/manual is true: its formulas, scenes, sessions and commands are tried, its generated parts are
//! fresh, and its links lead somewhere.
//!
//! The blocks of a chapter are tried in order, in one folder. What the first word behind a fence means:
//!
//! - `formula`, `scene`, `session`, `material`: `illuminator check` finds nothing to say. With the word `error` or
//!   `warning` behind it, what it says is in the `message` block below, or is not shown. With a name of a file behind
//!   it, commands below can read the file.
//! - `settings`: a file of settings without mistakes.
//! - `console`: each line that begins with `$ ` is run by a shell. The lines below it are what the command prints. `…`
//!   in a line stands for any text, and a line `…` for any lines. Without such lines, pictures are made smaller,
//!   because nobody looks at them.
//! - `sh` is not run: commands that open a window, or change the machine.
//! - `text`, `ebnf`, `rust` and `python` are not tried here. Documentation tests run the examples in Rust, and tests of
//!   the package those in Python.

mod blocks;
mod gallery;
mod generated;

use blocks::{Block, Chapter, chapters, folder};
use illuminator::lang::source::Source;
use illuminator::user_data::settings::Settings;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The most bytes of all images together.
const MOST_IMAGE_BYTES: u64 = 4 << 20;
/// The kinds of blocks that are not tried.
const UNTRIED: [&str; 5] = ["text", "ebnf", "rust", "python", "message"];

#[test]
fn blocks_are_true() {
    let chapters = chapters();
    let mistakes = Vec::from_iter(chapters.iter().flat_map(|chapter| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let blocks = chapter.blocks();
        let tried = blocks.iter().enumerate().map(|(index, block)| tried(folder.path(), block, blocks.get(index + 1)));
        tried.filter_map(Result::err).collect::<Vec<_>>()
    }));
    assert!(mistakes.is_empty(), "\n{}", mistakes.join("\n\n"));
}

/// Tries a block.
///
/// # Errors
/// What is wrong with it, and where it is.
fn tried(folder: &Path, block: &Block, next: Option<&Block>) -> Result<(), String> {
    let message = next.filter(|next| next.kind == "message");
    let found = match block.kind {
        "formula" | "scene" | "session" | "material" => checked(folder, block, message),
        "settings" => {
            let (_, problems) = Settings::parse(&Source::new("settings.toml", block.text.as_str()));
            if problems.is_empty() { Ok(()) } else { Err(format!("{problems:?}")) }
        }
        "console" => entered(folder, block),
        "sh" if block.text.lines().all(changes_the_machine) => Ok(()),
        kind if UNTRIED.contains(&kind) => Ok(()),
        kind => Err(format!("a block of an unknown kind, `{kind}`, or a command that can be run in a `console` block")),
    };
    found.map_err(|mistake| format!("{}: {mistake}", block.place))
}

/// Whether a line of an `sh` block opens a window or changes the machine, so no test can run it.
fn changes_the_machine(line: &str) -> bool {
    let first = ["cargo ", "git ", "cd ", "pip install ", "sudo ", "mdbook ", "alias ", "source ", "illuminator preview"];
    line == "illuminator" || line.is_empty() || line.starts_with('#') || first.iter().any(|first| line.starts_with(first))
}

/// Checks a text with `illuminator check`, and compares what it says.
fn checked(folder: &Path, block: &Block, message: Option<&Block>) -> Result<(), String> {
    let given = block.words.iter().find(|word| word.contains('.'));
    let name = given
        .map_or_else(|| format!("example.{}", if block.kind == "session" { "toml" } else { block.kind }), ToString::to_string);
    fs::write(folder.join(&name), &block.text).expect("a file in a temporary folder");
    let (said, _) = in_shell(folder, &format!("illuminator check --kind {} {name}", block.kind));
    let severity = if said.contains("Error: ") {
        "error"
    } else if said.contains("Warning: ") {
        "warning"
    } else {
        ""
    };
    let wanted = ["error", "warning"].into_iter().find(|word| block.words.contains(word)).unwrap_or("");
    if severity != wanted {
        let wanted = if wanted.is_empty() { "nothing" } else { wanted };
        return Err(format!("expected {wanted} here, but the program says:\n{said}"));
    }
    message.map_or(Ok(()), |message| compared(&message.text, &said))
}

/// Runs the commands of a `console` block.
fn entered(folder: &Path, block: &Block) -> Result<(), String> {
    let mut entries: Vec<(&str, String)> = Vec::new();
    for line in block.text.lines() {
        match (line.strip_prefix("$ "), entries.last_mut()) {
            (Some(command), _) => entries.push((command, String::new())),
            (None, Some((_, shown))) => shown.push_str(&format!("{line}\n")),
            (None, None) => return Err("the first line of a `console` block begins with `$ `".to_owned()),
        }
    }
    entries.iter().try_for_each(|(command, shown)| shell(folder, command, shown))
}

/// Runs a command, and compares what it prints with what is shown.
fn shell(folder: &Path, command: &str, shown: &str) -> Result<(), String> {
    let command_run = if shown.is_empty() { with_small_pictures(command) } else { command.to_owned() };
    let (printed, succeeds) = in_shell(folder, &command_run);
    let fails = shown.lines().any(|line| line.starts_with("Error: ") || line.starts_with("error: "));
    if succeeds == fails {
        return Err(format!("`{command_run}` {}:\n{printed}", if succeeds { "succeeds" } else { "fails" }));
    }
    if shown.is_empty() {
        return Ok(());
    }
    compared(shown, &printed).map_err(|mistake| format!("`{command_run}`: {mistake}"))
}

/// Runs a line in a shell. What it prints on both outputs together, and whether it succeeds.
fn in_shell(folder: &Path, line: &str) -> (String, bool) {
    let program = Path::new(env!("CARGO_BIN_EXE_illuminator")).parent().expect("a folder").display();
    let path = format!("{program}:{}", std::env::var("PATH").unwrap_or_default());
    let mut shell = Command::new("sh");
    // Both outputs are one pipe, so lines come in the order in which a terminal shows them.
    shell.current_dir(folder).args(["-c", &format!("exec 2>&1\n{line}")]).env("PATH", path);
    shell.env_remove("RUST_BACKTRACE").env_remove("COLUMNS").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let output = shell.env("ILLUMINATOR_HOME", folder.join("home")).output().expect("a shell");
    (String::from_utf8(output.stdout).expect("text"), output.status.success())
}

/// A command with a small size and one pass, if it makes a picture.
fn with_small_pictures(command: &str) -> String {
    const MAKING: [&str; 4] = ["illuminator render", "illuminator verify", "illuminator bench", "illuminator sweep"];
    let Some(making) = MAKING.into_iter().find(|making| command.starts_with(making)) else { return command.to_owned() };
    let mut words = Vec::from_iter(command.split(' '));
    for (option, small) in [("--size", "32x18"), ("--samples", "1"), ("--runs", "1")] {
        if let Some(at) = words.iter().position(|word| *word == option) {
            words[at + 1] = small;
        }
    }
    let size = if words.contains(&"--size") { "" } else { " --size 32x18" };
    words.join(" ").replacen(making, &format!("{making}{size}"), 1)
}

/// Whether a line that is shown is the printed one. `…` in it stands for any text.
fn fits(shown: &str, printed: &str) -> bool {
    let Some((first, rest)) = shown.split_once('…') else { return shown == printed };
    let (middle, last) = rest.rsplit_once('…').unwrap_or(("", rest));
    let between = printed.strip_prefix(first).and_then(|printed| printed.strip_suffix(last));
    between.is_some_and(|mut between| {
        middle.split('…').all(|piece| match between.find(piece) {
            Some(at) => {
                between = &between[at + piece.len()..];
                true
            }
            None => false,
        })
    })
}

/// Compares lines that are shown with lines that the program printed. A shown line `…` stands for any lines.
fn compared(shown: &str, printed: &str) -> Result<(), String> {
    let printed = Vec::from_iter(printed.lines().map(str::trim_end));
    let mut rest = printed.as_slice();
    let mut skips = false;
    for line in shown.lines().map(str::trim_end) {
        if line == "…" {
            skips = true;
            continue;
        }
        let at = rest.iter().position(|found| fits(line, found)).filter(|at| skips || *at == 0);
        let Some(at) = at else { return Err(format!("the line `{line}` is not there. Printed:\n{}", printed.join("\n"))) };
        (rest, skips) = (&rest[at + 1..], false);
    }
    if rest.iter().all(|line| line.is_empty()) || skips {
        return Ok(());
    }
    Err(format!("more is printed than shown:\n{}", rest.join("\n")))
}

#[test]
fn generated_parts_are_fresh() {
    let updates = std::env::var_os("UPDATE_MANUAL").is_some();
    for (name, content) in generated::parts() {
        let mut count = 0;
        for Chapter { name: file, text } in chapters() {
            let Some(fresh) = generated::replaced(&text, name, &content) else { continue };
            count += 1;
            if updates && fresh != text {
                fs::write(folder().join(&file), fresh).expect("a chapter");
                continue;
            }
            let differs = fresh.lines().zip(text.lines()).position(|(fresh, old)| fresh != old).map_or(0, |at| at + 1);
            assert!(fresh == text, "docs/manual/src/{file}:{differs}: `{name}` is not fresh; run this test with UPDATE_MANUAL=1");
        }
        assert_eq!(count, 1, "one chapter holds the part `{name}`");
    }
}

/// Not a test, but a program that belongs to the manual: it makes the pictures of the gallery. If the environment
/// variable `MANUAL_PICTURES` is `missing`, it makes only those that are not there.
#[test]
#[ignore = "it makes pictures, and takes minutes"]
fn make_gallery_pictures() {
    let pictures = folder().join("images/gallery");
    fs::create_dir_all(&pictures).expect("a folder of pictures");
    let only_missing = std::env::var("MANUAL_PICTURES").is_ok_and(|which| which == "missing");
    gallery::make_pictures(&pictures, only_missing);
}

#[test]
fn links_lead_somewhere() {
    for chapter in chapters() {
        let Chapter { name, text } = &chapter;
        let blocks = chapter.blocks();
        let in_block =
            |line: usize| blocks.iter().any(|block| (block.line..=block.line + block.text.lines().count()).contains(&line));
        for (index, line) in text.lines().enumerate().filter(|(index, _)| !in_block(index + 1)) {
            for target in line.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
                let (file, heading) = target.split_once('#').unwrap_or((target, ""));
                let place = format!("docs/manual/src/{name}:{}", index + 1);
                if file.contains("://") {
                    continue;
                }
                assert!(!file.starts_with(".."), "{place}: `{target}` leads out of the book, where it is broken");
                let path = if file.is_empty() { folder().join(name) } else { folder().join(file) };
                assert!(path.exists(), "{place}: there is no `{target}`");
                if !heading.is_empty() {
                    let text = fs::read_to_string(&path).expect("a page");
                    let anchors = text.lines().filter(|line| line.starts_with('#')).map(anchor);
                    assert!(anchors.into_iter().any(|anchor| anchor == heading), "{place}: no heading `#{heading}` in {file}");
                }
            }
        }
    }
}

/// The anchor that GitHub and mdBook give to a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

#[test]
fn every_chapter_is_in_the_summary() {
    let summary = fs::read_to_string(folder().join("SUMMARY.md")).expect("the summary");
    for Chapter { name, .. } in chapters().iter().filter(|chapter| chapter.name != "SUMMARY.md") {
        assert!(summary.contains(&format!("({name})")), "SUMMARY.md does not have {name}");
    }
}

#[test]
fn images_are_used_and_small() {
    let text = chapters().iter().map(|chapter| chapter.text.as_str()).collect::<String>();
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("the readme");
    let mut folders: Vec<PathBuf> = vec![folder().join("images")];
    let mut bytes = 0;
    while let Some(images) = folders.pop() {
        for path in fs::read_dir(images).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder()).expect("below the manual").display().to_string();
            assert!(text.contains(&name) || readme.contains(&name), "nothing shows {name}");
            bytes += fs::metadata(&path).expect("an image").len();
        }
    }
    assert!((1..=MOST_IMAGE_BYTES).contains(&bytes), "the images of the manual have {bytes} bytes");
}

#[test]
fn false_blocks_are_found() {
    let mistakes = |text: &str| {
        let chapter = Chapter { name: "x.md".to_owned(), text: text.to_owned() };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let blocks = chapter.blocks();
        let tried = blocks.iter().enumerate().map(|(index, block)| tried(folder.path(), block, blocks.get(index + 1)));
        tried.filter_map(Result::err).collect::<Vec<_>>()
    };
    let sound = "```formula\nformula; = Cd*(N.L);\n```\n```formula error\nformula; = N.L;\n```\n\
        ```formula a.formula\nformula; = IL;\n```\n```console\n$ illuminator check a.formula\na.formula: 7 …\n```\n";
    let found = mistakes(sound);
    assert!(
        found.len() == 1 && found[0].contains("x.md:10: ") && found[0].contains("`a.formula: 7 …` is not there"),
        "{found:?}"
    );
    for (text, place) in [
        ("\n```formula\nformula; = N.L;\n```\n", "x.md:2: expected nothing"),
        ("```formula error\nformula; = IL;\n```\n", "x.md:1: expected error"),
        ("```formula error\nformula; = N.L;\n```\n```message\nError: no\n```\n", "`Error: no` is not there"),
        ("```scene\nbodies;\n```\n", "x.md:1: expected nothing"),
        ("```settings\nversion = 7\n```\n", "x.md:1: "),
        ("```console\n$ illuminator render preset:none -o x.png\n```\n", "fails:\nError: there is no"),
        ("```console\n$ illuminator list\nSessions:\n…\n```\n", "is not there"),
        ("```sh\nilluminator list\n```\n", "can be run in a `console` block"),
    ] {
        let found = mistakes(text);
        assert!(found.len() == 1 && found[0].contains(place), "{text}: {found:?}");
    }
}
