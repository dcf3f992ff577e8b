//! Fits by the real program: known values come back, and mistakes are told.

use crate::{folder, run, told, write};
use illuminator::measured::merl;
use serde_json::Value;
use std::path::Path;

/// A ball and a floor, small.
const SESSION: &str = "version = 1\nformula = \"model.formula\"\nscene = \"small.scene\"\nsize = [40, 30]\n";
const SCENE: &str = "bodies; ball: sphere, center <0,1,0>, radius 1; floor: rectangle, <-4,0,-4>, <4,0,-4>, <4,0,4>;
lights; key: point, <4,6,5>; camera; position <0,1.6,6>; gaze <0,-0.1,-1>; up <0,1,0>; fov 45;\n";
const FORMULA: &str = "body_specific; kd: scalar, constraint 0..1, default 0.5; ks: scalar, constraint 0..1, default 0.5;
h: scalar, constraint 1..500, default 50; kind: scalar, switch; invariants; ks + kd = 1;
formula; = IL*(kd*Cd*max(0, N.L) + <ks*(h + 2)/8*max(0, N.H)^h>*max(0, N.L));\n";

fn prepared() -> tempfile::TempDir {
    let folder = folder();
    write(&folder, "model.formula", FORMULA);
    write(&folder, "small.scene", SCENE);
    write(&folder, "small.toml", SESSION);
    folder
}

