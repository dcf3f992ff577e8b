//! The stored data of drags, on a built-in session.

use super::*;
use crate::evaluate::Evaluator;
use crate::formula::Formula;
use crate::jit::CompiledFormula;
use crate::lang::source::Source;
use crate::lang::variables::EvaluatedLights;
use crate::picture::ViewTransform;
use crate::scene::Scene;
use crate::trace::{Budget, View, trace};
use crate::workspace::{FileKind, presets};
use crate::workspace::{Session, Values};
use crate::world::{Assets, World};
use std::sync::atomic::AtomicBool;

/// Some sliders of the crystals: some are drawn by images, others need a kernel.
const SLIDERS: [&str; 9] = ["floor.kd", "floor.Cd", "floor.kr", "globe.kt", "globe.h", "gold.ks", "key.ki", "key.IL", "ka"];

fn source(kind: FileKind, name: &str) -> Source {
    Source::new(name, presets::text(kind, name).expect("a built-in file"))
}

/// The crystals with Phong's model, in a size of several tiles.
fn session() -> (Arc<Compiled>, Values) {
    let (session, _) = Session::parse(&source(FileKind::Session, "crystals")).expect("a session");
    let (formula, _) = Formula::parse(&source(FileKind::Formula, "phong")).expect("a formula");
    let (scene, _) = Scene::parse(&source(FileKind::Scene, "crystals")).expect("a scene");
    let view = View::new(256, 144).expect("a size in range");
    let world = Arc::new(World::new(scene, &Assets::NONE).expect("no meshes"));
    let hits = Arc::new(
        trace(&world, &view, EvaluatedLights::Reaching, &Budget::UNLIMITED, &|_| {}, &AtomicBool::new(false))
            .expect("small enough"),
    );
    let (given, _) = session.assignments(Values::defaults(&formula, world.scene()).table());
    let (values, _) = Values::new(&formula, world.scene(), &given);
    let compiled = Arc::new(CompiledFormula::new(&formula).expect("a formula of ordinary size"));
    (Arc::new(Compiled::new(compiled, &Arc::new(formula), &[hits], values.numbers()).expect("hits of the scene")), values)
}

/// The crystals as mirrors, by a formula that gives weights of rays, with default values.
fn mirrors() -> (Arc<Compiled>, Values) {
    let formula = "body_specific; h: scalar, constraint 1..200, default 20; formula;
        reflected = 0.3 + 0.6*(1 - max(0, N.V))^2; refracted = 0.4*max(0, N.V);
        = IL*Cd*(max(0, N.L)*sin(9*alpha)*cos(5*beta)*exp(gamma) + 1 + max(0, R.V)^h);";
    let (formula, _) = Formula::parse(&Source::new("mirrors", formula)).expect("a formula");
    let (scene, _) = Scene::parse(&source(FileKind::Scene, "crystals")).expect("a scene");
    let view = View::new(256, 144).and_then(|view| view.with_depth(4)).expect("a size and a depth in range");
    let world = Arc::new(World::new(scene, &Assets::NONE).expect("no meshes"));
    let (lights, unstopped) = (EvaluatedLights::Reaching, AtomicBool::new(false));
    let hits = Arc::new(trace(&world, &view, lights, &Budget::UNLIMITED, &|_| {}, &unstopped).expect("small enough"));
    let values = Values::defaults(&formula, world.scene());
    let compiled = Arc::new(CompiledFormula::new(&formula).expect("a formula of ordinary size"));
    (Arc::new(Compiled::new(compiled, &Arc::new(formula), &[hits], values.numbers()).expect("hits of the scene")), values)
}

/// One body that fills the picture, under one light: no part of the picture is spared by a slider of the body.
const WALL: &str = "bodies; wall: sphere, center <0,0,-4>, radius 3.6, opaque; lights; key: point, <5,8,6>;
    camera; position <0,0,1.5>; gaze <0,0,-1>; up <0,1,0>; fov 30;";

