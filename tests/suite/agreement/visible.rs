//! Formulas that read `visible`: light that comes through a leaf, light that wraps round a ball, shadows that are not
//! black. The expected numbers are worked out by hand.

use crate::agreement::backends;
use crate::agreement::sessions::{Model, tested};
use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::verify;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Backend, Evaluator};
use illuminator::lang::source::Source;
use illuminator::plan::Method;
use illuminator::trace::View;
use illuminator::workspace::{FileKind, NamedAssignment, Values, presets};
use std::sync::Arc;

/// Light falls on both sides of a thin body; from behind it is weaker. Without light, a little remains.
const LEAF: &str = "
    body_specific; front: scalar, constraint 0..1, default 0.5; back: scalar, constraint 0..1, default 0.25;
    veins: scalar, constraint 1..40, default 3;
    formula;
    SIDE = front*max(0, N.L) + back*max(0, -(N.L))^veins;
    = IL*Cd*(visible*SIDE + 0.01*(1 - visible));";

/// A leaf, a ball and a stone behind the leaf.
const BODIES: &str = "
    leaf: rectangle, <-1,-1,0>, <-1,1,0>, <1,1,0>, opaque, matte; ball: sphere, center <4,0,0>, radius 1, opaque, matte;
    stone: sphere, center <0,3,-4>, radius 0.5, opaque, matte;";

/// The one pixel of a picture of a point from 4 before it, under lights, by every backend.
fn pixel(formula: &str, lights: &str, target: [f64; 3], shadows: bool, settings: &[&str]) -> Vec<[f32; 3]> {
    let [x, y, z] = target;
    let scene =
        format!("bodies; {BODIES} lights; {lights} camera; position <{x},{y},{}>; gaze <0,0,-1>; up <0,1,0>; fov 1;", z + 4.0);
    let view = View::new(1, 1).expect("a size").with_shadows(shadows);
    let subject = Subject::parse(formula, &scene, view).expect("sound texts");
    let mut values = Values::defaults(&subject.formula, subject.world.scene());
    let settings = ["*.Cd=<0.8, 0.4, 0.2>", "ka=0"].iter().chain(settings);
    let settings = settings.map(|text| text.parse::<NamedAssignment>().expect("a setting"));
    let given: Vec<_> = settings.flat_map(|setting| setting.resolve(values.table()).expect("known names")).collect();
    assert_eq!(values.assign(&given), []);
    let interpreted = Interpreted::new(&subject.formula, &subject.world, view).expect("small enough");
    let engine = |backend| Engine::new(backend).evaluator(&subject, &[], &Task::UNWATCHED).expect("a picture");
    let compiled = backends().into_iter().map(|backend| engine(backend).frame(values.numbers()).linear[0]);
    compiled.chain([interpreted.frame(values.numbers()).linear[0]]).collect()
}

/// Every backend gives `light`·Cd.
fn check(formula: &str, lights: &str, target: [f64; 3], light: f32, settings: &[&str]) {
    for found in pixel(formula, lights, target, true, settings) {
        let near = found.iter().zip([0.8, 0.4, 0.2]).all(|(found, colour)| (found - light * colour).abs() < 2e-6);
        assert!(near, "{found:?} is not {light} of the colour, {lights} {target:?}");
    }
}

const ON_LEAF: [f64; 3] = [0.0, 0.0, 0.0];
const ON_BALL: [f64; 3] = [4.0, 0.0, 1.0];

#[test]
pub(super) fn light_comes_through_a_leaf_unless_something_is_behind_it() {
    // N·L is 0.8, then −0.8; then a stone is on the way.
    check(LEAF, "sun: point, <0,3,4>;", ON_LEAF, 0.4, &[]);
    check(LEAF, "sun: point, <3,0,-4>;", ON_LEAF, 0.25 * 0.512, &[]);
    check(LEAF, "sun: point, <0,6,-8>;", ON_LEAF, 0.01, &[]);
    // Each of several lights adds its own; ki = 0 switches one off.
    let three = "sun: point, <0,3,4>; lamp: point, <3,0,-4>; moon: point, <0,6,-8>;";
    check(LEAF, three, ON_LEAF, 0.4 + 0.128 + 0.01, &[]);
    check(LEAF, three, ON_LEAF, 0.064 + 0.01, &["sun.ki=0", "lamp.ki=0.5"]);
}

#[test]
pub(super) fn a_closed_body_hides_a_light_behind_it_by_its_far_side() {
    check(LEAF, "sun: point, <4,3,-4>;", ON_BALL, 0.01, &[]);
    // A lamp in the ball, with N·L = −0.8.
    check(LEAF, "lamp: point, <4,0.6,0.2>;", ON_BALL, 0.128, &[]);
    // Light that wraps round: (N·L + 0.5)/1.5 at N·L = 0, along the tangent, and at −0.28 from within the leaf's side.
    let wrapped = "formula; = IL*Cd*visible*max(0, (N.L + 0.5)/1.5);";
    check(wrapped, "sun: point, <4,3,1>;", ON_BALL, 1.0 / 3.0, &[]);
    check(wrapped, "sun: point, <0.96,0,-0.28>;", ON_LEAF, 0.22 / 1.5, &[]);
}

#[test]
pub(super) fn without_shadow_rays_every_light_is_visible() {
    for (lights, target) in [("sun: point, <0,6,-8>;", ON_LEAF), ("sun: point, <4,3,-4>;", ON_BALL)] {
        for found in pixel("formula; = <visible, 1, 1 - visible>;", lights, target, false, &[]) {
            assert_eq!(found, [1.0, 1.0, 0.0]);
        }
    }
}

