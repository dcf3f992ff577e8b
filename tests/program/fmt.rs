//! Formatting of files.

use crate::{folder, run, told, write};
use illuminator::workspace::{FileKind, presets};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const ROUGH: &str = "body_specific ;kd:scalar,default 0.5; // matte\nformula;\n\n\n= kd*IL *Cd;";
const REGULAR: &str = "body_specific;\nkd: scalar, default 0.5; // matte\nformula;\n\n= kd*IL*Cd;\n";

#[test]
fn files_are_formatted_once() {
    let folder = folder();
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    write(&folder, "rough.formula", ROUGH);
    let output = run(folder.path(), "fmt rough.formula --stdout");
    assert_eq!((output.stdout.as_slice(), output.status.code()), (REGULAR.as_bytes(), Some(0)));
    assert_eq!(told(folder.path(), "fmt rough.formula --check"), "rough.formula: not formatted\nexit status 1\n");
    assert_eq!(text("rough.formula"), ROUGH);
    assert_eq!(told(folder.path(), "fmt rough.formula"), "rough.formula: formatted\nexit status 0\n");
    assert_eq!(text("rough.formula"), REGULAR);
    assert_eq!(told(folder.path(), "fmt rough.formula"), "rough.formula: unchanged\nexit status 0\n");
    assert_eq!(told(folder.path(), "fmt rough.formula --check"), "rough.formula: already formatted\nexit status 0\n");
    assert_eq!(told(folder.path(), "fmt sub/place.txt"), "sub/place.txt: formatted\nexit status 0\n");
    assert!(text("sub/place.txt").contains("\nball: sphere, center <0, 0, 0>, radius 1;\n"), "{}", text("sub/place.txt"));
}

#[test]
fn what_cannot_be_formatted_is_left_alone_and_the_others_are_done() {
    let folder = folder();
    write(&folder, "broken.formula", "formula;\n=Cd*(;");
    write(&folder, "rough.formula", ROUGH);
    crate::messages::check(
        "formatting",
        &folder,
        &["fmt broken.formula session.toml none.formula preset:lambert rough.formula", "fmt --check broken.formula", "fmt"],
    );
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    assert_eq!(text("broken.formula"), "formula;\n=Cd*(;");
    assert_eq!(text("rough.formula"), REGULAR);
}

/// What a command prints on standard output for this standard input, and its exit status.
fn filtered(folder: &Path, arguments: &[&str], input: &str) -> (String, Option<i32>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_illuminator"));
    let piped = command.current_dir(folder).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = piped.spawn().expect("the program runs");
    child.stdin.take().expect("a pipe").write_all(input.as_bytes()).expect("the program reads");
    let output = child.wait_with_output().expect("an end");
    (String::from_utf8(output.stdout).expect("UTF-8"), output.status.code())
}

#[test]
fn standard_input_is_formatted_to_standard_output() {
    let folder = folder();
    let filter = |input: &str| filtered(folder.path(), &["fmt", "-"], input);
    assert_eq!(filter(ROUGH), (REGULAR.to_owned(), Some(0)));
    let (scene, status) = filter(crate::SCENE);
    assert!(scene.contains("center <0, 0, 0>, radius 1;\n") && status == Some(0), "{scene}");
    // Names and types do not matter, only what can be read.
    assert_eq!(filter("formula;\n=kq + 1;"), ("formula;\n= kq + 1;\n".to_owned(), Some(0)));
    assert_eq!(filter("formula;\n= Cd*(;"), (String::new(), Some(1)));
    let check = |input: &str| filtered(folder.path(), &["fmt", "--check", "-"], input);
    assert_eq!(check(ROUGH), ("standard input: not formatted\n".to_owned(), Some(1)));
    assert_eq!(check(REGULAR), ("standard input: already formatted\n".to_owned(), Some(0)));
}

#[test]
fn built_in_texts_are_printed() {
    let folder = folder();
    for (name, kind) in [("phong", FileKind::Formula), ("studio", FileKind::Scene)] {
        // They are formatted.
        let text = presets::text(kind, name).expect("a built-in file");
        assert_eq!(filtered(folder.path(), &["fmt", "--stdout", &format!("preset:{name}")], ""), (text.to_owned(), Some(0)));
    }
}

#[cfg(unix)]
#[test]
fn links_and_permissions_stay_and_read_only_files_are_left_alone() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let permissions = |mode: u32| fs::set_permissions(path("target.formula"), fs::Permissions::from_mode(mode)).expect("ours");
    write(&folder, "target.formula", ROUGH);
    symlink("target.formula", path("link.formula")).expect("a link");
    permissions(0o444);
    let said =
        "Error: `link.formula` is read-only and is left as it is\n  Help: `--stdout` prints the formatted text\nexit status 1\n";
    assert_eq!(told(folder.path(), "fmt link.formula"), said);
    assert_eq!(fs::read_to_string(path("target.formula")).expect("a file"), ROUGH);
    permissions(0o640);
    assert_eq!(told(folder.path(), "fmt link.formula"), "link.formula: formatted\nexit status 0\n");
    assert!(fs::symlink_metadata(path("link.formula")).expect("a link").is_symlink());
    let target = fs::metadata(path("target.formula")).expect("a file");
    assert_eq!(target.permissions().mode() & 0o777, 0o640);
    assert_eq!(fs::read_to_string(path("target.formula")).expect("a file"), REGULAR);
}
