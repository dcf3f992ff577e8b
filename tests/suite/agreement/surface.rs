//! Formulas that give terms of every hit: weights of rays, ambient light, emission. Some expected numbers are worked
//! out by hand; the others are those of the interpreter.

use crate::agreement::compiled;
use crate::agreement::drags::{VIEWS, drag};
use crate::agreement::formulas::{Case, check, expression, runner};
use illuminator::backends::interpreter::Interpreted;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::Evaluator;
use illuminator::lang::types::Type;
use illuminator::plan::Method;
use illuminator::trace::View;
use illuminator::workspace::{NamedAssignment, Values};
use proptest::prelude::*;

/// Schlick's approximation for glass, as a weight.
const GLASS: &str = "F0 = ((1-eta)/(1+eta))^2; F = if(total, 1, F0 + (1-F0)*(1-max(0,N.V))^5);
    reflected = kr*F; refracted = kt*(1-F);";

/// The one pixel of a picture by every backend. The camera looks at the middle of a plate of glass, which is turned
/// about the y axis by some degrees, from 4 before it. There is nothing else in the scene.
fn pixel(formula: &str, degrees: f64, depth: u32, settings: &[&str]) -> Vec<[f32; 3]> {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let corner = |x: f64, y: f64| format!("<{}, {y}, {}>", x * cosine, -x * sine);
    let corners = [corner(-9.0, -9.0), corner(-9.0, 9.0), corner(9.0, 9.0)].join(", ");
    let bodies = format!("plate: rectangle, {corners}, refractive_index 1.5;");
    let before = ["plate.kr=1", "plate.kt=1", "ka=0"];
    pixel_of(&bodies, formula, depth, &[&before, settings].concat())
}

/// The same of these bodies. The camera looks at the origin, from 4 before it.
fn pixel_of(bodies: &str, formula: &str, depth: u32, settings: &[&str]) -> Vec<[f32; 3]> {
    let scene = format!("bodies; {bodies} lights; camera; position <0,0,4>; gaze <0,0,-1>; up <0,1,0>; fov 1;");
    let view = View::new(1, 1).and_then(|view| view.with_depth(depth)).expect("within range");
    let subject = Subject::parse(formula, &scene, view).expect("sound texts");
    let mut values = Values::defaults(&subject.formula, subject.world.scene());
    let settings = ["background=<1, 0.5, 0.25>"].iter().chain(settings);
    let settings = settings.map(|text| text.parse::<NamedAssignment>().expect("a setting"));
    let given: Vec<_> = settings.flat_map(|setting| setting.resolve(values.table()).expect("known names")).collect();
    assert_eq!(values.assign(&given), []);
    let interpreted = Interpreted::new(&subject.formula, &subject.world, view).expect("small enough");
    let frame = |backend| {
        let evaluator = Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("a picture");
        evaluator.frame(values.numbers()).linear[0]
    };
    compiled().into_iter().map(frame).chain([interpreted.frame(values.numbers()).linear[0]]).collect()
}

fn near(found: Vec<[f32; 3]>, expected: [f64; 3]) {
    for found in found {
        let close = found.iter().zip(expected).all(|(found, expected)| (f64::from(*found) - expected).abs() < 2e-6);
        assert!(close, "{found:?} is not {expected:?}");
    }
}

#[test]
pub(super) fn glass_obeys_fresnel() {
    let glass = format!("formula; {GLASS} = Cd;");
    let background = |share: f64| [share, 0.5 * share, 0.25 * share];
    // Seen straight on, F is 0.04; at 60° it is 0.04 + 0.96/32 = 0.07. What is not reflected passes.
    near(pixel(&glass, 0.0, 2, &["plate.kt=0"]), background(0.04));
    near(pixel(&glass, 60.0, 2, &["plate.kt=0"]), background(0.07));
    near(pixel(&glass, 60.0, 2, &["plate.kr=0"]), background(0.93));
    near(pixel(&glass, 60.0, 2, &["plate.kr=0.5", "plate.kt=0.25"]), background(0.5 * 0.07 + 0.25 * 0.93));
    // From behind, the ray leaves glass: beyond 41.8° all of it is reflected.
    near(pixel(&glass, 180.0, 2, &["plate.kt=0"]), background(0.04));
    near(pixel(&glass, 120.0, 2, &[]), background(1.0));
    near(pixel("formula; reflected = total; refracted = 0; = Cd;", 120.0, 2, &[]), background(1.0));
    near(pixel("formula; reflected = eta/2; refracted = 0; = Cd;", 180.0, 2, &[]), background(0.75));
}