/// A formula on the wall, with default values.
fn on_wall(formula: &str) -> (Arc<Compiled>, Values) {
    let (formula, _) = Formula::parse(&Source::new("wall", formula)).expect("a formula");
    let (scene, _) = Scene::parse(&Source::new("wall", WALL)).expect("a scene");
    let view = View::new(256, 144).expect("a size in range");
    let world = Arc::new(World::new(scene, &Assets::NONE).expect("no meshes"));
    let (lights, unstopped) = (EvaluatedLights::Reaching, AtomicBool::new(false));
    let hits = Arc::new(trace(&world, &view, lights, &Budget::UNLIMITED, &|_| {}, &unstopped).expect("small enough"));
    let values = Values::defaults(&formula, world.scene());
    let compiled = Arc::new(CompiledFormula::new(&formula).expect("a formula of ordinary size"));
    (Arc::new(Compiled::new(compiled, &Arc::new(formula), &[hits], values.numbers()).expect("hits of the scene")), values)
}

/// The indices of the numbers that a slider moves.
fn moved_by(values: &Values, slider: &str) -> Vec<usize> {
    let roster = values.table();
    let found = values.iter().find(|(owner, id, _)| roster.label(*owner, *id) == slider);
    let (owner, id, _) = found.expect("a slider");
    values.moved_indices(owner, id)
}

/// The number of work items that are left, and their cost.
fn left(drag: &CompiledDrag) -> (usize, u64) {
    let of_tile = |work: &TileWork| (work.left().len(), work.left().iter().map(|item| item.cost).sum::<u64>());
    drag.tiles
        .iter()
        .filter_map(|tile| tile.work.as_ref())
        .map(of_tile)
        .fold((0, 0), |(items, cost), (more, costs)| (items + more, cost + costs))
}

#[test]
fn preparing_takes_no_more_at_a_time_than_a_full_evaluation() {
    let (compiled, values) = session();
    for slider in SLIDERS {
        let mut drag =
            CompiledDrag::new(&compiled, &moved_by(&values, slider), values.numbers(), usize::MAX, None).expect("kernels");
        let full = full_cost(&compiled);
        let (all, total) = left(&drag);
        assert!(all > 0 && !drag.is_ready(), "{slider}");
        let mut calls = 0;
        loop {
            let before = left(&drag);
            let ready = drag.prepare();
            let after = left(&drag);
            let (items, cost) = (before.0 - after.0, before.1 - after.1);
            calls += 1;
            assert!(items == 1 || cost <= full, "{slider}: {items} items of cost {cost}, a full evaluation is {full}");
            assert!(items > 0, "{slider}: nothing is done in a call");
            assert_eq!(ready, drag.is_ready());
            assert_eq!(ready, after.0 == 0);
            if ready {
                break;
            }
        }
        println!("{slider}: {all} items in {calls} calls, {:.2} full evaluations", total as f64 / full as f64);
        // The work of two calls is more than a full evaluation.
        assert!(calls <= 2 * total / full + 1, "{slider}: {calls} calls for {total}, a full evaluation is {full}");
        assert!(drag.prepare(), "nothing is left to do");
    }
}

#[test]
fn nothing_is_kept_without_a_budget() {
    let (compiled, values) = session();
    for slider in SLIDERS {
        let mut drag = CompiledDrag::new(&compiled, &moved_by(&values, slider), values.numbers(), 0, None).expect("kernels");
        while !drag.prepare() {
            assert_eq!(drag.bytes(), 0, "{slider}");
        }
        assert_eq!(drag.bytes(), 0, "{slider}");
        let general = |tile: &TileDrag| match &tile.state {
            TileState::Untouched | TileState::Whole(_) => tile.work.is_none(),
            TileState::Images { images, .. } => images.pixels(usize::MAX) == 0,
            TileState::Live(_) => false,
        };
        assert!(drag.tiles.iter().all(general), "{slider}");
        assert!(drag.tiles.iter().any(|tile| matches!(tile.state, TileState::Whole(_))), "{slider}");
    }
}

