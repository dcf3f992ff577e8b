//! Sessions read, saved and met by formulas and scenes.

use super::*;
use crate::formula::Formula;
use crate::picture::{ToneCurve, Transfer};
use crate::scene::Scene;

const TEXT: &str = r#"version = 1
formula = "preset:phong"
scene = "../scenes/one.txt"
size = [1280, 720]
depth = 3
shadows = false
ior = 1.25
samples = 64
srgb = true
exposure = -1.5
curve = "aces"
[global]
ka = 0.3
[bodies.ball]
Cd = [0.9, 0.2, 0.1]
kd = 0.3
[lights.key]
ki = 1
"#;

fn parse(text: &str) -> Result<(Session, Diagnostics), Diagnostics> {
    Session::parse(&Source::new("s.toml", text))
}

fn messages(diagnostics: &Diagnostics) -> Vec<&str> {
    diagnostics.iter().map(Diagnostic::message).collect()
}

fn table() -> (Formula, Scene) {
    let formula = "body_specific; kd: scalar, constraint 0..1; invariants; formula; = kd*Cd;";
    let scene = "bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <9,9,9>;
                 camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    (Formula::parse(&Source::new("f", formula)).unwrap().0, Scene::parse(&Source::new("s", scene)).unwrap().0)
}

#[test]
fn a_session_is_read() {
    let (session, warnings) = parse(TEXT).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(session.formula, Location::Preset("phong".to_owned()));
    assert_eq!(session.scene, Location::new("../scenes/one.txt"));
    let view = ViewTransform { exposure: -1.5, curve: ToneCurve::Aces, transfer: Transfer::Srgb };
    let picture = PictureSettings { size: [1280, 720], depth: 3, shadows: false, default_index: 1.25, samples: Some(64), view };
    assert_eq!(session.picture, picture);
    assert_eq!(session.picture.passes(), 64);
    assert_eq!(session.values.len(), 4);
}

#[test]
fn what_is_saved_is_read_back() {
    let (formula, scene) = table();
    let mut values = Values::defaults(&formula, &scene);
    let (session, _) = parse(TEXT).unwrap();
    let (assignments, warnings) = session.assignments(values.table());
    assert!(warnings.is_empty(), "{warnings:?}");
    values.assign(&assignments);
    let full = Session { values: Session::name_values(&values), ..session };
    let text = full.to_toml(std::path::Path::new("")).unwrap();
    let (again, _) = parse(&text).unwrap();
    let (assignments, _) = again.assignments(values.table());
    let (restored, warnings) = Values::new(&formula, &scene, &assignments);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(restored, values);
    assert_eq!(again.picture, full.picture);
    assert!(text.contains("kd = 0.3\n"), "{text}");
}

#[test]
fn all_errors_are_reported_at_once() {
    let errors = parse("version = 2\nscene = 3\nsize = [0, 480, 1]\ndepth = 10\nshadows = 1\n[bodies.b]\nkr = true\nkt = inf\n")
        .unwrap_err();
    assert_eq!(
        messages(&errors),
        [
            "the session names no formula",
            "version 2 of this file cannot be read",
            "expected a text in quotes, found a whole number",
            "expected width and height, `[640, 480]`",
            "10 is out of range",
            "expected `true` or `false`, found a whole number",
            "expected a number, or three as `[x, y, z]`, found true or false",
            "this number is too large or not finite",
        ]
    );
}

#[test]
fn a_session_need_not_say_how_many_passes() {
    let (session, _) = parse(&TEXT.replace("samples = 64\n", "")).unwrap();
    assert_eq!((session.picture.samples, session.picture.passes()), (None, 1));
    assert!(!session.to_toml(Path::new("")).unwrap().contains("samples"));
    // One pass that is asked for is another thing: the window makes more if it is not.
    let (session, _) = parse(&TEXT.replace("samples = 64", "samples = 1")).unwrap();
    assert!(session.to_toml(Path::new("")).unwrap().contains("samples = 1\n"));
    for wrong in ["0", "65537", "-1"] {
        let errors = parse(&TEXT.replace("samples = 64", &format!("samples = {wrong}"))).unwrap_err();
        assert_eq!(messages(&errors), [format!("{wrong} is out of range")]);
    }
}