#[test]
pub(super) fn places_on_surfaces_are_those_of_the_manual() {
    // The camera looks along −z at the origin.
    let at =
        |body: &str, expected: [f64; 3]| near(pixel_of(body, "formula; emission = <u, v, 0>; = Cd;", 1, &["ka=0"]), expected);
    at("r: rectangle, <-1,-3,0>, <-1,1,0>, <3,1,0>;", [0.75, 0.25, 0.0]);
    at("t: triangle, <-1,-1,0>, <-1,1,0>, <3,1,0>;", [0.5, 0.25, 0.0]);
    // From 2 above the middle of a sphere of radius 4, the ray meets it 30° north of the equator, at longitude 0.
    at("s: sphere, center <0,-2,-3>, radius 4;", [0.0, 2.0 / 3.0, 0.0]);
    at("d: disc, center <-3,0,0>, normal <0,0,1>, radius 4;", [0.0, 0.75, 0.0]);
    let normals = |body: &str| pixel_of(body, "formula; emission = (Ng + <1>)/2; = Cd;", 1, &["ka=0"]);
    near(normals("s: sphere, center <0,-2,-3>, radius 4;"), [0.5, 0.75, 0.5 + 0.75f64.sqrt() / 2.0]);
    // Ng turns to the ray.
    near(normals("r: rectangle, <-1,-3,0>, <3,-3,0>, <3,1,0>;"), [0.5, 0.5, 1.0]);
}

#[test]
pub(super) fn mirrors_are_coloured_and_zero_cuts_exactly() {
    near(pixel("formula; reflected = <0.5, 1, 0>; refracted = 0; = Cd;", 0.0, 2, &[]), [0.5, 0.5, 0.0]);
    near(pixel("formula; reflected = Cd*kr; = Cd;", 0.0, 2, &["plate.Cd=<0.2, 0.4, 0.8>", "plate.kt=0"]), [0.2, 0.2, 0.2]);
    // kr and kt are the weights that the formula does not give.
    near(pixel("formula; refracted = <0, 0, 1>; = Cd;", 0.0, 2, &["plate.kr=0.5"]), [0.5, 0.25, 0.375]);
    // Without children at the greatest depth, nothing is added.
    near(pixel("formula; reflected = <1>; = Cd;", 0.0, 1, &[]), [0.0; 3]);
    for found in pixel("formula; reflected = <1/0>*0 + <1>; refracted = (0 > 1); = Cd;", 0.0, 2, &[]) {
        assert!(found.iter().all(|component| component.is_nan()), "{found:?}");
    }
}

#[test]
pub(super) fn ambient_light_and_emission_need_no_light() {
    let formula = "formula; ambient = Cd*<0.5, 0.25, 1>; emission = <0.1, 0, (N.V > 0.9)>; = Cd;";
    near(pixel(formula, 0.0, 1, &["plate.Cd=<0.2, 0.4, 0.8>", "ka=1"]), [0.2, 0.1, 1.8]);
    near(
        pixel("formula; emission = <0.1, 0.2, 0.3>; = Cd;", 0.0, 1, &["plate.Cd=<0.5, 0.5, 0.5>", "ka=0.5"]),
        [0.35, 0.45, 0.55],
    );
}

/// Formulas whose terms of hits depend on variables, on parameters of bodies and on global ones.
const TERMS: [&str; 10] = [
    "reflected = kr*F; refracted = kt*(1-F);",
    "reflected = kr*Cd; refracted = kt*<1, 0.5, 0>;",
    "reflected = F;",
    "refracted = q*(1-F) + 0.1;",
    "reflected = (N.V > 0.5)*kr; refracted = kt; emission = v*q*(1 - N.V);",
    "ambient = ka*Cd*Ia*(1 + gety(point)); emission = <0, q, 0.1*g>;",
    "reflected = F*kr*v; refracted = (1-kr)*(1-F); ambient = <0.1>;",
    "reflected = kr^2*F; refracted = kt/2;",
    "emission = Cd*(gety(N) > 0.9); ambient = <0>;",
    "reflected = kr*(fract(4*u) > 0.5); refracted = kt*u; emission = q*<u, 0, u*u>; ambient = ka*Ia*Cd*abs(Ng);",
];

