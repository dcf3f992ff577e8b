//! Messages are safe and short: no name, path or text can control the terminal, and no message is very long.

use crate::{FORMULA, SCENE, folder, write};
use illuminator::lang::display_text::is_hidden;
use std::path::Path;
use std::process::{Command, Stdio};

/// Characters that control a terminal or hide parts of a name.
const HOSTILE: &str = "x\u{1b}[31m\u{9b}2J\u{202e}\u{2066}\u{7}\u{200b}\u{7f}y";

/// A message must be shorter than this.
const LONG: usize = 20_000;

/// Runs the program, and checks that its output is safe and short.
fn safe(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .current_dir(folder)
        .args(arguments)
        .env("HOME", folder.join("home"))
        .env("XDG_DATA_HOME", folder.join("home/data"))
        .stdin(Stdio::null())
        .output()
        .expect("the program runs");
    let text = String::from_utf8([output.stdout, output.stderr].concat()).expect("text");
    let shown: String = text.chars().take(2000).collect();
    assert!(!text.chars().any(|c| c != '\n' && is_hidden(c)), "{arguments:?}: {shown:?}");
    assert!(text.len() < LONG, "{} bytes: {shown}", text.len());
    assert_ne!(output.status.code(), Some(101), "{arguments:?}: {shown}");
    text
}

/// Command lines with messages that repeat a word of the user.
fn with_word(folder: &Path, word: &str) {
    let assignment = format!("{word}={word}");
    let path = format!("{word}.png");
    let inside = format!("no/{word}.png");
    for arguments in [
        vec![word],
        vec![&format!("--{word}")],
        vec!["render", &format!("--{word}")],
        vec!["render", word, "-o", "out.png"],
        vec!["render", "-o", word],
        vec!["render", "-o", &inside],
        vec!["render", "-o", "out.png", "--formula", word],
        vec!["render", "-o", "out.png", "--scene", &format!("preset:{word}")],
        vec!["render", "-o", "out.png", "--size", word],
        vec!["render", "-o", "out.png", "--backend", word],
        vec!["render", "-o", "out.png", "--memory", word],
        vec!["render", "-o", "out.png", "--set", word],
        vec!["render", "-o", "out.png", "--set", &assignment],
        vec!["render", "session.toml", "-o", "out.png", "--set", &format!("{word}.kd=1"), "--set", &format!("ball.{word}=1")],
        vec!["render", "session.toml", "-o", "out.png", "--material", word],
        vec!["render", "-f", "preset:phong", "-s", "sub/place.txt", "-o", "out.png", "--material", &assignment],
        vec!["bench", "session.toml", "--slider", word],
        vec!["dump", "session.toml", "--stage", word],
        vec!["dump", "session.toml", "--stage", "hits", "-o", &format!("session.toml/{word}")],
        vec!["check", word, &path],
        vec!["preview", word],
    ] {
        let said = safe(folder, &arguments);
        assert!(!said.is_empty(), "{arguments:?}");
    }
}

#[test]
fn words_of_the_command_line_are_safe_and_short() {
    let folder = folder();
    with_word(folder.path(), HOSTILE);
    with_word(folder.path(), &"long".repeat(12_000));
    with_word(folder.path(), "line\nError: another line");
    let said = safe(folder.path(), &["render", "-o", "out.png", "--size", "a\nb"]);
    assert!(said.starts_with("error: invalid value 'a\\nb' for '--size <WxH>'"), "{said}");
}

#[cfg(unix)]
#[test]
fn names_that_are_not_text_are_safe() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let name = std::ffi::OsStr::from_bytes(b"\x1b[31m\xff\x9b.formula");
    std::fs::write(folder.path().join(name), "formula; = Q;").expect("a file");
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .current_dir(folder.path())
        .arg("check")
        .arg(name)
        .output()
        .expect("the program runs");
    let text = String::from_utf8([output.stdout, output.stderr].concat()).expect("text");
    assert!(!text.chars().any(|c| c != '\n' && is_hidden(c)) && text.contains("\\u{1b}[31m"), "{text:?}");
}

