//! What would take more memory than allowed is refused before it is allocated, with the figure.

use crate::folder;
use std::fmt::Write;
use std::process::Command;

/// A scene of this many bodies and lights.
fn scene(bodies: usize, lights: usize) -> String {
    let mut text = "bodies;\n".to_owned();
    for body in 0..bodies {
        let (x, y) = (body % 40, body / 40);
        writeln!(text, "b{body}: sphere, center <{x}, {y}, 0>, radius 0.3, opaque, matte;").expect("text");
    }
    text.push_str("lights;\n");
    for light in 0..lights {
        writeln!(text, "l{light}: point, <{light}, 50, 50>;").expect("text");
    }
    text + "camera; position <20, 12, 60>; gaze <0, 0, -1>; up <0, 1, 0>; fov 40;\n"
}

/// What rendering a scene of pairs says within this much memory.
fn refused(bodies: usize, lights: usize, memory: &str) -> String {
    let folder = folder();
    let path = folder.path().join("pairs.scene");
    std::fs::write(&path, scene(bodies, lights)).expect("a scene file");
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .args(["render", "--formula", "preset:phong", "--size", "16x12", "--memory", memory, "--scene"])
        .arg(&path)
        .arg("-o")
        .arg(folder.path().join("out.png"))
        .output()
        .expect("the program runs");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn values_of_pairs_are_counted() {
    let told = refused(1000, 1000, "64MiB");
    assert!(told.contains("pairs of a body and a light") && told.contains("64.0 MiB may be used"), "{told}");
    // Seven uniform values of 64 bytes each, and more, for a million pairs.
    let amount = told.split("take about ").nth(1).and_then(|rest| rest.split(' ').next()).expect("an amount");
    let mebibytes: f64 = amount.parse().expect("a number");
    assert!((427.0..800.0).contains(&mebibytes), "{told}");
}

#[test]
fn small_amounts_of_memory_are_named() {
    let told = refused(2, 2, "1KiB");
    assert!(told.contains("1.0 KiB may be used"), "{told}");
    assert!(!told.contains("0.0 MiB"), "{told}");
}