#[test]
pub(super) fn only_ki_makes_a_term_exactly_zero() {
    let infinite = "formula; = <visible/0, visible*exp(1000), 1>;";
    for found in pixel(infinite, "sun: point, <0,6,-8>;", ON_LEAF, true, &[]) {
        assert!(found[0].is_nan() && found[1].is_nan() && found[2] == 1.0, "{found:?}");
    }
    for found in pixel(infinite, "sun: point, <0,6,-8>;", ON_LEAF, true, &["sun.ki=0"]) {
        assert_eq!(found, [0.0; 3]);
    }
    // A formula that does not read it is not evaluated where the light does not reach.
    for found in pixel("formula; UNUSED = visible; = <1/0, 1, 1>;", "sun: point, <0,6,-8>;", ON_LEAF, true, &[]) {
        assert_eq!(found, [0.0; 3]);
    }
}

fn source(kind: FileKind, name: &str) -> Source {
    Source::new(name, presets::text(kind, name).expect("a built-in file"))
}

/// The bits of the picture of a formula with its defaults, for hits that were traced for another formula.
fn bits(backend: &Arc<dyn Backend>, formula: &str, traced_for: &str) -> Vec<u32> {
    let crystals = source(FileKind::Scene, "crystals");
    let engine = Engine::new(Arc::clone(backend));
    let view = View::new(61, 43).and_then(|view| view.with_depth(3)).expect("within range");
    let other = Subject::parse(traced_for, crystals.text(), view).expect("sound texts");
    let subject =
        Subject { formula: Subject::parse(formula, crystals.text(), view).expect("sound texts").formula, ..other.clone() };
    let hits = engine.trace(&other, &Task::UNWATCHED).expect("small enough");
    let evaluator = engine.prepare(&subject, &hits, &[]).expect("a formula of ordinary size");
    let values = Values::defaults(&subject.formula, subject.world.scene());
    evaluator.frame(values.numbers()).linear.iter().flatten().map(|component| component.to_bits()).collect()
}

#[test]
pub(super) fn hits_of_any_formula_serve_any_other_with_the_same_bits() {
    let phong = source(FileKind::Formula, "phong");
    for backend in backends() {
        for (formula, other) in [(LEAF, phong.text()), (phong.text(), LEAF)] {
            assert!(bits(&backend, formula, formula) == bits(&backend, formula, other));
        }
    }
}

#[test]
pub(super) fn formulas_that_read_visible_are_dragged() {
    let crystals = source(FileKind::Scene, "crystals");
    for tested in tested() {
        let mut model = Model::on(&tested, &crystals, &Source::new("leaf", LEAF));
        model.set("floor.kr=0.3");
        for (slider, method) in [
            ("floor.front", Method::Images),
            ("globe.back", Method::Images),
            ("floor.veins", Method::Specialised),
            ("key.ki", Method::Images),
            ("key.IL", Method::Images),
        ] {
            let mut drag = model.drag(slider, usize::MAX);
            assert!(tested.drags_by(&*drag, method), "{slider}");
            let mut drawn = model.black();
            for part in [0.1, 0.8] {
                model.move_to(slider, part);
                model.check(&mut drag, &mut drawn, slider);
            }
            while !drag.prepare() {}
            for part in [0.3, 1.0, 0.0] {
                model.move_to(slider, part);
                model.check(&mut drag, &mut drawn, slider);
            }
        }
    }
}

#[test]
pub(super) fn backends_agree_where_many_lights_cast_many_shadows() {
    // With this many, hits are scattered in the store for other formulas.
    let lights: String = (0..12)
        .map(|light| {
            let (z, x) = (0.5 * f64::from(light)).sin_cos();
            format!("l{light}: point, <{}, {}, {}>;", 7.0 * x, 3.0 - f64::from(light % 3), 7.0 * z)
        })
        .collect();
    let balls: String = (0..9)
        .map(|ball| format!("b{ball}: sphere, center <{}, 0.7, {}>, radius 0.7;", 2 * (ball % 3) - 2, 2 * (ball / 3) - 2))
        .collect();
    let scene = format!(
        "bodies; floor: rectangle, <-6, 0, -6>, <6, 0, -6>, <6, 0, 6>, opaque; {balls} lights; {lights}
         camera; position <0, 5, 9>; gaze <0, -0.5, -1>; up <0, 1, 0>; fov 40;"
    );
    let view = View::new(127, 83).and_then(|view| view.with_depth(3)).expect("within range");
    let subject = Subject::parse(LEAF, &scene, view).expect("sound texts");
    let mut values = Values::defaults(&subject.formula, subject.world.scene());
    let given = "*.kr=0.3".parse::<NamedAssignment>().expect("a setting").resolve(values.table()).expect("known names");
    assert_eq!(values.assign(&given), []);
    let interpreted = Interpreted::new(&subject.formula, &subject.world, view).expect("small enough");
    for backend in backends() {
        let engine = Engine::new(backend);
        let hits = engine.trace(&subject, &Task::UNWATCHED).expect("small enough");
        assert!(hits.tiles.iter().any(|tile| tile.copies > 0), "there are scattered hits");
        let evaluator = engine.prepare(&subject, &hits, &[]).expect("a formula of ordinary size");
        let found = verify(&*evaluator, &interpreted, values.numbers());
        assert!(found.passes() && found.excused == 0, "{found:?}");
    }
}
