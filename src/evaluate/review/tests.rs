//! Every sentence, for pictures that are black or undefined for a known reason.

use super::*;
use crate::environment::RadianceMap;
use crate::lang::source::Source;
use crate::picture::{Frame, Transfer};
use crate::scene::Scene;
use crate::workspace::{NamedAssignment, Values};
use crate::world::{Assets, NamedMap};
use std::sync::Arc;

const SCENE: &str = "bodies;
ball: sphere, center <0,0,0>, radius 1, opaque, matte;
lights;
key: point, <0,3,5>;
camera;
position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 30;
";
const LAMBERT: &str = "body_specific; kd: scalar, constraint 0..1, default 0.5; formula; = kd*IL*Cd*max(0, N.L);";

/// What is said about the picture of a formula on a scene. The colours are those of the inspector.
fn said(formula: &str, scene: &str, settings: &[&str]) -> Option<String> {
    said_with(formula, scene, settings, ViewTransform::default())
}

fn said_with(formula: &str, scene: &str, settings: &[&str], transform: ViewTransform) -> Option<String> {
    let source = Source::new("formula", formula);
    let formula = Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source))).0;
    let scene = Scene::parse(&Source::new("scene", scene)).expect("a scene").0;
    let mut values = Values::defaults(&formula, &scene);
    for setting in settings {
        let given = setting.parse::<NamedAssignment>().expect("a setting").resolve(values.table()).expect("known names");
        assert_eq!(values.assign(&given), []);
    }
    let (black, _) = RadianceMap::of_rows(4, 2, |_, _| ()).expect("a size");
    let environment = Some(NamedMap { path: "black.exr".to_owned(), map: Arc::new(black) });
    let assets = Assets { environment, ..Assets::NONE };
    let (world, view) = (World::new(scene, &assets).expect("no meshes"), View::new(8, 6).expect("a size"));
    let inspector = Inspector::new(&formula, &world, values.numbers());
    let mut frame = Frame::black(8, 6);
    for (index, pixel) in frame.linear.iter_mut().enumerate() {
        let at = [index % 8, index / 8].map(|coordinate| coordinate as u32);
        *pixel = inspector.inspect(&view, at).expect("a pixel").total;
    }
    let picture =
        ReviewedPicture { formula: &formula, world: &world, view: &view, passes: 1, numbers: values.numbers(), transform };
    review(&picture, &PictureSummary::of(&frame)).map(|finding| finding.message())
}

fn black(formula: &str, scene: &str, settings: &[&str]) -> String {
    let said = said(formula, scene, settings).expect("a finding");
    said.strip_prefix("the picture is black: ").unwrap_or_else(|| panic!("{said}")).to_owned()
}

#[test]
fn a_usual_picture_is_not_remarkable() {
    assert_eq!(said(LAMBERT, SCENE, &[]), None);
}

#[test]
fn parameters_of_zero_are_named_if_another_value_shows_something() {
    assert_eq!(black(LAMBERT, SCENE, &["ball.Cd=<0,0,0>"]), "Cd is 0 everywhere");
    let any = "are 0 everywhere; another value of any of them shows something";
    assert_eq!(black(LAMBERT, SCENE, &["key.ki=0", "ka=0"]), format!("ki, ka {any}"));
    assert_eq!(black(LAMBERT, SCENE, &["key.IL=<0,0,0>", "ka=0"]), format!("IL, ka {any}"));
    assert_eq!(black(LAMBERT, SCENE, &["ball.kd=0", "ka=0"]), format!("kd, ka {any}"));
    // The product needs both, and there is no ambient light to be had from black bodies.
    let both = "body_specific; a: scalar; b: scalar; unused: scalar; formula; = a*b*IL*max(0, N.L);";
    assert_eq!(black(both, SCENE, &["ball.Cd=<0,0,0>", "ka=0"]), "a, b are all 0 everywhere");
}

