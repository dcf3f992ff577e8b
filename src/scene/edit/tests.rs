//! Edits of texts: what is changed, and what stays.

use super::*;
use crate::scene::{Shape, Syntax, Transform};
use proptest::prelude::*;

const CAMERA: &str = "camera; position <0, 1, 5>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";

fn scene_of(text: &str) -> Scene {
    Scene::parse(&Source::new("scene", text)).unwrap_or_else(|errors| panic!("{text}\n{errors:?}")).0
}

fn edited(text: &str, change: &SceneChange, precision: Precision) -> SceneEdit {
    let done = edit(&Source::new("scene", text), change, precision).unwrap();
    assert_eq!(done.scene, scene_of(&done.text));
    assert_eq!(applied(text, &done.replacements), done.text);
    done
}

fn form(text: &str, id: u32) -> BodyForm {
    scene_of(text).body(BodyId(id)).form.clone()
}

#[test]
fn only_the_numbers_that_change_are_written_again() {
    let text = "bodies; /* two */\n ball:  sphere, center <-0.5 /* left */, 1.250, +0>, radius 1.25, opaque; // round\n"
        .replace('+', "")
        + "lights; key: point, <1,2,  -3>;\n"
        + CAMERA;
    let by = DVec3::new(0.25, 0.0, 0.125);
    let moved = form(&text, 0).moved(by).unwrap();
    let done = edited(&text, &SceneChange::Form(BodyId(0), moved), Precision::Decimals(2));
    assert_eq!(done.text, text.replace("-0.5 /*", "-0.25 /*").replace("1.250, 0>", "1.250, 0.12>"));
    let light = scene_of(&text).lights[0].kind.moved(DVec3::new(0.0, 0.0, 4.0)).unwrap();
    let done = edited(&text, &SceneChange::Light(LightId(0), light), Precision::Decimals(2));
    assert_eq!(done.text, text.replace("  -3>", "  1>"));
    let larger = form(&text, 0).scaled(1.1).unwrap();
    let done = edited(&text, &SceneChange::Form(BodyId(0), larger), Precision::Decimals(2));
    assert_eq!(done.text, text.replace("radius 1.25", "radius 1.38"), "1.375, to the decimals of the text");
}

#[test]
fn transforms_are_changed_one_by_one_and_added_behind_the_last_one() {
    let scene = |body: &str| format!("bodies;\n b: {body}; // end\nlights;\n{CAMERA}");
    let moved = |body: &str, by: DVec3| {
        let text = scene(body);
        let change = SceneChange::Form(BodyId(0), form(&text, 0).moved(by).unwrap());
        edited(&text, &change, Precision::Decimals(2)).text
    };
    let by = DVec3::new(0.25, 0.0, 0.125);
    let ball = "sphere, center <0,0,0>, radius 1";
    assert_eq!(
        moved(&format!("{ball}, rotate <0, 1, 0> 12.3456 /* x */ , matte"), by),
        scene(&format!("{ball}, rotate <0, 1, 0> 12.3456, translate <0.25, 0, 0.12> /* x */ , matte"))
    );
    assert_eq!(
        moved(&format!("{ball}, opaque, scale .5, /* to the left */ translate <-1,0,0>, matte"), by),
        scene(&format!("{ball}, opaque, scale .5, /* to the left */ translate <-0.75,0,0.12>, matte"))
    );
    assert_eq!(moved(&format!("{ball}, fit <1,1,1> 3"), by), scene(&format!("{ball}, fit <1.25,1,1.12> 3")));
    let resized = |body: &str, by: f64| {
        let text = scene(body);
        let change = SceneChange::Form(BodyId(0), form(&text, 0).scaled(by).unwrap());
        edited(&text, &change, Precision::Decimals(1)).text
    };
    assert_eq!(resized(&format!("{ball}, fit <1,1,1> 3, scale 2"), 1.5), scene(&format!("{ball}, fit <1,1,1> 4.5, scale 2")));
    let grown = scene("sphere, center <0,0,0>, radius 1.5, scale <1,2,3>, matte");
    assert_eq!(resized(&format!("{ball}, scale <1,2,3>, matte"), 1.5), grown);
    // Others in their place.
    let text = scene(&format!("{ball}, scale 1.23456, opaque, rotate <0,0,1> 30, translate <1,1,1>"));
    let new = BodyForm { transforms: vec![Transform::Scale(2.0)], ..form(&text, 0) };
    let done = edited(&text, &SceneChange::Form(BodyId(0), new), Precision::Exact);
    assert_eq!(done.text, scene(&format!("{ball}, scale 2, opaque")));
    let copy = SceneChange::Duplicate(SceneObject::Body(BodyId(0)), "c".to_owned(), DVec3::X);
    let copied = edited(&text, &copy, Precision::Decimals(2)).text;
    let line = format!(" c: {ball}, scale 1.23456, opaque, rotate <0,0,1> 30, translate <2,1,1>;\n");
    assert!(copied.contains(&line), "{copied}");
}

