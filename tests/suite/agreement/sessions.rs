//! Dragged sliders of built-in models and scenes: methods, budgets, and numbers that change during a drag.

use crate::agreement::drags::{VIEWS, wrong};
use crate::agreement::{backends, only_draws_in_full};
use illuminator::backends::DEFAULT;
use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::verify;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Backend, Drag, Evaluator, Framebuffer};
use illuminator::formula::{Formula, ParameterId};
use illuminator::lang::source::Source;
use illuminator::picture::Transfer;
use illuminator::plan::Method;
use illuminator::scene::Scene;
use illuminator::trace::View;
use illuminator::workspace::{FileKind, presets};
use illuminator::workspace::{NamedAssignment, OwnerId, Session, Values};
use illuminator::world::{Assets, World};
use std::sync::Arc;

/// A backend under test, and the size of a picture that it draws in reasonable time. Fast backends get several tiles.
/// The last cell of sixteen pixels is not full.
pub(super) struct Tested {
    backend: Arc<dyn Backend>,
    size: [u32; 2],
}

impl Tested {
    /// Whether a drag has this method, or the backend draws every picture in full.
    pub(super) fn drags_by(&self, drag: &dyn Drag, method: Method) -> bool {
        drag.method() == method || only_draws_in_full() && drag.method() == Method::General
    }
}

/// Every backend under test.
pub(super) fn tested() -> Vec<Tested> {
    let size = |backend: &Arc<dyn Backend>| if backend.name() == DEFAULT.name { [251, 143] } else { [63, 37] };
    backends().into_iter().map(|backend| Tested { size: size(&backend), backend }).collect()
}

fn source(kind: FileKind, name: &str) -> Source {
    Source::new(name, presets::text(kind, name).expect("a built-in file"))
}

/// A formula on the crystals, with the values of their session.
pub(super) struct Model {
    size: [u32; 2],
    compiled: Arc<dyn Evaluator>,
    values: Values,
    /// How many hits are in more than one group.
    scattered: u32,
}

impl Model {
    fn new(tested: &Tested, formula: &Source) -> Self {
        Self::on(tested, &source(FileKind::Scene, "crystals"), formula)
    }

    pub(super) fn on(tested: &Tested, scene: &Source, formula: &Source) -> Self {
        let (session, _) = Session::parse(&source(FileKind::Session, "crystals")).expect("a session");
        let (formula, _) = Formula::parse(formula).expect("a formula");
        let (scene, _) = Scene::parse(scene).expect("a scene");
        let view = View::new(tested.size[0], tested.size[1]).expect("a size in range");
        let (given, _) = session.assignments(Values::defaults(&formula, &scene).table());
        let (values, _) = Values::new(&formula, &scene, &given);
        let (engine, subject) =
            (Engine::new(Arc::clone(&tested.backend)), Subject::new(formula, scene, &Assets::NONE, view).expect("no meshes"));
        let hits = engine.trace(&subject, &Task::UNWATCHED).expect("small enough");
        let scattered = hits.tiles.iter().map(|tile| tile.copies).sum();
        let compiled = engine.prepare(&subject, &hits, &[]).expect("a formula of ordinary size");
        Self { size: tested.size, compiled, values, scattered }
    }

    fn preset(tested: &Tested, formula: &str) -> Self {
        Self::new(tested, &source(FileKind::Formula, formula))
    }

