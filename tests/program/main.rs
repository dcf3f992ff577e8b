//! The real program: its messages, files and exit status.

#![allow(clippy::expect_used, reason = "a test ends where what it needs is not there")]

mod diagnostics;
mod encoding;
mod endings;
mod export;
mod farm;
mod files;
mod fit;
mod fmt;
mod habits;
mod hits;
mod import;
mod json;
mod light;
mod lsp;
mod man;
#[cfg(unix)]
mod manual;
mod materials;
mod measure;
mod measured;
mod memory;
mod messages;
mod misspellings;
mod pictures;
mod pipe;
mod plot;
mod rays;
mod sweep;
mod terminal;
mod textures;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A small formula without a mistake.
const FORMULA: &str = "body_specific;
kd: scalar, constraint 0..1, default 0.5, slider;
ks: scalar, constraint 0..1, default 0.2, slider;
h: scalar, constraint 1..100, default 20;
invariants;
kd + ks <= 1;
formula;
= kd*IL*Cd*max(0, N.L) + ks*IL*max(0, R.V)^h;
";

/// A small scene without a mistake.
const SCENE: &str = "bodies;
ball: sphere, center <0,0,0>, radius 1;
floor: rectangle, <-9,-1,-9>, <9,-1,-9>, <9,-1,9>, opaque;
lights;
key: point, <4,6,5>;
camera;
position <0,1,6>; gaze <0,-0.15,-1>; up <0,1,0>; fov 40;
";

/// A folder with a formula, a scene and a session of both. The program runs in it.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::create_dir(folder.path().join("sub")).expect("a folder in it");
    let session = "version = 1\nformula = \"model.txt\"\nscene = \"sub/place.txt\"\nsize = [32, 24]\ndepth = 2\n[bodies.ball]\nCd = [1, 0, 0]\n";
    write(&folder, "model.txt", FORMULA);
    write(&folder, "sub/place.txt", SCENE);
    write(&folder, "session.toml", session);
    folder
}

fn write(folder: &TempDir, name: &str, text: &str) {
    fs::write(folder.path().join(name), text).expect("a file in a temporary folder");
}

/// Runs the program in a folder; the arguments are separated by blanks.
fn run(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .env_remove("RUST_BACKTRACE")
        // The width of help.
        .env_remove("COLUMNS")
        // No window is opened.
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        // Files that the user who runs the tests has saved are neither read nor changed.
        .env("HOME", folder.join("home"))
        .env("XDG_DATA_HOME", folder.join("home/data"))
        .output()
        .expect("the program runs")
}

/// What the program says and returns. No message begins with its severity twice.
fn told(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("text");
    let (result, said) = (text(&output.stdout), text(&output.stderr));
    for line in said.lines().map(str::to_lowercase) {
        let severity = |text: &str| ["error:", "warning:"].into_iter().find(|word| text.starts_with(word));
        let behind = severity(&line).map(|word| line[word.len()..].trim_start());
        assert_eq!(behind.and_then(severity), None, "{said}");
    }
    let status = output.status.code().expect("an exit status");
    format!("{result}{said}exit status {status}\n")
}
