//! Scenes of many small balls: the time for a ray that a picture follows, with its shadow rays and its place in the
//! store, and the time to make the scene ready.

use crate::scattered;
use illuminator::lang::{source::Source, variables::EvaluatedLights};
use illuminator::scene::Scene;
use illuminator::trace::{Budget, View, trace};
use illuminator::world::{Assets, World};
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The side of the cube that the balls fill.
const SIDE: f64 = 10.0;
/// Times are the least of this many rounds.
const ROUNDS: usize = 5;

/// Balls at random places. Eight times as many are half as large, so they always fill the same share of the cube. One
/// in ten is of glass, the others are matte.
fn scene(balls: usize) -> String {
    let reach = 0.35 * SIDE / (balls as f64).cbrt();
    let mut text = "bodies;\n".to_owned();
    for ball in 0..balls {
        let number = |index: usize| scattered(8 * ball + index);
        let place = |index: usize| SIDE * (number(index) - 0.5);
        let look = if number(4) < 0.1 { "refractive_index 1.5" } else { "opaque, matte" };
        let (x, y, z, radius) = (place(0), place(1), place(2), reach * (0.5 + 0.5 * number(3)));
        writeln!(text, "b{ball}: sphere, center <{x:.5}, {y:.5}, {z:.5}>, radius {radius:.6}, {look};")
            .unwrap_or_else(|error| panic!("{error}"));
    }
    text + "lights; key: point, <20, 30, 25>; fill: point, <-25, 10, 20>;
            camera; position <0, 3, 18>; gaze <0, -0.16, -1>; up <0, 1, 0>; fov 35;"
}

/// Prints a line for a scene of this many balls, traced on one thread.
pub(crate) fn measure(balls: usize) {
    let text = scene(balls);
    let start = Instant::now();
    let parsed = Scene::parse(&Source::new("balls", text)).unwrap_or_else(|errors| panic!("{errors:?}")).0;
    let read = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let world = Arc::new(World::new(parsed, &Assets::NONE).unwrap_or_else(|error| panic!("{error}")));
    let built = start.elapsed().as_secs_f64();
    let view = View::new(320, 180).unwrap_or_else(|error| panic!("{error}"));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap_or_else(|error| panic!("{error}"));
    let never = AtomicBool::new(false);
    let round = || {
        let start = Instant::now();
        let traced = trace(&world, &view, EvaluatedLights::Reaching, &Budget::UNLIMITED, &|_| (), &never);
        let counts = traced.unwrap_or_else(|error| panic!("{error}")).counts();
        (start.elapsed().as_secs_f64(), counts)
    };
    let rounds: Vec<_> = (0..ROUNDS).map(|_| pool.install(round)).collect();
    let time = rounds.iter().map(|(time, _)| *time).fold(f64::INFINITY, f64::min);
    let counts = rounds[0].1;
    println!(
        "{balls:>7} balls: {:6.0} ns a ray of {} that hit and {} that miss; scene read in {:.1} ms, made ready in {:.1} ms",
        time / (counts.hits + counts.misses) as f64 * 1e9,
        counts.hits,
        counts.misses,
        1e3 * read,
        1e3 * built
    );
}