#[test]
fn what_is_counted_is_what_is_kept() {
    let (compiled, values) = session();
    for slider in SLIDERS {
        let mut drag =
            CompiledDrag::new(&compiled, &moved_by(&values, slider), values.numbers(), usize::MAX, None).expect("kernels");
        while !drag.prepare() {}
        let needed = drag.bytes();
        assert!(needed > 0, "{slider}");
        let mut tight =
            CompiledDrag::new(&compiled, &moved_by(&values, slider), values.numbers(), needed / 2, None).expect("kernels");
        loop {
            let ready = tight.prepare();
            assert!(tight.bytes() <= needed / 2, "{slider}: {} bytes of {needed}", tight.bytes());
            if ready {
                break;
            }
        }
        let given_up = tight.tiles.iter().any(|tile| matches!(tile.state, TileState::Whole(_)));
        assert!(tight.bytes() > 0 && given_up, "{slider}: a part is kept");
    }
}

#[test]
fn stored_data_is_kept_only_where_it_is_faster() {
    let phong = presets::text(FileKind::Formula, "phong").expect("a built-in file");
    let lambert = presets::text(FileKind::Formula, "lambert").expect("a built-in file");
    let waves = "body_specific; a: scalar, constraint 0..1; b: scalar, constraint 0..9; formula;
        = IL*Cd*(exp(-a*alpha) + sin(b*alpha)*cos(b*beta)*exp(b*(N.L))*sin(b*(V.L))*cos(b*gamma)*exp(b*(N.V)));";
    let layers = "body_specific; a: scalar, constraint 0..1; b: scalar, constraint 0..9; formula;
        = IL*Cd*(a + sin(b*alpha)*cos(b*beta)*exp(b*(N.L))*sin(b*(V.L)));";
    for (formula, slider, method) in [
        // A live part reads as much as the whole contribution, and the base too.
        (phong, "wall.h", Method::General),
        // The live part is a small part of the computation.
        (waves, "wall.a", Method::Specialised),
        (waves, "wall.b", Method::General),
        // Two images are twelve times as large as the only column.
        (lambert, "wall.kd", Method::General),
        (layers, "wall.a", Method::Images),
    ] {
        let (compiled, values) = on_wall(formula);
        let mut drag =
            CompiledDrag::new(&compiled, &moved_by(&values, slider), values.numbers(), usize::MAX, None).expect("kernels");
        while !drag.prepare() {}
        assert_eq!(drag.method(), method, "{slider}");
        assert_eq!(drag.bytes() > 0, method != Method::General, "{slider}");
    }
}

#[test]
fn what_moves_is_seen_in_mirrors_whose_weights_the_formula_gives() {
    let (compiled, values) = mirrors();
    for slider in ["floor.h", "gold.h"] {
        let moved = moved_by(&values, slider);
        let mut drag = CompiledDrag::new(&compiled, &moved, values.numbers(), usize::MAX, None).expect("kernels");
        while !drag.prepare() {}
        let live = drag.tiles.iter().filter(|tile| matches!(tile.state, TileState::Live(_))).count();
        assert!(live > 2, "{slider}: {live} tiles");
        let view = ViewTransform::default();
        let (mut dragged, mut whole) = (Framebuffer::black(256, 144, view), Framebuffer::black(256, 144, view));
        for exponent in [20.0, 3.0, 150.0] {
            let mut numbers = values.numbers().to_vec();
            moved.iter().for_each(|index| numbers[*index] = exponent);
            drag.frame(&numbers, &mut dragged);
            Evaluator::draw(&*compiled, &numbers, &mut whole);
            let bytes =
                |framebuffer: &Framebuffer| framebuffer.pixels.iter().flat_map(|pixel| pixel.to_le_bytes()).collect::<Vec<u8>>();
            let difference = bytes(&dragged).iter().zip(bytes(&whole)).map(|(own, other)| own.abs_diff(other)).max();
            assert!(difference <= Some(1), "{slider} = {exponent}: {difference:?}");
        }
    }
}
