//! Formatting of files.

use crate::{folder, run, told, write};
use std::fs;

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
    assert_eq!(told(folder.path(), "fmt rough.formula --check"), "rough.formula: formatted\nexit status 0\n");
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
