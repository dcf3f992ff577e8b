//! What would take more memory than allowed is refused before it is allocated, with the figure.

use crate::folder;
use std::collections::HashMap;
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

/// What rendering a scene of pairs says within this much memory, by this backend on two threads.
fn refused(backend: &str, [bodies, lights]: [usize; 2], memory: &str) -> String {
    let folder = folder();
    let path = folder.path().join("pairs.scene");
    std::fs::write(&path, scene(bodies, lights)).expect("a scene file");
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .args(["render", "--formula", "preset:phong", "--size", "16x12", "--threads", "2"])
        .args(["--backend", backend, "--memory", memory, "--scene"])
        .arg(&path)
        .arg("-o")
        .arg(folder.path().join("out.png"))
        .output()
        .expect("the program runs");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The amount after these words, in MiB.
fn mebibytes(told: &str, before: &str) -> f64 {
    let mut words = told.split(before).nth(1).expect("an amount").split(|character: char| " ;".contains(character));
    let number: f64 = words.next().and_then(|word| word.parse().ok()).expect("a number");
    let scale = HashMap::from([("GiB", 1024.0), ("MiB", 1.0)]);
    number * scale[words.next().expect("a unit")]
}

#[test]
fn values_of_pairs_are_counted() {
    let told = refused("jit", [1000, 1000], "64MiB");
    assert!(told.contains("pairs of a body and a light") && told.contains("64.0 MiB may be used"), "{told}");
    // Seven uniform values of 64 bytes each, and more, for a million pairs.
    let mebibytes = mebibytes(&told, "take about ");
    assert!((427.0..800.0).contains(&mebibytes), "{told}");
}

#[test]
fn parameter_values_are_counted() {
    // 1000 bodies with seven numbers or more each, 16 bytes a number.
    let told = refused("jit", [1000, 1], "64KiB");
    assert!(told.contains("parameter values of all bodies and lights") && told.contains("64.0 KiB may be used"), "{told}");
    let amount = told.split("take ").nth(1).and_then(|rest| rest.split(' ').next()).and_then(|word| word.parse::<f64>().ok());
    assert!(amount.is_some_and(|kibibytes| (109.0..400.0).contains(&kibibytes)) && told.contains(" KiB of memory"), "{told}");
}

#[test]
fn small_amounts_of_memory_are_named() {
    let told = refused("interpreter", [2, 2], "1KiB");
    assert!(told.contains("1.0 KiB may be used"), "{told}");
    assert!(!told.contains("0.0 MiB"), "{told}");
}

#[test]
fn columns_of_many_lights_are_counted_for_each_thread() {
    let told = refused("jit", [2, 70_000], "256MiB");
    assert!(told.contains("2 threads") && told.contains("256.0 MiB may be used"), "{told}");
    // Phong's model reads four vectors of each light, of 1024 hits at a time.
    let expected = 70_000.0 * 12.0 * 1024.0 * 4.0 / f64::from(1 << 20);
    let thread = mebibytes(&told, "one takes ");
    assert!((0.98 * expected..1.02 * expected).contains(&thread), "{told}");
}

#[test]
fn programs_of_the_interpreter_are_counted_for_each_thread() {
    let told = refused("interpreter", [2, 70_000], "24MiB");
    // An instance of Phong's model takes more than 80 bytes: four vectors of twelve, and as many references of five.
    let least = 70_000.0 * 80.0 / f64::from(1 << 20);
    assert!(mebibytes(&told, "takes up to ") > 2.0 * least && told.contains("1 would fit; use fewer threads"), "{told}");
}
