//! Every built-in formula with every built-in scene: the backends must agree.

use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::verify;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::formula::Formula;
use illuminator::lang::source::Source;
use illuminator::scene::Scene;
use illuminator::trace::View;
use illuminator::workspace::{FileKind, presets};
use illuminator::workspace::{NamedAssignment, Values};
use std::sync::Arc;

fn source(kind: FileKind, name: &str) -> Source {
    Source::new(name, presets::text(kind, name).expect("a built-in file"))
}

/// Defaults, and values with which every ray contributes.
const SETTINGS: [&[&str]; 2] = [&[], &["*.kr=0.3", "*.kt=0.5", "*.ki=0.7", "background=<0.2, 0.3, 0.5>"]];

#[test]
fn backends_agree_on_every_preset() {
    for scene_name in presets::names(FileKind::Scene) {
        let (scene, _) = Scene::parse(&source(FileKind::Scene, scene_name)).expect("a sound scene");
        let world = Arc::new(crate::world_of(scene));
        let view = View::new(96, 54).expect("a size in range");
        for formula_name in presets::names(FileKind::Formula) {
            let (formula, _) = Formula::parse(&source(FileKind::Formula, formula_name)).expect("a sound formula");
            let formula = Arc::new(formula);
            let subject = Subject { formula: Arc::clone(&formula), world: Arc::clone(&world), view };
            let compiled = Engine::default().evaluator(&subject, &[], &Task::UNWATCHED).expect("compiled code takes the presets");
            let interpreted = Interpreted::new(&formula, &world, view).expect("the interpreter takes the presets");
            for settings in SETTINGS {
                let mut values = Values::defaults(&formula, world.scene());
                let settings = settings.iter().map(|text| text.parse::<NamedAssignment>().expect("a setting"));
                let given: Vec<_> = settings.flat_map(|setting| setting.resolve(values.table()).expect("known names")).collect();
                values.assign(&given);
                let found = verify(&*compiled, &interpreted, values.numbers());
                assert!(found.passes() && found.excused == 0, "{formula_name} on {scene_name}: {found:?}");
            }
        }
    }
}