#[test]
fn numbers_keep_the_decimals_that_a_person_wrote() {
    let text = format!("bodies; b: rectangle, <0.125, 0, 0>, <0.125, 1, 0>, <1.125, 1, 0>; lights; {CAMERA}");
    let moved = form(&text, 0).moved(Precision::Decimals(1).round(DVec3::new(0.12345, 0.0, 0.26))).unwrap();
    let done = edited(&text, &SceneChange::Form(BodyId(0), moved), Precision::Decimals(1));
    assert!(done.text.contains("<0.225, 0, 0.3>, <0.225, 1, 0.3>, <1.225, 1, 0.3>"), "{}", done.text);
    // Large scenes have large steps.
    let text = format!("bodies; b: sphere, center <1e6, 0, 0>, radius 25000; lights; {CAMERA}");
    let moved = form(&text, 0).moved(DVec3::new(123_456.0, 7.0, -987_654.0)).unwrap();
    let done = edited(&text, &SceneChange::Form(BodyId(0), moved), Precision::for_size(2e6));
    assert!(done.text.contains("center <1123000, 0, -988000>, radius 25000"), "{}", done.text);
    // A radius that would vanish is written exactly.
    let small = form(&text, 0).scaled(1e-9).unwrap();
    let done = edited(&text, &SceneChange::Form(BodyId(0), small.clone()), Precision::for_size(2e6));
    assert_eq!(done.scene.body(BodyId(0)).form, small);
}

#[test]
fn the_camera_is_written_in_place_with_few_digits() {
    let text = "bodies;\nlights;\ncamera; // seen from here\n\tposition <0.2, 2.1, 8>; gaze <0, -0.15,\n -1>; up <0,1,0>; fov 29; // deg";
    let camera = scene_of(text).camera;
    let orbited = camera.orbited(DVec3::ZERO, 0.3, 0.1).unwrap();
    let done = edited(text, &SceneChange::Camera(orbited.clone()), Precision::for_size(8.0));
    assert_eq!(
        done.text,
        // By Rodrigues' formula, twice.
        "bodies;\nlights;\ncamera; // seen from here\n\tposition <2.481, 2.888, 7.345>; gaze <-0.2896, -0.2491,\n -0.9363>; \
         up <0,1,0>; fov 29; // deg"
    );
    let wide = edited(text, &SceneChange::Camera(camera.widened(1.1).unwrap()), Precision::for_size(8.0));
    assert_eq!(wide.text, text.replace("fov 29", "fov 31.76"));
    let exact = edited(text, &SceneChange::Camera(orbited.clone()), Precision::Exact);
    assert_eq!(exact.scene.camera, orbited);
}