#[test]
fn a_view_transform_out_of_range_is_refused() {
    for (right, wrong, message) in [
        ("exposure = -1.5", "exposure = 17", "the exposure 17 is out of range"),
        ("curve = \"aces\"", "curve = \"film\"", "there is no such tone curve"),
    ] {
        let errors = parse(&TEXT.replace(right, wrong)).unwrap_err();
        assert_eq!(messages(&errors), [message]);
    }
}

#[test]
fn errors_of_the_syntax_have_their_place() {
    let source = Source::new("s.toml", "\u{feff}version = 1\nformula = \"a\nscene = \n");
    let errors = Session::parse(&source).unwrap_err();
    let lines: Vec<usize> = errors.iter().map(|error| source.position(error.span().unwrap().start).0).collect();
    assert_eq!(lines, [2, 3]);
}

#[test]
fn a_misspelt_key_that_is_needed_is_one_error() {
    let source = Source::new("s.toml", "version = 1\nformulla = \"preset:phong\"\nscene = \"preset:studio\"\n");
    let errors = Session::parse(&source).unwrap_err();
    assert_eq!(messages(&errors), ["the session names no formula"]);
    let error = errors.iter().next().unwrap();
    assert_eq!(source.position(error.span().unwrap().start).0, 2);
    assert!(error.hints().iter().any(|hint| hint.starts_with("did you mean `formula`?")));
}

#[test]
fn misspelt_names_have_a_suggestion() {
    let (formula, scene) = table();
    let (session, _) = parse(&(TEXT.replace("[bodies.ball]", "[bodies.bal]").replace("ki = 1", "kii = 1"))).unwrap();
    let (_, leftovers) = session.assignments(&ParameterTable::new(&formula, &scene));
    let helps: Vec<&str> = leftovers.iter().flat_map(|leftover| leftover.warning.hints().iter().map(String::as_str)).collect();
    assert_eq!(helps, ["did you mean `ball`?", "did you mean `ki`?"]);
}

#[test]
fn what_no_longer_exists_is_warned_of() {
    let (formula, scene) = table();
    let text = TEXT.replace("ball", "bowl").replace("ki = 1", "ki = [1, 1, 1]\nkd = 1") + "[bodies.key]\n[lights.ball]\nki = 1\n";
    let (session, warnings) = parse(&(text.replace("depth", "dept"))).unwrap();
    assert_eq!(messages(&warnings), ["`dept` is unknown here and is ignored"]);
    let table = ParameterTable::new(&formula, &scene);
    let (assignments, leftovers) = session.assignments(&table);
    assert_eq!(assignments.len(), 1);
    assert_eq!(
        leftovers.iter().map(|leftover| leftover.warning.message()).collect::<Vec<_>>(),
        [
            "the scene has no body `bowl`; its values are ignored",
            "`ki` is a scalar in the formula; this value is ignored",
            "the formula has no light parameter `kd`; its value is ignored",
            "the scene has no light `ball`; its values are ignored",
        ]
    );
}

#[test]
fn saving_replaces_the_file_and_keeps_paths_relative() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sessions")).unwrap();
    std::fs::write(folder.path().join("one.txt"), "").unwrap();
    let (mut session, _) = parse(TEXT).unwrap();
    session.scene = Location::File(folder.path().join("one.txt"));
    let path = folder.path().join("sessions/s.toml");
    session.save(&path).unwrap();
    assert!(std::fs::read_to_string(&path).unwrap().contains("scene = \"../one.txt\"\n"));
    assert!(session.save(&folder.path().join("none/s.toml")).is_err());
}