#[test]
fn a_body_that_is_not_seen_does_not_matter() {
    let scene = SCENE.replace("lights;", "behind: sphere, center <0,0,20>, radius 1;\nlights;");
    assert_eq!(black(LAMBERT, &scene, &["ball.Cd=<0,0,0>", "behind.Cd=<1,1,1>"]), "Cd is 0 everywhere");
}

#[test]
fn what_the_camera_sees_is_said() {
    let away = SCENE.replace("gaze <0,0,-1>", "gaze <0,0,1>");
    assert_eq!(black(LAMBERT, &away, &[]), "the camera sees no body, only the background");
    let grey = said(LAMBERT, &away, &["background=<0.5,0.25,1>"]).expect("a finding");
    assert_eq!(grey, "every pixel has the same colour, <0.5, 0.25, 1>: the camera sees no body, only the background");
    let nothing = SCENE.replace("ball: sphere, center <0,0,0>, radius 1, opaque, matte;", "");
    assert_eq!(black(LAMBERT, &nothing, &[]), "the scene has no bodies, so only the background is seen");
    let white = nothing.replace("key: point, <0,3,5>", "sky: environment");
    let said = said(LAMBERT, &white, &[]).expect("a finding");
    let only = "the scene has no bodies, so only the environment and the background are seen";
    assert_eq!(said, format!("every pixel has the same colour, <1, 1, 1>: {only}"));
    let inside = SCENE.replace("radius 1", "radius 9");
    assert_eq!(black(LAMBERT, &inside, &["ka=0", "key.ki=0"]), "the camera is inside the body ball");
}

#[test]
fn lights_that_are_missing_or_do_not_reach_are_said() {
    let dark = SCENE.replace("key: point, <0,3,5>;", "");
    assert_eq!(black(LAMBERT, &dark, &["ka=0"]), "the scene has no lights");
    let behind = SCENE.replace("<0,3,5>", "<0,0,-9>");
    let unlit = "no light reaches what is seen: ";
    assert_eq!(black(LAMBERT, &behind, &["ka=0"]), format!("{unlit}lights are behind the surfaces"));
    let elsewhere = SCENE.replace("point, <0,3,5>", "spot, <0,3,5>, target <0,9,5>, angle 20");
    assert_eq!(black(LAMBERT, &elsewhere, &["ka=0"]), format!("{unlit}spots shine elsewhere"));
    // One lamp is behind the wall that is seen, and another wall is before the other lamp.
    let walls = "ball: rectangle, <-9,-9,0>, <-9,9,0>, <9,9,0>; cover: rectangle, <-99,-99,6>, <-99,99,6>, <99,99,6>;";
    let covered = SCENE.replace("ball: sphere, center <0,0,0>, radius 1, opaque, matte;", walls);
    let covered = covered.replace("<0,3,5>", "<0,0,9>; low: point, <0,0,-9>");
    let both = format!("{unlit}lights are behind the surfaces, bodies are in between");
    assert_eq!(black(LAMBERT, &covered, &["ka=0"]), both);
    let night = SCENE.replace("key: point, <0,3,5>", "key: environment, \"black.exr\"");
    assert_eq!(black(LAMBERT, &night, &["ka=0"]), format!("{unlit}the image of the environment is black"));
}

#[test]
fn a_formula_of_zero_or_less_is_said() {
    assert_eq!(black("formula; = Cd*min(0, N.V);", SCENE, &["ka=0"]), "the formula gives 0 wherever light falls on what is seen");
    assert_eq!(black("formula; = <-2, -2, -2>;", SCENE, &["ka=0"]), "the formula gives negative numbers, down to -2");
}

#[test]
fn a_picture_that_is_too_dark_says_which_exposure_shows_it() {
    let faint = "formula; = <0.0001, 0, 0>;";
    let expected = "its largest component is 0.0001, too dark to be seen; an exposure of 13 shows it";
    assert_eq!(black(faint, SCENE, &["ka=0"]), expected);
    let exposed = ViewTransform { exposure: 13.0, ..ViewTransform::from(Transfer::Linear) };
    assert_eq!(said_with(faint, SCENE, &["ka=0"], exposed), None);
}