#[test]
fn directions_and_angles_of_lights_keep_their_digits_in_scenes_of_any_size() {
    let spot = "spot, <1000000, 5000, 0>, target <1000000, 0, 0>, angle 22.5, soft 2.5";
    let sun = "directional, <0.25, -1, 0.125>";
    let text = format!("bodies;\nlights; s: {spot}; d: {sun}; {CAMERA}");
    let scene = scene_of(&text);
    let precision = Precision::for_size(1e6);
    let moved = scene.lights[0].kind.moved(DVec3::new(-123_000.0, 7000.0, 0.0)).unwrap();
    let done = edited(&text, &SceneChange::Light(LightId(0), moved), precision);
    // The target goes with the position.
    assert_eq!(done.text, text.replace("<1000000, 5000,", "<877000, 12000,").replace("<1000000, 0,", "<877000, 7000,"));
    for (light, written) in scene.lights.iter().zip([spot, sun]) {
        let added = edited(&text, &SceneChange::AddLight("new".to_owned(), light.kind.clone()), precision).text;
        assert!(added.contains(&format!("new: {written};")), "{added}");
    }
    // A copy of what is everywhere is the same.
    let copy = SceneChange::Duplicate(SceneObject::Light(LightId(1)), "d2".to_owned(), DVec3::X);
    assert_eq!(
        edited(&text, &copy, Precision::Decimals(2)).text,
        text.replace(&format!(" d: {sun};"), &format!(" d: {sun}; d2: {sun};"))
    );
}

#[test]
fn declarations_are_added_where_they_belong() {
    let ball = scene_of(&format!("bodies; b: sphere, center <0.12345, 0, 0>, radius 1; lights; {CAMERA}"));
    let (form, light) = (ball.body(BodyId(0)).form.clone(), LightKind::SYNTAX[0].example);
    let light = scene_of(&format!("bodies; lights; l: {light}; {CAMERA}")).lights[0].kind.clone();
    let add = |text: &str| {
        let body = edited(text, &SceneChange::AddBody("new".to_owned(), form.clone()), Precision::Decimals(2));
        edited(&body.text, &SceneChange::AddLight("lamp".to_owned(), light.clone()), Precision::Decimals(2)).text
    };
    let (new, lamp) = ("new: sphere, center <0.12, 0, 0>, radius 1;", format!("lamp: {light};"));
    // Each declaration on a line, with comments, and with either line end.
    for end in ["\n", "\r\n", "\r"] {
        let text = ["bodies;", "  a: sphere, center <0,0,0>, radius 1; // one", "  // end", "lights;", "", CAMERA].join(end);
        let expected =
            ["bodies;", "  a: sphere, center <0,0,0>, radius 1; // one", &format!("  {new}"), "  // end", "lights;"].join(end);
        assert_eq!(add(&text), [expected, format!("  {lamp}"), String::new(), CAMERA.to_owned()].join(end));
    }
    // Several in a line.
    let text = format!("bodies; a: sphere, center <0,0,0>, radius 1; lights; {CAMERA}");
    assert_eq!(add(&text), format!("bodies; a: sphere, center <0,0,0>, radius 1; {new} lights; {lamp} {CAMERA}"));
    let text = format!("bodies;\na: sphere, center <0,0,0>, radius 1; b: sphere, center <9,0,0>, radius 1;\nlights; {CAMERA}");
    assert!(add(&text).contains(&format!("radius 1; {new}\nlights;")), "{}", add(&text));
    // A comment of several lines behind the last one.
    let text = format!("bodies;\n a: sphere, center <0,0,0>, radius 1; /* from here\n to here */\nlights;\n{CAMERA}");
    assert!(add(&text).contains(&format!("radius 1;\n {new} /* from here\n to here */\nlights;\n {lamp}\n")), "{}", add(&text));
}

