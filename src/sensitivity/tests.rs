//! Derivatives of pictures against differences of pictures in double steps, for every kind of parameter.

use super::*;
use crate::backends;
use crate::engine::Task;
use crate::lang::source::Source;
use crate::lang::types::Type;
use crate::scene::Scene;
use crate::trace::View;
use crate::workspace::Values;
use crate::world::Assets;

/// Glass and a mirror over a floor, with a lamp and light from all around.
const SCENE: &str = "bodies;
floor: rectangle, <-4,0,-4>, <4,0,-4>, <4,0,4>;
glass: sphere, center <-0.6,1,0>, radius 1;
mirror: rectangle, <0.2,2.5,-2>, <3,2.5,-1.5>, <3,0,-1.5>, opaque;
lights; key: point, <4,6,5>; ";
const CAMERA: &str = "camera; position <0,1.6,6>; gaze <0,-0.1,-1>; up <0,1,0>; fov 45;";
const FORMULA: &str = "global; g: scalar, constraint 0..2, default 0.7;
body_specific; kd: scalar, constraint 0..1, default 0.5; h: scalar, constraint 1..100, default 9; t: scalar, constraint 0..1, default 0.4;
light_specific; l: scalar, constraint 0..1, default 0.8;
formula; = g*kd*IL*Cd*max(0, N.L) + l*IL*pow(max(0, R.V), h);";
const SURFACE: &str = " ambient = t*Cd*<0.2, 0.1, 0.3>; emission = t*t*Cd; reflected = kr*t; ";

fn subject(formula: &str, scene: &str) -> Subject {
    let (formula, _) = Formula::parse(&Source::new("formula", formula)).unwrap();
    let (scene, _) = Scene::parse(&Source::new("scene", scene)).unwrap();
    Subject::new(formula, scene, &Assets::NONE, View::new(24, 20).unwrap().with_depth(4).unwrap()).unwrap()
}

/// Moves every number of every parameter, and compares with the slope of pictures.
fn check(formula: &str, scene: &str, backend: &str) {
    let subject = subject(formula, scene);
    let engine = Engine::new(backends::named(backend).unwrap().make());
    let mut values = Values::defaults(&subject.formula, subject.world.scene());
    let set: Vec<_> = ["*.kr=0.3", "*.kt=0.4", "ka=0.2", "background=<0.1,0.2,0.3>", "key.ki=0.6", "key.IL=<0.9,0.8,0.7>"]
        .iter()
        .flat_map(|text| text.parse::<crate::workspace::NamedAssignment>().unwrap().resolve(values.table()).unwrap())
        .collect();
    values.assign(&set);
    let numbers = values.numbers();
    let hits: Vec<Arc<Hits>> = (0..2)
        .map(|pass| Subject { view: subject.view.with_pass(pass), ..subject.clone() })
        .map(|subject| engine.trace(&subject, &Task::UNWATCHED).unwrap())
        .collect();
    let moving: Vec<ParameterId> =
        subject.formula.parameter_ids().filter(|id| subject.formula.parameter(*id).ty != Type::Texture).collect();
    let sensitivity = Sensitivity::new(&engine, &subject, &hits, &moving, numbers).unwrap();
    let mut lively = 0;
    for index in 0..numbers.len() {
        let (id, owner) = sensitivity.parameter_at(index).unwrap();
        let found = sensitivity.change(numbers, &[(index, 1.0)]);
        let h = 2e-3_f32;
        let at = |by: f32| {
            let mut moved = numbers.to_vec();
            moved[index] += by;
            sensitivity.picture(&moved)
        };
        // Ranges end at 1, so only to the left of some.
        let (far, near, here) = (at(-2.0 * h), at(-h), at(0.0));
        let name = &subject.formula.parameter(id).name;
        for pixel in 0..found.linear.len() {
            for component in 0..3 {
                let of = |frame: &Frame| f64::from(frame.linear[pixel][component]);
                let wanted = (3.0 * of(&here) - 4.0 * of(&near) + of(&far)) / (2.0 * f64::from(h));
                let found = of(&found);
                let tolerance = 2e-2 * wanted.abs().max(0.05);
                assert!(
                    (found - wanted).abs() <= tolerance,
                    "{backend}: {name} of {owner}, pixel {pixel}: {found}, {wanted}; {:?} {:?}",
                    here.linear[pixel],
                    near.linear[pixel]
                );
            }
        }
        lively += usize::from(found.linear.iter().flatten().any(|component| component.abs() > 1e-3));
    }
    assert!(lively * 2 > numbers.len(), "{lively} of {} numbers change the picture", numbers.len());
}

#[test]
fn every_number_of_a_lamp_changes_the_picture_as_its_derivative_says() {
    for backend in ["jit", "interpreter"] {
        check(FORMULA, &format!("{SCENE}{CAMERA}"), backend);
    }
}

#[test]
fn light_from_all_around_is_derived_too() {
    check(FORMULA, &format!("{SCENE} sky: environment; {CAMERA}"), "jit");
}

#[test]
fn terms_that_a_formula_gives_are_derived_too() {
    let formula = FORMULA.replace("formula;", &format!("formula;{SURFACE}"));
    check(&formula, &format!("{SCENE}{CAMERA}"), "jit");
    let seen = formula.replace("N.L)", "N.L)*visible + 0.1*kd*Cd");
    check(&seen, &format!("{SCENE}{CAMERA}"), "jit");
}

#[test]
fn directions_add_up() {
    let subject = subject(FORMULA, &format!("{SCENE}{CAMERA}"));
    let engine = Engine::default();
    let values = Values::defaults(&subject.formula, subject.world.scene());
    let hits = [engine.trace(&subject, &Task::UNWATCHED).unwrap()];
    let ids = ["kd", "kr", "g"].map(|name| subject.formula.parameter_named(name).unwrap());
    let sensitivity = Sensitivity::new(&engine, &subject, &hits, &ids, values.numbers()).unwrap();
    let index = |id| sensitivity.layout.index(subject.formula.parameter(id), 0);
    let [kd, kr, g] = ids.map(index);
    let both = sensitivity.change(values.numbers(), &[(kd, 1.0), (kr, 2.0), (g, -0.5)]);
    let one = [(kd, 1.0), (kr, 2.0), (g, -0.5)].map(|speed| sensitivity.change(values.numbers(), &[speed]));
    for (pixel, both) in both.linear.iter().enumerate() {
        for component in 0..3 {
            let sum: f32 = one.iter().map(|frame| frame.linear[pixel][component]).sum();
            assert!((sum - both[component]).abs() < 1e-3, "{sum} {both:?}");
        }
    }
    assert_eq!([kd, kr, g].map(|index| sensitivity.is_measured(index)), [false, true, false]);
}