/// Formulas whose weights of rays are infinite, NaN or very large at some hits: the normal of the floor is <0, 1, 0>.
const UNBOUNDED: [&str; 9] = [
    "reflected = <1e20, -1e20, 1>; refracted = 1e20; emission = N;",
    "reflected = <0/getx(N), 1, 1>;",
    "reflected = <1/getx(N), kr, 0>; ambient = <0>;",
    "refracted = kt/(getx(N) + getz(N)); reflected = kr*F; ambient = <0, q, 0>;",
    "reflected = kr*<1, 0, 1>/N; refracted = <0, 1, 1>/N;",
    "reflected = F/getx(N); refracted = if(N.V > 0.5, 0, 1/getz(N)); emission = <0, 0.1, 0>;",
    "reflected = -1/max(0, 0.8 - N.V); ambient = <0, 0, 0.1>;",
    "reflected = clamp(N, 0, 1); refracted = clamp(B, 0, 1); ambient = Cd/getx(B);",
    "reflected = sqrt(N.V - 0.5); refracted = kr*log(N.V - 0.3); ambient = <0>;",
];

fn case(terms: &str) -> Case {
    let text = format!(
        "global; g: scalar, constraint -1..50; body_specific; p: scalar; q: scalar, constraint 0..1; v: vector, constraint 0..1; \
         formula; F0 = ((1-eta)/(1+eta))^2; F = if(total, 1, F0 + (1-F0)*(1-max(0,N.V))^5); {terms} = IL*Cd*max(0, N.L)*p;"
    );
    let numbers = [0.31, 0.77, 0.55, 0.93, 0.12, 0.68, 0.41, 0.86, 0.23, 0.6, 0.97];
    Case::of(text, &numbers, &compiled()).unwrap_or_else(|error| panic!("{terms}: {error}"))
}

#[test]
pub(super) fn unbounded_weights_follow_the_recursion() {
    let mirror = |weight: &str, background: &str| {
        let formula = format!("formula; reflected = {weight}; refracted = 0; = Cd;");
        pixel(&formula, 0.0, 2, &[background])
    };
    for found in mirror("<0/0, 1/0, -1/0>", "background=<0, 0.5, 0.5>") {
        assert!(found[0].is_nan() && found[1] == f32::INFINITY && found[2] == f32::NEG_INFINITY, "{found:?}");
    }
    // Infinity times black is NaN. Where the weight is 0 in all components, the ray is cut off.
    for found in mirror("<1/0, 1, 1>", "background=<0, 0.5, 0.5>") {
        assert!(found[0].is_nan() && found[1..] == [0.5, 0.5], "{found:?}");
    }
    near(mirror("if(N.V > 0, 0, 1/0)", "background=<0, 0.5, 0.5>"), [0.0; 3]);
    // Behind the camera is a second mirror, black itself, in which the first one is seen: 1 + ∞·(0 + 1/4).
    let bodies = "near: rectangle, <-9,-9,0>, <-9,9,0>, <9,9,0>; far: rectangle, <-9,-9,8>, <-9,9,8>, <9,9,8>;";
    let formula = "body_specific; q: scalar; e: scalar; formula; reflected = <1/q>; refracted = 0; emission = <e>; = Cd;";
    for found in pixel_of(bodies, formula, 3, &["near.q=0", "near.e=1", "far.q=4", "far.e=0", "ka=0"]) {
        assert_eq!(found, [f32::INFINITY; 3]);
    }
}

#[test]
pub(super) fn backends_agree() {
    for terms in TERMS.iter().chain(&UNBOUNDED) {
        check(&case(terms)).unwrap_or_else(|error| panic!("{terms}: {error}"));
    }
}

/// An expression that reads nothing of a light: its names of lights are those of hits.
fn of_hit(text: &str) -> String {
    let name = |word: &str| match word {
        "L" | "H" => "N".to_owned(),
        "R" => "V".to_owned(),
        "alpha" | "beta" => "gamma".to_owned(),
        "dist" | "visible" | "l" => "q".to_owned(),
        "IL" => "Cd".to_owned(),
        "ki" => "kr".to_owned(),
        _ => word.to_owned(),
    };
    // Names and what is between them.
    let is_name = |character: char| character.is_ascii_alphanumeric();
    let mut pieces: Vec<String> = Vec::new();
    let mut inside = None;
    for character in text.chars() {
        match pieces.last_mut() {
            Some(piece) if inside == Some(is_name(character)) => piece.push(character),
            _ => pieces.push(character.to_string()),
        }
        inside = Some(is_name(character));
    }
    pieces.iter().map(|piece| name(piece)).collect()
}

