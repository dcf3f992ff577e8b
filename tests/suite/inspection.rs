//! An inspected pixel has the interpreter's colour, and its parts add up to it.

use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::TOLERANCE;
use illuminator::evaluate::Evaluator;
use illuminator::evaluate::inspect::{End, Inspector, Visibility};
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