#[test]
fn names_of_files_are_safe() {
    let folder = folder();
    let model = format!("{HOSTILE}.formula");
    write(&folder, &model, FORMULA);
    let said = safe(folder.path(), &["check", &model]);
    assert!(said.starts_with("x\\u{1b}[31m\\u{9b}2J\\u{202e}") && said.ends_with(": formula, 0 errors, 0 warnings\n"), "{said}");
    write(&folder, &model, &FORMULA.replace("kd*IL", "kq*IL"));
    let said = safe(folder.path(), &["check", &model]);
    assert!(said.contains("[ x\\u{1b}[31m"), "{said}");
    safe(folder.path(), &["render", "-f", &model, "-s", "sub/place.txt", "-o", "out.png"]);
    write(&folder, "line\nend", SCENE);
    assert_eq!(safe(folder.path(), &["check", "line\nend"]), "line\\nend: scene, 0 errors, 0 warnings\n");
}

#[test]
fn names_in_files_are_safe_and_short() {
    let folder = folder();
    let escaped: String = HOSTILE.chars().map(|c| format!("\\U{:08x}", u32::from(c))).collect();
    let long = "n".repeat(1 << 20);
    for name in [escaped.as_str(), &long] {
        write(
            &folder,
            "keys.toml",
            &format!(
                "version = 1\nformula = \"model.txt\"\nscene = \"sub/place.txt\"\n\"{name}\" = 1\n[bodies.\"{name}\"]\nkd = 1\n[bodies.ball]\n\"{name}\" = 1\n"
            ),
        );
        write(&folder, "paths.toml", &format!("version = 1\nformula = \"{name}\"\nscene = \"preset:{name}\"\n"));
        write(&folder, "materials.toml", &format!("version = 1\n[\"{name}\"]\n\"{name}\" = 1\nkd = \"{name}\"\n"));
        for file in ["keys.toml", "paths.toml", "materials.toml"] {
            let said = safe(folder.path(), &["check", file]);
            assert!(said.contains("rror") || said.contains("arning"), "{said}");
            safe(folder.path(), &["render", file, "-o", "out.png"]);
        }
    }
    for name in [HOSTILE, &long] {
        write(&folder, "uses.txt", &format!("#uses {name}.toml;\n{FORMULA}"));
        safe(folder.path(), &["render", "-f", "uses.txt", "-s", "sub/place.txt", "-o", "out.png", "--material", "ball=gold"]);
        write(&folder, "uses.txt", &format!("#uses preset:{name};\n{FORMULA}"));
        safe(folder.path(), &["check", "uses.txt"]);
        write(&folder, "comment.txt", &format!("formula;\n= /* {name} */ Cd*Q; // {name}\n"));
        safe(folder.path(), &["check", "comment.txt"]);
        write(&folder, "stranger.txt", &format!("formula;\n= Cd {name};\n{name} = 1;\n"));
        safe(folder.path(), &["check", "stranger.txt"]);
    }
    let long = "n".repeat(1 << 18);
    let formula = format!(
        "body_specific;\n{long}: scalar, constraint 1..0, default 5;\n{long}: scalar;\nformula;\n{long} = {long}x;\n= Cd*{long}x.{long};\n"
    );
    write(&folder, "long.txt", &formula);
    let said = safe(folder.path(), &["check", "long.txt"]);
    assert!(said.contains("…"), "{said}");
    let scene = SCENE.replace("ball", &long);
    write(&folder, "long-scene.txt", &scene.replace("radius 1", "radius -1"));
    safe(folder.path(), &["check", "long-scene.txt"]);
    write(&folder, "long-scene.txt", &scene);
    safe(
        folder.path(),
        &["render", "-f", "model.txt", "-s", "long-scene.txt", "-o", "out.png", "--set", "*.kd=7", "--size", "8x6"],
    );
}

#[test]
fn results_are_escaped() {
    let folder = folder();
    write(&folder, "uses.txt", &format!("#uses {HOSTILE}.toml;\n{FORMULA}"));
    let said = safe(folder.path(), &["dump", "-f", "uses.txt", "-s", "sub/place.txt", "--stage", "ast"]);
    assert!(said.starts_with("#uses x\\u{1b}[31m"), "{said}");
}