#[test]
pub(super) fn random_terms_of_hits_agree() {
    let term = |ty: Type| expression(ty, 3, false).prop_map(|text| of_hit(&text));
    let strategy = (
        term(Type::Vector),
        term(Type::Scalar),
        [term(Type::Vector), term(Type::Vector)],
        expression(Type::Vector, 2, false),
        proptest::collection::vec(prop_oneof![5 => 0.0..1.0_f32, 1 => -3.0..9.0_f32, 1 => Just(0.0), 1 => Just(1.0)], 61),
    );
    let outcome = runner(150).run(&strategy, |(reflected, refracted, [ambient, emission], result, numbers)| {
        let text = format!(
            "global; g: scalar, constraint -1..50; \
             body_specific; p: scalar; q: scalar, constraint 0..1; v: vector; wood: texture; model: scalar, choices \"A\", \"B\", \"C\"; \
             light_specific; l: scalar; \
             formula; SCALED(x, n) = sum(i, 0, n, x*product(k, 1, i, q)/(i + 1)); \
             reflected = if(model == 0, SCALED({reflected}, 2), <total>); refracted = (1 - total)*{refracted}; \
             ambient = {ambient}; emission = if(model == 1, {emission}, <0>); = {result};"
        );
        check(&Case::of(text, &numbers, &compiled())?)
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
}

#[test]
pub(super) fn drags_give_the_general_picture() {
    for terms in TERMS.iter().chain(&UNBOUNDED) {
        let case = case(terms);
        for index in 0..case.layout.len() {
            for evaluator in &case.evaluators {
                drag(&case, evaluator, &[index], &[0.2, 0.9, 0.0, 1.0], VIEWS[1])
                    .unwrap_or_else(|error| panic!("{terms}: {error}"));
            }
        }
    }
}

#[test]
fn kr_and_kt_stay_separable_where_the_weights_are_linear_in_them() {
    let method = |terms: &str, name: &str| {
        let case = case(terms);
        let id = case.formula.parameter_named(name).expect("a parameter");
        // The second body is of glass.
        let index = case.layout.index(case.formula.parameter(id), 1);
        drag(&case, &case.evaluators[0], &[index], &[0.2, 0.9], VIEWS[0]).expect("the general picture")
    };
    for (terms, kr, kt) in [
        (TERMS[0], Method::Images, Method::Images),
        (TERMS[1], Method::Images, Method::Images),
        (TERMS[2], Method::Images, Method::Images),
        (TERMS[6], Method::General, Method::Images),
        (TERMS[7], Method::General, Method::Images),
    ] {
        assert_eq!((method(terms, "kr"), method(terms, "kt")), (kr, kt), "{terms}");
    }
    assert_eq!((method(TERMS[0], "p"), method(TERMS[3], "q")), (Method::Images, Method::General));
}

#[test]
fn what_is_linear_in_ambient_light_and_emission_is_dragged_by_images() {
    for (terms, name, expected) in [
        (TERMS[4], "q", Method::Images),
        (TERMS[4], "v", Method::Images),
        (TERMS[5], "q", Method::Images),
        (TERMS[5], "Cd", Method::Images),
        (TERMS[5], "ka", Method::Images),
        (TERMS[5], "g", Method::Images),
        (TERMS[6], "v", Method::General),
        (TERMS[9], "q", Method::Images),
        ("emission = <10 - q*10, q, 2>*N;", "q", Method::Images),
        ("emission = q*q*N;", "q", Method::General),
        // Images of large numbers are added, but not where they may cancel.
        ("emission = <1000, 2000*q, 0>;", "q", Method::Images),
        ("emission = <1000 - 999*q, 0, 0>;", "q", Method::Images),
        // Infinite at a body: its tiles are drawn in full.
        ("emission = <q>/getx(N);", "q", Method::Images),
    ] {
        let case = case(terms);
        let parameter = case.formula.parameter(case.formula.parameter_named(name).expect("a parameter"));
        for owner in 0..case.layout.owners(parameter.owner) {
            let first = case.layout.index(parameter, owner);
            let moved: Vec<usize> = (first..first + parameter.ty.slots()).collect();
            for view in VIEWS {
                let found = drag(&case, &case.evaluators[0], &moved, &[0.2, 0.9, 0.0, 1.0], view).expect("the general picture");
                let may_be_whole = terms.contains('/');
                assert!(found == expected || may_be_whole, "{terms} {name} of {owner}: {found:?}");
            }
        }
    }
}