#[test]
fn a_copy_has_everything_of_the_original_but_its_name_and_place() {
    let text = format!(
        "bodies;\n  ball1: sphere, center <1, /* x */ 2, 3>, radius .5, refractive_index 1.5, matte; // glass\nlights;\n  key: point, <1, 2, 3>;\n{CAMERA}"
    );
    let name = unused_name(&scene_of(&text), "ball1");
    assert_eq!(name, "ball");
    let copy = SceneChange::Duplicate(SceneObject::Body(BodyId(0)), name, DVec3::new(1.00001, 0.0, 0.0));
    let done = edited(&text, &copy, Precision::Decimals(2));
    let line = "\n  ball: sphere, center <2, /* x */ 2, 3>, radius .5, refractive_index 1.5, matte;";
    assert_eq!(done.text, text.replace("// glass", &format!("// glass{line}")));
    let copy = SceneChange::Duplicate(SceneObject::Light(LightId(0)), "key2".to_owned(), DVec3::X);
    let done = edited(&text, &copy, Precision::Decimals(2));
    assert_eq!(done.text, text.replace("<1, 2, 3>;\n", "<1, 2, 3>;\n  key2: point, <2, 2, 3>;\n"));
    assert_eq!(unused_name(&done.scene, "key2"), "key3");
    assert_eq!(unused_name(&done.scene, "lamp"), "lamp");
}

#[test]
fn what_is_removed_takes_its_line_and_its_comment() {
    let sphere = |name: &str| format!("{name}: sphere, center <0,0,0>, radius 1;");
    let [a, b, c] = ["a", "b", "c"].map(sphere);
    let remove = |text: &str, id| edited(text, &SceneChange::Remove(SceneObject::Body(BodyId(id))), Precision::Exact).text;
    for end in ["\n", "\r\n", "\r"] {
        let lines = ["bodies;", &format!(" {a}"), &format!("\t{b} // bee"), "// sea", &c, "lights;", CAMERA];
        let without = |line: usize| [&lines[..line], &lines[line + 1..]].concat().join(end);
        let text = lines.join(end);
        assert_eq!([0, 1, 2].map(|id| remove(&text, id)), [1, 2, 4].map(without));
    }
    let text = format!("bodies; {a} {b}  {c}\nlights; {CAMERA}");
    assert_eq!(remove(&text, 0), format!("bodies; {b}  {c}\nlights; {CAMERA}"));
    assert_eq!(remove(&text, 1), format!("bodies; {a} {c}\nlights; {CAMERA}"));
    assert_eq!(remove(&text, 2), format!("bodies; {a} {b}\nlights; {CAMERA}"));
    let text = format!("bodies;\n {a} /* not only\n of a */ {b}\nlights; k: point, <0,0,0>;{CAMERA}");
    assert_eq!(remove(&text, 0), format!("bodies;\n /* not only\n of a */ {b}\nlights; k: point, <0,0,0>;{CAMERA}"));
    let light = edited(&text, &SceneChange::Remove(SceneObject::Light(LightId(0))), Precision::Exact);
    assert!(light.text.ends_with(&format!("lights; {CAMERA}")), "{}", light.text);
}

#[test]
fn texts_with_errors_and_changes_that_would_make_some_are_refused() {
    let camera = scene_of(&format!("bodies; lights; {CAMERA}")).camera;
    let refused = |text: &str, change: &SceneChange| edit(&Source::new("scene", text), change, Precision::Exact).unwrap_err();
    for broken in ["", "bodies; lights;", "bodies; lights; camera; position <0,0,0>; gaze <0,0,-1>; up <0,1,0>;"] {
        let why = refused(broken, &SceneChange::Camera(camera.clone()));
        assert!(matches!(why, EditRefusal::Errors(_)) && why.to_string().starts_with("the scene text has an error: "), "{why}");
    }
    let text = format!("bodies; a: sphere, center <0,0,0>, radius 1; lights; {CAMERA}");
    assert_eq!(refused(&text, &SceneChange::Remove(SceneObject::Body(BodyId(1)))), EditRefusal::Missing);
    let why = refused(&text, &SceneChange::AddBody("a".to_owned(), form(&text, 0)));
    assert_eq!(why.to_string(), "the scene text would have an error: the name `a` is already taken");
}