    pub(super) fn black(&self) -> Framebuffer {
        Framebuffer::black(self.size[0], self.size[1], Transfer::Linear)
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    pub(super) fn drag(&self, slider: &str, budget: usize) -> Box<dyn Drag> {
        let (owner, id) = self.slider(slider);
        let moved = self.values.moved_indices(owner, id);
        Arc::clone(&self.compiled).drag(&moved, self.values.numbers(), budget, None).expect("kernels of ordinary size")
    }

    fn slider(&self, label: &str) -> (OwnerId, ParameterId) {
        let table = self.values.table();
        let found = self.values.iter().find(|(owner, id, _)| table.label(*owner, *id) == label);
        found.map(|(owner, id, _)| (owner, id)).expect("a slider")
    }

    /// Moves a slider within its range. The components of a colour move to different numbers.
    pub(super) fn move_to(&mut self, slider: &str, part: f32) {
        let (owner, id) = self.slider(slider);
        let [low, high] = self.values.range_of(owner, id).unwrap_or([0.0, 1.0]);
        let parts = [part, 1.0 - part, (part + 0.3).fract()];
        self.values.move_to(owner, id, parts.map(|part| low + part * (high - low)));
    }

    pub(super) fn set(&mut self, setting: &str) {
        let given = setting.parse::<NamedAssignment>().expect("a setting").resolve(self.values.table()).expect("known names");
        assert_eq!(self.values.assign(&given), []);
    }

    /// Draws a frame and compares it with the frame of the general kernel.
    pub(super) fn check(&self, drag: &mut Box<dyn Drag>, drawn: &mut Framebuffer, what: &str) {
        drag.frame(self.values.numbers(), drawn);
        assert_eq!(wrong(drawn, &self.compiled.frame(self.values.numbers())), 0, "{what}");
        drag.prepare();
    }
}

#[test]
pub(super) fn every_slider_is_dragged_by_its_method() {
    for tested in tested() {
        every_slider_is_dragged_by_its_method_by(&tested);
    }
}

fn every_slider_is_dragged_by_its_method_by(tested: &Tested) {
    use Method::{Images, Specialised};
    let cases: [(&str, &[(&str, Method)]); 2] = [
        (
            "phong",
            &[
                ("floor.Cd", Images),
                ("floor.kd", Images),
                ("floor.kr", Images),
                ("globe.kt", Images),
                ("ivory.h", Specialised),
                ("key.ki", Images),
                ("key.IL", Images),
                ("ka", Images),
                ("background", Images),
            ],
        ),
        (
            "strauss",
            &[("floor.Cd", Images), ("floor.m", Images), ("floor.t", Specialised), ("ivory.s", Specialised), ("key.IL", Images)],
        ),
    ];
    for (formula, sliders) in cases {
        let mut model = Model::preset(tested, formula);
        for ((slider, method), view) in sliders.iter().flat_map(|slider| VIEWS.map(|view| (slider, view))) {
            let what = format!("{slider} of {formula}, {view:?}");
            let mut drag = model.drag(slider, usize::MAX);
            assert!(tested.drags_by(&*drag, *method), "{what}");
            assert!(!drag.is_ready() || drag.method() == Method::General, "{what}");
            let mut drawn = Framebuffer::black(model.size[0], model.size[1], view);
            // Before, during and after the preparation.
            for part in [0.2, 0.9, 0.5] {
                model.move_to(slider, part);
                model.check(&mut drag, &mut drawn, &what);
            }
            while !drag.prepare() {}
            assert!(drag.is_ready(), "{what}");
            for part in [0.1, 0.7, 0.0, 1.0] {
                model.move_to(slider, part);
                model.check(&mut drag, &mut drawn, &what);
            }
            let pixels = drag.pixels();
            assert!(0 < pixels && pixels <= model.pixels(), "{what}: {pixels} pixels");
            // Compiled code writes only pixels that the slider can change.
            let everywhere = slider.starts_with("key") || *slider == "ka" || tested.backend.name() != DEFAULT.name;
            assert!(everywhere || pixels < model.pixels(), "{what}: {pixels} pixels");
        }
    }
}

#[test]
pub(super) fn pictures_are_right_within_any_budget() {
    for tested in tested() {
        pictures_are_right_within_any_budget_by(&tested);
    }
}

fn pictures_are_right_within_any_budget_by(tested: &Tested) {
    let mut model = Model::preset(tested, "phong");
    for slider in ["floor.Cd", "floor.kr", "ivory.h", "key.IL"] {
        let mut drag = model.drag(slider, usize::MAX);
        while !drag.prepare() {}
        let needed = drag.bytes();
        for budget in [0, needed / 2, needed] {
            let what = format!("{slider} within {budget} of {needed} bytes");
            let mut drag = model.drag(slider, budget);
            let mut drawn = model.black();
            for part in [0.2, 0.9, 0.5, 0.0, 1.0, 0.3] {
                model.move_to(slider, part);
                model.check(&mut drag, &mut drawn, &what);
                assert!(drag.bytes() <= budget, "{what}: {}", drag.bytes());
            }
            while !drag.prepare() {}
            model.move_to(slider, 0.4);
            model.check(&mut drag, &mut drawn, &what);
            assert!(drag.bytes() <= budget, "{what}: {}", drag.bytes());
        }
    }
}

#[test]
pub(super) fn everything_is_prepared_again_when_other_numbers_change() {
    for tested in tested() {
        everything_is_prepared_again_when_other_numbers_change_by(&tested);
    }
}

fn everything_is_prepared_again_when_other_numbers_change_by(tested: &Tested) {
    let mut model = Model::preset(tested, "phong");
    for (slider, others) in [
        ("floor.Cd", ["key.ki=0.2", "floor.kd=0.9", "gold.kr=0.1"]),
        ("ivory.h", ["ivory.ks=0.1", "background=<0.5, 0.1, 0.3>", "ivory.Cd=<0.1, 0.9, 0.2>"]),
        ("globe.kt", ["hollow.kt=0.2", "ka=0.7", "fill.IL=<0.1, 0.2, 0.9>"]),
    ] {
        let mut drag = model.drag(slider, usize::MAX);
        let mut drawn = model.black();
        for other in others {
            let what = format!("{slider}, then {other}");
            while !drag.prepare() {}
            model.move_to(slider, 0.25);
            model.check(&mut drag, &mut drawn, &what);
            let before = model.compiled.frame(model.values.numbers());
            model.set(other);
            assert!(wrong(&drawn, &model.compiled.frame(model.values.numbers())) > 0, "{what}: another picture");
            model.check(&mut drag, &mut drawn, &what);
            assert!(wrong(&drawn, &before) > 0);
            // The drag goes on with what was made again.
            while !drag.prepare() {}
            for part in [0.75, 0.5] {
                model.move_to(slider, part);
                model.check(&mut drag, &mut drawn, &what);
            }
        }
    }
}

#[test]
pub(super) fn scattered_hits_are_drawn_and_dragged() {
    for tested in tested() {
        scattered_hits_are_drawn_and_dragged_by(&tested);
    }
}

fn scattered_hits_are_drawn_and_dragged_by(tested: &Tested) {
    let lights: String = (0..12)
        .map(|light| {
            let (z, x) = (0.5 * f64::from(light)).sin_cos();
            format!("l{light}: point, <{}, 7, {}>;", 7.0 * x, 7.0 * z)
        })
        .collect();
    let balls: String = (0..9)
        .map(|ball| format!("b{ball}: sphere, center <{}, 0.7, {}>, radius 0.7, opaque;", 2 * (ball % 3) - 2, 2 * (ball / 3) - 2))
        .collect();
    let scene = format!(
        "bodies; floor: rectangle, <-6, 0, -6>, <6, 0, -6>, <6, 0, 6>, opaque; {balls} lights; {lights}
         camera; position <0, 5, 9>; gaze <0, -0.5, -1>; up <0, 1, 0>; fov 40;"
    );
    let scene = Source::new("scene", scene);
    let mut model = Model::on(tested, &scene, &source(FileKind::Formula, "phong"));
    assert!(model.scattered > 50, "{} hits stand in several groups", model.scattered);
    model.set("*.kr=0.3");
    let (formula, _) = Formula::parse(&source(FileKind::Formula, "phong")).expect("a formula");
    let (parsed, _) = Scene::parse(&scene).expect("a scene");
    let (world, view) = (
        Arc::new(World::new(parsed, &Assets::NONE).expect("no meshes")),
        View::new(tested.size[0], tested.size[1]).expect("a size"),
    );
    let interpreted = Interpreted::new(&Arc::new(formula), &world, view).expect("small enough");
    assert!(verify(&*model.compiled, &interpreted, model.values.numbers()).passes());
    for slider in ["floor.kd", "floor.h", "b4.kr", "l3.ki"] {
        let mut drag = model.drag(slider, usize::MAX);
        while !drag.prepare() {}
        let mut drawn = model.black();
        for part in [0.0, 0.4, 1.0] {
            model.move_to(slider, part);
            model.check(&mut drag, &mut drawn, slider);
        }
    }
}

#[test]
pub(super) fn formulas_of_exponential_size_are_dragged() {
    for tested in tested() {
        formulas_of_exponential_size_are_dragged_by(&tested);
    }
}

fn formulas_of_exponential_size_are_dragged_by(tested: &Tested) {
    let lines: String = (1..=45).map(|index| format!("M{index} = (M{0} + M{0})*0.5;", index - 1)).collect();
    for (first, method) in [("kd*max(0, N.L)*Cd", Method::Images), ("max(0, N.L)^(1 + kd)*Cd + ks*Cd", Method::Specialised)] {
        let text = format!(
            "body_specific; kd: scalar, constraint 0..1; ks: scalar, constraint 0..1; formula; M0 = {first}; {lines} = M45;"
        );
        let mut model = Model::new(tested, &Source::new("doubled", text));
        let mut drag = model.drag("floor.kd", usize::MAX);
        assert!(tested.drags_by(&*drag, method));
        while !drag.prepare() {}
        let mut drawn = model.black();
        for part in [0.1, 0.5, 0.9] {
            model.move_to("floor.kd", part);
            model.check(&mut drag, &mut drawn, first);
        }
    }
}

#[test]
pub(super) fn kept_work_follows_active_lights_and_path_weights() {
    for tested in tested() {
        kept_work_follows_active_lights_and_path_weights_by(&tested);
    }
}

fn kept_work_follows_active_lights_and_path_weights_by(tested: &Tested) {
    let mut model = Model::preset(tested, "phong");
    let mut pictures: Vec<Vec<u32>> = Vec::new();
    // Without a light; as given; without reflections of one body and of all; with weights too small for single
    // precision; and back. Each frame uses what the one before has kept. Matte bodies keep their values.
    let steps = [
        &["key.ki=0"][..],
        &["key.ki=1"],
        &["floor.kr=0"],
        &["*.kr=0"],
        &["*.kr=1e-20", "*.kt=0", "Ia=<1,0.5,0.25>"],
        &["*.kr=0.5", "*.kt=0.5"],
        &["ka=0.1"],
    ];
    for settings in steps {
        for setting in settings {
            let given =
                setting.parse::<NamedAssignment>().expect("a setting").resolve(model.values.table()).expect("known names");
            model.values.assign(&given);
        }
        let kept = model.compiled.frame(model.values.numbers());
        let fresh = Model::preset(tested, "phong").compiled.frame(model.values.numbers());
        let bits = |frame: &illuminator::picture::Frame| -> Vec<u32> {
            frame.linear.iter().flatten().map(|component| component.to_bits()).collect()
        };
        assert!(bits(&kept) == bits(&fresh), "{settings:?}");
        let again = model.compiled.frame(model.values.numbers());
        assert!(bits(&kept) == bits(&again), "{settings:?}");
        assert!(!pictures.contains(&bits(&kept)), "a picture of its own: {settings:?}");
        pictures.push(bits(&kept));
    }
}