fn fitted(folder: &Path, arguments: &str) -> Value {
    let output = run(folder, &format!("fit small.toml --json {arguments}"));
    assert_eq!(output.status.code(), Some(0), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// The value that a parameter has after a fit.
fn after(found: &Value, name: &str) -> f64 {
    let parameters = found["parameters"].as_array().expect("parameters");
    let found = parameters.iter().find(|parameter| parameter["name"] == name);
    found.expect("a parameter of this name")["after"].as_f64().expect("a number")
}

fn near(found: f64, wanted: f64) {
    assert!((found - wanted).abs() <= 1e-3 * wanted.abs(), "{found}, not {wanted}");
}

#[test]
fn what_a_formula_alone_was_fitted_to_holds_in_other_commands() {
    let folder = folder();
    write(&folder, "matte.txt", "body_specific; kd: scalar, constraint 0..1, default 0.9; formula; = IL*<kd>*max(0, N.L);");
    // The reflectance of an albedo of 0.4 is 0.4/π.
    let lines = [0, 20, 40, 60].map(|angle| format!("{angle},0,{angle},180,0.127324,0.127324,0.127324\n"));
    write(&folder, "matte.csv", &lines.concat());
    let said = told(folder.path(), "fit matte.txt --to matte.csv --within 60 --samples 4 -o found.toml");
    assert!(said.contains("`--within` counts for measured materials only"), "{said}");
    assert!(said.contains("`--samples` counts for pictures only"), "{said}");
    let set = said.lines().find_map(|line| line.strip_prefix("--set '")?.strip_suffix('\'')).expect("arguments");
    assert!(set.starts_with("*.kd=0.4"), "{said}");
    // The first body of the session is another one than the one that was fitted.
    for arguments in [format!("matte.txt --set {set}"), "found.toml".to_owned()] {
        let output = run(folder.path(), &format!("measure --json {arguments}"));
        let measured: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        near(measured["greatest_albedo"]["share"].as_f64().expect("a number"), 0.4);
    }
}

#[test]
fn an_invariant_that_binds_is_told() {
    let folder = folder();
    let formula = "body_specific; kd: scalar, constraint 0..1, default 0.3; ks: scalar, constraint 0..1, default 0.2;
invariants; kd + ks <= 1; formula; = IL*max(0, N.L)*<kd + ks*(N.V)>;\n";
    write(&folder, "two.txt", formula);
    // (0.9 + 0.5 V)/π, which takes more than 1 in all.
    let line = |angle: f64| {
        let value = (0.9 + 0.5 * angle.to_radians().cos()) / std::f64::consts::PI;
        format!("30,0,{angle},180,{value},{value},{value}\n")
    };
    write(&folder, "two.csv", &[0.0, 30.0, 60.0, 75.0].map(line).concat());
    let said = told(folder.path(), "fit two.txt --free kd,ks --to two.csv");
    assert!(said.contains("ball.kd + ball.ks <= 1 binds"), "{said}");
    let output = run(folder.path(), "fit two.txt --free kd,ks --to two.csv --json");
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["binding"], serde_json::json!(["ball.kd + ball.ks <= 1"]));
    near(after(&found, "ball.kd") + after(&found, "ball.ks"), 1.0);
}

#[test]
fn values_of_a_picture_come_back_in_a_session() {
    let folder = prepared();
    let made = run(folder.path(), "render small.toml --set ball.ks=0.3 --set ball.h=20 --set floor.kr=0.25 -o wanted.exr");
    assert_eq!(made.status.code(), Some(0));
    let found = fitted(folder.path(), "--to wanted.exr --free ks,h,floor.kr --starts 3 -o found.toml --chart found.svg");
    for (name, wanted) in [("ball.ks", 0.3), ("ball.h", 20.0), ("floor.kr", 0.25), ("ball.kd", 0.7)] {
        near(after(&found, name), wanted);
    }
    assert_eq!((&found["cancelled"], &found["undetermined"]), (&Value::Bool(false), &Value::Array(Vec::new())));
    // The session makes the same picture.
    for name in ["found.toml", "wanted.exr"] {
        assert!(folder.path().join(name).is_file());
    }
    let again = run(folder.path(), "render found.toml -o again.exr");
    assert_eq!(again.status.code(), Some(0));
    let read = |name: &str| illuminator::picture::read_picture(&folder.path().join(name)).expect("a picture").numbers;
    let (wanted, again) = (read("wanted.exr"), read("again.exr"));
    let pixels = wanted.linear.as_flattened().iter().zip(again.linear.as_flattened());
    let worst = pixels.map(|(one, other)| (one - other).abs()).fold(0.0, f32::max);
    assert!(worst < 2e-3, "{worst}");
    let chart = std::fs::read_to_string(folder.path().join("found.svg")).expect("a chart");
    assert!(["wanted", "before", "after"].iter().all(|word| chart.contains(word)), "{chart}");
}

#[test]
fn bytes_of_a_picture_are_decoded() {
    let folder = prepared();
    let made = run(folder.path(), "render small.toml --set ball.ks=0.6 --set ball.h=10 -o wanted.png");
    assert_eq!(made.status.code(), Some(0));
    let found = fitted(folder.path(), "--to wanted.png --free ks,h --starts 2");
    // Bytes are rounded.
    assert!((after(&found, "ball.ks") - 0.6).abs() < 0.01, "{found}");
    assert!((after(&found, "ball.h") - 10.0).abs() < 0.3, "{found}");
}

#[test]
fn values_of_a_measured_material_come_back() {
    let folder = prepared();
    let model = |light: glam::DVec3, view: glam::DVec3| {
        let half = (light + view).normalize();
        let gloss = 0.4 * (30.0 + 2.0) / 8.0 * half.z.max(0.0).powi(30);
        (0.6 * glam::DVec3::new(0.8, 0.4, 0.2) + glam::DVec3::splat(gloss)) / std::f64::consts::PI
    };
    std::fs::write(folder.path().join("known.binary"), merl::bytes(model)).expect("a file");
    let found = fitted(folder.path(), "--to known.binary --free ks,h,Cd --directions 3000 --starts 4 --chart balls.png");
    for (name, wanted) in
        [("ball.ks", 0.4), ("ball.kd", 0.6), ("ball.h", 30.0), ("ball.Cd.r", 0.8), ("ball.Cd.g", 0.4), ("ball.Cd.b", 0.2)]
    {
        near(after(&found, name), wanted);
    }
    let chart = illuminator::picture::read_picture(&folder.path().join("balls.png")).expect("a chart");
    assert_eq!((chart.numbers.width, chart.numbers.height), (1200, 440));
    let first = chart.numbers.linear[0];
    assert!(chart.numbers.linear.iter().any(|pixel| *pixel != first));
    let logarithmic = fitted(folder.path(), "--to known.binary --free ks,h,Cd --directions 3000 --starts 4 --metric log");
    near(after(&logarithmic, "ball.h"), 30.0);
}

#[test]
fn formulas_that_are_not_reciprocal_are_told_where_files_hold_none() {
    let folder = folder();
    let matte = |_: glam::DVec3, _: glam::DVec3| glam::DVec3::splat(0.1);
    std::fs::write(folder.path().join("matte.binary"), merl::bytes(matte)).expect("a file");
    std::fs::write(folder.path().join("matte.csv"), "30,0,40,180,0.1,0.1,0.1\n").expect("a file");
    let formula =
        |shape: &str| format!("body_specific; kd: scalar, constraint 0..1, default 0.3; formula; = IL*max(0, N.L)*<kd*{shape}>;");
    write(&folder, "same.txt", &formula("(N.L)*(N.V)"));
    write(&folder, "other.txt", &formula("(N.V)"));
    for (name, data, is_told) in
        [("other.txt", "matte.binary", true), ("same.txt", "matte.binary", false), ("other.txt", "matte.csv", false)]
    {
        let said = told(folder.path(), &format!("fit {name} --to {data}"));
        assert_eq!(said.contains("reciprocal part"), is_told, "{name} {data}: {said}");
    }
}

#[test]
fn mistakes_are_told_with_the_likely_fix() {
    let folder = prepared();
    write(&folder, "bad.csv", "theta_i,phi_i,theta_o,phi_o,r,g,b\n10,0,20\n");
    write(&folder, "one.csv", "0,0,0,0,0.3,0.3,0.3\n");
    let cases = [
        ("--to missing.binary", "missing.binary", 1),
        ("--to bad.csv", "line 2", 1),
        ("--to one.csv --free hh", "its parameters are Cd, kr", 2),
        ("--to one.csv --free bal.kd", "did you mean `ball`?", 2),
        ("--to one.csv --free kd", "follows from others", 2),
        ("--to one.csv --free kind", "cannot be fitted", 2),
        ("--to one.csv --free h=0..10", "do not lie within its range, 1..500", 2),
        ("--to one.csv --free key.h", "it is a body parameter", 2),
        ("--to one.csv --free h=5", "kd=0..0.5", 2),
        ("--to one.csv --body flor", "did you mean `floor`?", 2),
        ("--to one.csv --chart found.gif", "neither .png nor .svg", 2),
        ("--to small.toml", "takes a measured material", 2),
        ("--to photograph.jpg", "pictures to fit to are .exr", 2),
        ("--to one.csv -o found.png", "ends in .toml", 2),
        ("--to one.csv --free h,h", "`h` is named twice", 2),
        ("--to one.csv --free ks=0.5..0.2", "wrong order", 2),
        ("--to one.csv -o small.toml", "overwrite", 2),
    ];
    for (arguments, wanted, status) in cases {
        let said = told(folder.path(), &format!("fit small.toml {arguments}"));
        assert!(said.contains(wanted) && said.ends_with(&format!("exit status {status}\n")), "{arguments}: {said}");
    }
    let said = told(folder.path(), "fit gold.binary --to one.csv");
    assert!(said.contains("is a measured material") && said.contains("`--formula`"), "{said}");
    // Nothing was written.
    assert_eq!(std::fs::read_to_string(folder.path().join("small.toml")).expect("a session"), SESSION);
}