#[test]
fn turns_and_factors_are_written_where_they_belong_with_few_digits() {
    let scene = |body: &str| format!("bodies;\n b: {body}; // end\nlights;\n{CAMERA}");
    let changed = |body: &str, change: &dyn Fn(BodyForm) -> Option<BodyForm>| {
        let text = scene(body);
        let change = SceneChange::Form(BodyId(0), change(form(&text, 0)).unwrap());
        edited(&text, &change, Precision::Decimals(2)).text
    };
    let turned = |body: &str, degrees: f64| changed(body, &|form| form.turned(DVec3::Y, degrees));
    let square = "box, <2,0,-1>, <4,2,1>, opaque";
    let once = "box, <-1,-1,-1>, <1,1,1>, rotate <0, 1, 0> 30.1, translate <3, 1, 0>, opaque";
    assert_eq!(turned(square, 30.1), scene(once));
    let commented = once.replace("30.1", "30.1 /* not yet */");
    assert_eq!(turned(&commented, 14.9), scene(&commented.replace("30.1", "45")));
    assert_eq!(turned(once, -30.1), scene(&once.replace(", rotate <0, 1, 0> 30.1", "")));
    let round = "cylinder, <3,0,0>, <3,2,0>, radius 1";
    let oval = changed(round, &|form| form.stretched(DVec3::new(1.0, 1.0, 1.37)));
    assert_eq!(oval, scene("cylinder, <0,-1,0>, <0,1,0>, radius 1, scale <1, 1, 1.37>, translate <3, 1, 0>"));
    // In front of what turns the body, and again in the same place.
    let in_front = changed(&commented.replace("box", "cylinder").replace(", rotate", ", radius 1, rotate"), &|form| {
        form.stretched(DVec3::new(2.0, 1.0, 1.0))
    });
    let wanted = commented.replace("box", "cylinder").replace(", rotate", ", radius 1, scale <2, 1, 1>, rotate");
    assert_eq!(in_front, scene(&wanted));
    let gem = "mesh, \"preset:gem\", /* as large as */ fit <0,1,0> 2, smooth";
    let stretched = changed(gem, &|form| form.stretched(DVec3::new(1.0, 3.0, 1.0)));
    let wanted = "mesh, \"preset:gem\", /* as large as */ fit <0,0,0> 2, scale <1, 3, 1>, translate <0, 1, 0>, smooth";
    assert_eq!(stretched, scene(wanted));
    // Axes and factors keep four digits in scenes of any size.
    let text = scene(square);
    let far = form(&text, 0).turned(DVec3::new(1.0, 2.0, 2.0) / 3.0, 12.3).unwrap();
    let done = edited(&text, &SceneChange::Form(BodyId(0), far), Precision::Decimals(-1));
    assert!(done.text.contains("rotate <0.3333, 0.6667, 0.6667> 12.3"), "{}", done.text);
}

/// White space and comments between words.
fn gap() -> impl Strategy<Value = &'static str> {
    prop_oneof![Just(" "), Just("\n"), Just("\r\n\t"), Just(" /* ; , < */ "), Just(" // x; y\n"), Just("\r")]
}

/// A text without its words: what must stay. What is between a sign and its number belongs to the number.
fn gaps(text: &str) -> Vec<String> {
    let tokens = crate::lang::lexer::tokenize(&Source::new("scene", text)).tokens;
    let mut end = 0;
    let mut found = Vec::new();
    for token in tokens {
        if !text[..end].ends_with('-') {
            found.push(text[end..token.span.range().start].to_owned());
        }
        end = token.span.range().end;
    }
    found
}

