//! An inspected pixel has the interpreter's colour, and its parts add up to it.

use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::TOLERANCE;
use illuminator::evaluate::Evaluator;
use illuminator::evaluate::inspect::{End, Inspector, PassColours, Visibility};
use illuminator::files::Readable;
use illuminator::formula::Formula;
use illuminator::lang::source::Source;
use illuminator::lang::variables::EvaluatedLights;
use illuminator::scene::Scene;
use illuminator::trace::View;
use illuminator::workspace::Location;
use illuminator::workspace::{FileKind, presets};
use illuminator::workspace::{Session, Values};
use std::sync::Arc;

fn read(location: &Location, kind: FileKind) -> Source {
    location.read(kind, Readable::Regular).expect("a built-in file")
}

fn close(one: f64, other: f32) -> bool {
    (one - f64::from(other)).abs() <= f64::from(TOLERANCE) * f64::from(other.abs().max(1.0))
}

#[test]
fn every_preset_adds_up_to_the_interpreters_pixel() {
    for name in presets::names(FileKind::Session) {
        let (session, _) = Session::parse(&read(&Location::Preset(name.to_owned()), FileKind::Session)).expect("a session");
        let (formula, _) = Formula::parse(&read(&session.formula, FileKind::Formula)).expect("a formula");
        let (scene, _) = Scene::parse(&read(&session.scene, FileKind::Scene)).expect("a scene");
        let (given, _) = session.assignments(Values::defaults(&formula, &scene).table());
        let (values, _) = Values::new(&formula, &scene, &given);
        let (formula, world) = (Arc::new(formula), Arc::new(crate::world_of(scene)));
        let inspector = Inspector::new(&formula, &world, values.numbers());
        for (depth, shadows) in (1..=6).flat_map(|depth| [(depth, false), (depth, true)]) {
            let view = View::new(10, 5).and_then(|view| view.with_depth(depth)).expect("within range").with_shadows(shadows);
            let interpreted = Interpreted::new(&formula, &world, view).expect("small code");
            let frame = interpreted.frame(values.numbers());
            for (index, expected) in frame.linear.iter().enumerate() {
                let pixel = [index as u32 % 10, index as u32 / 10];
                let what = format!("{name}, depth {depth}, shadows {shadows}, pixel {pixel:?}");
                let inspection = inspector.inspect(&view, pixel).expect("a pixel of the picture");
                assert_eq!(&inspection.total, expected, "{what}");
                assert!(inspection.rays.iter().all(|ray| ray.depth <= depth), "{what}");
                for (component, whole) in expected.iter().enumerate() {
                    let parts = inspection.rays.iter().map(|ray| f64::from(ray.contribution[component]));
                    assert!(close(parts.sum(), *whole), "{what}: the parts are not the whole");
                }
                for ray in &inspection.rays {
                    let End::Hit(hit) = &ray.end else { continue };
                    assert_eq!(hit.lights.len(), world.scene().lights.len(), "{what}");
                    for light in &hit.lights {
                        let lit = light.visibility == Visibility::Lit;
                        // A formula that reads `visible` is evaluated for all lights.
                        let adds = light.evaluated || light.contribution == [0.0; 3];
                        assert!(lit || shadows && adds, "{what}: {light:?}");
                        let all = formula.evaluated_lights() == EvaluatedLights::All;
                        assert_eq!(light.evaluated, lit || all, "{what}: {light:?}");
                        let none = light.visibility == Visibility::Shadowed(Vec::new());
                        assert!(!none, "{what}: a shadow that no body casts");
                    }
                }
            }
        }
    }
}

#[test]
fn passes_and_their_mean_are_those_of_the_interpreter() {
    let scene = "bodies; ball: sphere, center <0,1,0>, radius 1; floor: rectangle, <-9,0,-9>, <9,0,-9>, <9,0,9>, opaque;
        lights; lamp: sphere, center <2,4,3>, radius 0.7; cone: spot, <-3,4,3>, target <0,0,0>, angle 25, soft 20;
        panel: rectangle, <-1,5,-1>, <1,5,-1>, <1,5,1>; sun: directional, <1,-2,-1>;
        camera; position <0,2,6>; gaze <0,-0.25,-1>; up <0,1,0>; fov 40;";
    let (scene, _) = Scene::parse(&Source::new("scene", scene)).expect("a scene");
    let world = Arc::new(crate::world_of(scene.clone()));
    // The first is proportional to the colour of the light, the second is not.
    for formula in ["= IL*Cd*(0.7*max(0, N.L) + 0.3*max(0, R.V)^20);", "= sqrt(IL)*Cd*max(0, N.L);", "= IL*Cd*visible;"] {
        let (formula, _) = Formula::parse(&Source::new("formula", format!("formula; {formula}"))).expect("a formula");
        let (values, _) = Values::new(&formula, &scene, &[]);
        let formula = Arc::new(formula);
        let view = View::new(12, 8).and_then(|view| view.with_depth(3)).expect("within range");
        let inspector = Inspector::new(&formula, &world, values.numbers());
        let interpreted = Interpreted::new(&formula, &world, view).expect("small code").with_passes(5);
        let mean = interpreted.frame(values.numbers());
        let last = Interpreted::new(&formula, &world, view.with_pass(4)).expect("small code").frame(values.numbers());
        assert!(mean != last);
        for (index, (mean, last)) in mean.linear.iter().zip(&last.linear).enumerate() {
            let pixel = [index as u32 % 12, index as u32 / 12];
            let colours = PassColours { colours: inspector.pass_colours(&view, pixel, 0..5) };
            assert_eq!((&colours.mean(), &colours.colours[4]), (mean, last), "{pixel:?}");
        }
    }
}
