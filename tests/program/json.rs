//! Diagnostics for other programs.

use crate::{folder, run, write};
use serde_json::{Value, json};
use std::path::Path;

/// What `check --json` prints, and its exit status.
fn checked(folder: &Path, arguments: &str) -> (Vec<Value>, Option<i32>) {
    let output = run(folder, &format!("check --json {arguments}"));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    (serde_json::from_slice(&output.stdout).expect("a list in JSON"), output.status.code())
}

#[test]
fn places_are_counted_as_editors_do() {
    let folder = folder();
    write(&folder, "wrong a.formula", "\u{feff}/* 😀 */ formula;\n/* 😀é */ = IL*Cb\n  *max(0, N.L);\r\n");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .current_dir(folder.path())
        .args(["check", "--json", "wrong a.formula"])
        .output()
        .expect("the program runs");
    let files: Vec<Value> = serde_json::from_slice(&output.stdout).expect("a list in JSON");
    assert_eq!(files.len(), 1);
    assert_eq!(files[0]["path"], "wrong a.formula");
    let uri = files[0]["uri"].as_str().expect("a URI");
    assert!(uri.starts_with("file:///") && uri.ends_with("/wrong%20a.formula"), "{uri}");
    let found = &files[0]["diagnostics"][0];
    assert_eq!(found["message"], "`Cb` is not known");
    assert_eq!(found["range"], json!({"start": {"line": 1, "character": 15}, "end": {"line": 1, "character": 17}}));
    assert_eq!((&found["severity"], &found["source"]), (&json!(1), &json!("illuminator")));
    assert_eq!(found["data"]["hints"], json!(["declare it, as in `Cb: scalar, constraint 0..1, slider;`"]));
    assert_eq!(found["data"]["remark"], "no parameter, macro, variable or function has this name");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn every_file_is_listed_with_what_is_wrong() {
    let folder = folder();
    write(
        &folder,
        "twice.scene",
        "bodies;\na: sphere, center <0,0,0>, radius 1;\na: sphere, center <0,0,0>, radius 1;\nlights;\ncamera;\nposition <0,1,6>; gaze <0,0,-1>; up <0,1,0>; fov 40;",
    );
    write(&folder, "model.txt", "formula;\n= Cd*;");
    let (files, status) = checked(folder.path(), "twice.scene none.formula session.toml preset:lambert");
    assert_eq!(status, Some(1));
    let names: Vec<&str> = files.iter().filter_map(|file| file["path"].as_str()).collect();
    assert_eq!(names, ["twice.scene", "none.formula", "session.toml", "sub/place.txt", "model.txt", "preset:lambert"]);
    let of = |index: usize| files[index]["diagnostics"].as_array().expect("a list");
    let related = &of(0)[0]["relatedInformation"][0];
    assert_eq!(
        (&related["message"], &related["location"]["range"]["start"]),
        (&json!("the first time"), &json!({"line": 1, "character": 0}))
    );
    assert_eq!(related["location"]["uri"], files[0]["uri"]);
    assert!(of(1)[0]["message"].as_str().is_some_and(|message| message.contains("there is no such file")));
    assert_eq!((of(2).len(), of(3).len(), of(4).len(), of(5).len()), (0, 0, 1, 0));
    assert_eq!(files[5]["uri"], "preset:lambert");
    let (sound, status) = checked(folder.path(), "preset:lambert");
    assert_eq!((sound[0]["diagnostics"].clone(), status), (json!([]), Some(0)));
}