proptest! {
    /// A scene with every shape and every light, written with gaps of any kind: each is moved, and nothing else.
    #[test]
    fn a_moved_thing_reads_back_exactly_and_all_comments_stay(
        gaps_between in proptest::collection::vec(gap(), 400),
        by in (-1e3..1e3f64, -1e3..1e3f64, -1e3..1e3f64),
        turn in -3.0..3.0f64,
    ) {
        let ends = ["", ", rotate <1,2,3> 40, translate <0,0.5,0>", ", fit <1,2,3> 4.25, opaque", ", scale 2, fit <0,0,0> 1"];
        let body = |(row, end): (&Syntax<Shape>, &&str)| format!("b_{}: {}, matte{end};", row.keyword.word, row.example);
        let bodies: String = Shape::SYNTAX.iter().zip(ends.iter().cycle()).map(body).collect();
        let lights: String = LightKind::SYNTAX.iter().map(|row| format!("l_{}: {};", row.keyword.word, row.example)).collect();
        let plain = format!("bodies; {bodies} lights; {lights} {CAMERA}");
        let tokens = crate::lang::lexer::tokenize(&Source::new("scene", plain.as_str())).tokens;
        let mut text = String::new();
        for (token, gap) in tokens.iter().zip(gaps_between.iter().cycle()) {
            text.push_str(&plain[token.span.range()]);
            text.push_str(gap);
        }
        let scene = scene_of(&text);
        let by = DVec3::from(by);
        let mut changes = vec![SceneChange::Camera(scene.camera.orbited(by, turn, turn).unwrap())];
        changes.extend(scene.body_ids().map(|id| SceneChange::Form(id, scene.body(id).form.moved(by).unwrap())));
        changes.extend(scene.light_ids().filter_map(|id| Some(SceneChange::Light(id, scene.light(id).kind.moved(by)?))));
        for change in changes {
            let done = edited(&text, &change, Precision::Exact);
            let mut wanted = scene.clone();
            match change.clone() {
                SceneChange::Camera(camera) => wanted.camera = camera,
                SceneChange::Form(id, form) => wanted.bodies[id.index()].form = form,
                SceneChange::Light(id, kind) => wanted.lights[id.index()].kind = kind,
                SceneChange::AddBody(..) | SceneChange::AddLight(..) | SceneChange::Duplicate(..) | SceneChange::Remove(_) => {}
            }
            prop_assert_eq!(done.scene.to_string(), wanted.to_string());
            prop_assert_eq!(gaps(&done.text), gaps(&text));
            // Rounded, it is no further away than the rounding.
            let rounded = edited(&text, &change, Precision::Decimals(3));
            if let SceneChange::Form(id, form) = &change {
                let far = rounded.scene.body(*id).form.anchor().unwrap().distance(form.anchor().unwrap());
                prop_assert!(far < 1e-3, "{}", far);
            }
        }
    }
}

#[test]
fn a_second_environment_is_refused() {
    let text = format!("bodies;\nlights; sky: environment, \"preset:sky\", rotate 22.5; {CAMERA}");
    let scene = scene_of(&text);
    let sky = scene.lights[0].kind.clone();
    assert_eq!((sky.anchor(), sky.moved(DVec3::X)), (None, Some(sky.clone())));
    let refused = |change: &SceneChange| edit(&Source::new("scene", text.as_str()), change, Precision::Decimals(-3)).unwrap_err();
    let message = "the scene text would have an error: a scene has at most one environment";
    let copy = SceneChange::Duplicate(SceneObject::Light(LightId(0)), "other".to_owned(), DVec3::X);
    assert_eq!(refused(&copy).to_string(), message);
    assert_eq!(refused(&SceneChange::AddLight("other".to_owned(), sky.clone())).to_string(), message);
    // It can be removed, and added again; its angle keeps its digits.
    let without = edited(&text, &SceneChange::Remove(SceneObject::Light(LightId(0))), Precision::Exact);
    assert!(without.scene.lights.is_empty());
    let again = edited(&without.text, &SceneChange::AddLight("sky".to_owned(), sky), Precision::Decimals(-3));
    assert!(again.text.contains("sky: environment, \"preset:sky\", rotate 22.5;"), "{}", again.text);
}