#[test]
fn the_innermost_expression_that_is_nan_is_named() {
    let formula = "formula; COSINE = N.L; ROOT = sqrt(-max(0.5, COSINE)); SHINE = 2*ROOT + 1; = SHINE*IL*Cd;";
    let said = said(formula, SCENE, &["ball.Cd=<1,1,1>"]).expect("a finding");
    let begin = "pixels the formula gives no number (NaN), which is shown as 0: in (";
    assert!(said.starts_with("in ") && said.contains(begin), "{said}");
    let end = "it is `sqrt(-max(0.5, COSINE))` of ROOT, with numbers `sqrt(-0.";
    assert!(said.contains(end) && said.ends_with(" on ball for light key"), "{said}");
}

#[test]
fn the_branch_that_is_not_taken_is_not_blamed() {
    let formula = "formula; = if(1 > 2, sqrt(-1), 0/(N.N - N.N))*Cd;";
    let said = said(formula, &SCENE.replace("radius 1", "radius 4"), &[]).expect("a finding");
    assert!(said.contains("it is `0/(N.N - N.N)`, with numbers `0/0`, on ball for light key"), "{said}");
}

#[test]
fn nan_behind_the_surface_and_in_terms_of_the_surface_is_named() {
    // The light is behind all that is seen. A formula that reads `visible` is evaluated for it too.
    let behind = SCENE.replace("<0,3,5>", "<0,0,-9>");
    let found = said("formula; = <visible*0> + IL*sqrt(N.L);", &behind, &[]).expect("a finding");
    assert!(found.contains("it is `sqrt(N.L)`, with numbers `sqrt(-") && found.ends_with(" on ball for light key"), "{found}");
    let mirror = SCENE.replace(", opaque, matte", ", opaque");
    let glass = SCENE.replace(", opaque, matte", "");
    for (name, typed, function, scene) in [
        ("emission", "<sqrt(0 - N.V)>", "sqrt", SCENE),
        ("ambient", "<log(0 - N.V)>", "log", SCENE),
        ("reflected", "sqrt(0 - N.V)", "sqrt", &mirror),
        ("refracted", "sqrt(0 - N.V)", "sqrt", &glass),
    ] {
        let said = said(&format!("formula; {name} = {typed}; = Cd;"), scene, &[]).expect("a finding");
        assert!(said.contains(&format!("it is `{function}(0 - N.V)` of {name}, with numbers `{function}(-0.")), "{said}");
        assert!(said.ends_with(" on ball"), "{said}");
    }
}

#[test]
fn an_infinite_number_times_a_weight_of_0_is_said() {
    // The mirror shows the wall, whose light is infinite. The weight is 0 in green and blue.
    let scene = SCENE
        .replace("radius 1, opaque, matte", "radius 1, opaque")
        .replace("lights;", "wall: rectangle, <-99,-99,9>, <-99,99,9>, <99,99,9>, opaque, matte;\nlights;");
    let formula = "body_specific; glow: scalar, default 0; formula; reflected = <1, 0, 0>;
        emission = <glow/(N.N - N.N + 1 - glow)>; = 0*IL;";
    let said = said(formula, &scene, &["wall.glow=1"]).expect("a finding");
    assert!(said.ends_with("an infinite number is multiplied by a weight of 0 on ball"), "{said}");
}

#[test]
fn infinite_numbers_of_both_signs_are_said() {
    let scene = SCENE.replace("camera;", "fill: point, <0,1,5>;\ncamera;").replace("radius 1", "radius 4");
    let formula = "light_specific; s: scalar, constraint -1..1; formula; = <s, s, s>/(N.N - N.N);";
    let said = said(formula, &scene, &["key.s=1", "fill.s=-1"]).expect("a finding");
    let all = "in every pixel the formula gives no number (NaN), which is shown as 0: in (0, 0) ";
    assert_eq!(said, format!("{all}infinite numbers of both signs are added up"));
}

#[test]
fn the_pass_in_which_a_pixel_is_nan_is_named() {
    // The number is that of points near the axis, so that of the middle of the only pixel.
    let text = "formula; = IL*sqrt(0.01 - getx(point)^2 - gety(point)^2);";
    let (formula, _) = Formula::parse(&Source::new("formula", text)).expect("a formula");
    let scene = SCENE.replace("radius 1", "radius 4");
    let scene = Scene::parse(&Source::new("scene", scene)).expect("a scene").0;
    let values = Values::defaults(&formula, &scene);
    let (world, view) = (World::new(scene, &Assets::NONE).expect("no files"), View::new(1, 1).expect("a size"));
    let is_near = |pass: u32| {
        let view = view.with_pass(pass);
        let tracer = crate::trace::Tracer::new(&world, &view);
        let point = tracer.hit(&tracer.primary(0)).expect("a hit").point;
        point.truncate().length() < 0.1
    };
    let first = (0..64).find(|pass| !is_near(*pass)).expect("a point far from the axis");
    assert!(first > 0);
    let said = |passes: u32, nan: bool| {
        let linear = vec![[if nan { f32::NAN } else { 0.5 }; 3]];
        let summary = PictureSummary::of(&Frame { width: 1, height: 1, linear });
        let (numbers, transform) = (values.numbers(), ViewTransform::default());
        review(&ReviewedPicture { formula: &formula, world: &world, view: &view, passes, numbers, transform }, &summary)
    };
    assert_eq!(said(64, false), None);
    let finding = said(64, true).expect("a finding");
    assert_eq!(finding.pixel(), Some(([0, 0], Some(first))));
    let message = finding.message();
    assert!(message.contains(&format!("is shown as 0: in pass {first} it is `sqrt(0.01 - ")), "{message}");
    // A picture with a NaN that the inspector does not find is not explained in a wrong way.
    let message = said(1, true).expect("a finding").message();
    assert!(message.ends_with("(NaN), which is shown as 0: the interpreter gives a number there"), "{message}");
}

#[test]
fn only_remarkable_pictures_are_summarised() {
    let view = ViewTransform::default();
    let bright = Frame { width: 2, height: 1, linear: vec![[0.0; 3], [0.0, 0.5, 0.0]] };
    assert_eq!(PictureSummary::if_remarkable(&bright, &view), None);
    assert!(PictureSummary::if_remarkable(&Frame::black(2, 1), &view).is_some());
    let mut undefined = bright;
    undefined.linear[1][2] = f32::NAN;
    let summary = PictureSummary::of(&undefined);
    assert_eq!((summary.nan, summary.first_nan, summary.range), (1, Some(1), [0.0, 0.5]));
}

#[test]
fn large_pictures_are_summarised_like_small_ones() {
    // More pixels than a thread takes at once, and not a multiple of the numbers that are compared side by side.
    let pixels = 40_001;
    let mut frame = Frame { width: pixels as u32, height: 1, linear: vec![[0.5; 3]; pixels] };
    assert_eq!(PictureSummary::of(&frame).only_colour, Some([0.5; 3]));
    for at in [0, 7, 16_383, 16_384, 39_999, 40_000] {
        let mut changed = frame.clone();
        changed.linear[at] = [-3.0, 0.5, 7.0];
        let summary = PictureSummary::of(&changed);
        assert_eq!((summary.range, summary.nan, summary.only_colour), ([-3.0, 7.0], 0, None), "pixel {at}");
    }
    for at in [40_000, 20_000, 123] {
        frame.linear[at][1] = f32::NAN;
    }
    frame.linear[40_000][2] = 9.0;
    let summary = PictureSummary::of(&frame);
    assert_eq!((summary.pixels, summary.nan, summary.first_nan, summary.range), (pixels, 3, Some(123), [0.5, 9.0]));
}
