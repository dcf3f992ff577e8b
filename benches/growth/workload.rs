//! Generates a scene and a formula, and measures the cost of each stage.

use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Drag, Evaluator, Framebuffer};
use illuminator::formula::Formula;
use illuminator::lang::source::Source;
use illuminator::lang::variables::Owner;
use illuminator::picture::Transfer;
use illuminator::plan::Method;
use illuminator::scene::Scene;
use illuminator::trace::{Counts, LINE_HITS, View};
use illuminator::workspace::{OwnerId, Values};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The time after which work is not repeated in a round.
const PATIENCE: Duration = Duration::from_millis(40);
/// The most repetitions in a round.
const MOST_TIMES: usize = 40;
/// The memory that a drag may keep, in bytes, as in `illuminator bench`.
const DRAG_BUDGET: usize = 1 << 30;
/// The length of the floor that the spheres stand on in rows and columns.
const FLOOR: f64 = 9.0;

/// The amounts of everything.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Workload {
    pub(crate) size: [u32; 2],
    pub(crate) lights: u32,
    /// The number of rows of spheres, and of columns.
    pub(crate) spheres_a_side: u32,
    pub(crate) depth: u32,
    /// The number of highlights in the formula.
    pub(crate) terms: u32,
    /// The number of sines in the formula, each a static value of its own.
    pub(crate) sines: u32,
}

/// The contents of the picture, and the milliseconds of each stage.
pub(crate) struct Cost {
    pub(crate) counts: Counts,
    pub(crate) spans: usize,
    /// The part of the lanes that hold a hit, 0 to 1.
    pub(crate) filled: f64,
    pub(crate) bytes_per_pixel: f64,
    pub(crate) full: f64,
    pub(crate) trace: f64,
    pub(crate) compile: f64,
    /// A frame while `floor.kd` is dragged, with everything prepared.
    pub(crate) drag: f64,
    pub(crate) method: Method,
}

/// Everything prepared, so that stages can be measured repeatedly.
pub(crate) struct Stage {
    engine: Engine,
    subject: Subject,
    compiled: Arc<dyn Evaluator>,
    dragged: Box<dyn Drag>,
    /// Two arrays of numbers between which all bodies change, and two between which the slider does.
    bodies: [Vec<f32>; 2],
    slider: [Vec<f32>; 2],
    framebuffer: Framebuffer,
    pub(crate) cost: Cost,
}

impl Workload {
    /// The amounts of whatever does not grow.
    pub(crate) const TYPICAL: Workload =
        Workload { size: [640, 360], lights: 3, spheres_a_side: 3, depth: 5, terms: 1, sines: 0 };

    /// Phong's model with several highlights, each with its own exponent, and sines.
    fn formula(self) -> String {
        let mut text = "body_specific;\n kd: scalar, constraint 0..1, default 0.5, slider;\n".to_owned();
        text += " ks: scalar, constraint 0..1, default 0.4, slider;\n h: scalar, constraint 1..500, default 60, slider;\n";
        text += "formula;\n = kd*IL*Cd*max(0, N.L)";
        for term in 0..self.terms {
            add(&mut text, format_args!("\n + ks*IL*max(0, R.V)^(h + {term})/{}", self.terms));
        }
        for sine in 1..=self.sines {
            add(&mut text, format_args!("\n + sin({sine}*alpha)*IL/{}", self.sines));
        }
        text + ";\n"
    }

    /// Spheres in rows and columns, alternately glass and mirrors, on a floor under a circle of lights. More spheres
    /// are smaller.
    fn scene(self) -> String {
        let mut text = "bodies;\n floor: rectangle, <-6,0,-6>, <6,0,-6>, <6,0,6>, opaque;\n".to_owned();
        let side = self.spheres_a_side;
        let cell = FLOOR / f64::from(side);
        let coordinate = |index: u32| (f64::from(index) + 0.5) * cell - FLOOR / 2.0;
        for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
            let (x, z, radius) = (coordinate(column), coordinate(row), 0.3 * cell);
            let kind = if is_glass(row, column) { "refractive_index 1.5" } else { "opaque" };
            add(
                &mut text,
                format_args!(" s{row}_{column}: sphere, center <{x:.4},{radius:.4},{z:.4}>, radius {radius:.4}, {kind};\n"),
            );
        }
        text += "lights;\n";
        for light in 0..self.lights {
            let (z, x) = (TAU * (0.1 + f64::from(light) / f64::from(self.lights))).sin_cos();
            add(&mut text, format_args!(" l{light}: point, <{:.4},7,{:.4}>;\n", 7.0 * x, 7.0 * z));
        }
        text + "camera;\n position <0,5,11>; gaze <0,-0.42,-1>; up <0,1,0>; fov 40;\n"
    }

    /// Prepares everything, on the threads of the current pool.
    pub(crate) fn stage(self) -> Stage {
        let (formula, _) = Formula::parse(&Source::new("formula", self.formula())).expect("a sound formula");
        let (scene, _) = Scene::parse(&Source::new("scene", self.scene())).expect("a sound scene");
        let [width, height] = self.size;
        let view = View::new(width, height).and_then(|view| view.with_depth(self.depth)).expect("settings within their ranges");
        let numbers = self.numbers(&formula, &scene);
        let mut framebuffer = Framebuffer::black(width, height, Transfer::Linear);
        let bodies = moved(&numbers, &all_indices(&formula, &scene, &["kd", "h"]), [1.0, 0.999]);
        let indices = indices_of(&formula, &scene, "floor", "kd");
        let slider = moved(&numbers, &indices, [1.0, 0.5]);
        let (engine, subject) = (
            Engine::default().with_memory(u64::MAX),
            Subject::new(formula, scene, &illuminator::world::Assets::NONE, view).expect("no meshes"),
        );
        let hits = engine.trace(&subject, &Task::UNWATCHED).expect("tracing that nobody cancels");
        let compiled = engine.prepare(&subject, &hits, &[]).expect("a formula that can be compiled");
        let mut dragged = Arc::clone(&compiled).drag(&indices, &slider[0], DRAG_BUDGET, None).expect("kernels for a slider");
        while !dragged.prepare() {}
        // The first frame draws everything.
        dragged.frame(&slider[0], &mut framebuffer);
        let counts = hits.counts();
        let groups = || hits.tiles.iter().flat_map(|tile| &tile.groups);
        let lines: usize = groups().map(|group| group.hits.len().div_ceil(LINE_HITS)).sum();
        let cost = Cost {
            counts,
            spans: groups().map(|group| group.spans.len()).sum(),
            filled: groups().map(|group| group.hits.len()).sum::<usize>() as f64 / (lines * LINE_HITS) as f64,
            bytes_per_pixel: compiled.bytes() as f64 / f64::from(view.pixels()),
            full: f64::INFINITY,
            trace: f64::INFINITY,
            compile: f64::INFINITY,
            drag: f64::INFINITY,
            method: dragged.method(),
        };
        Stage { engine, subject, compiled, dragged, bodies, slider, framebuffer, cost }
    }

    /// Parameter numbers that give every ray a weight other than 0.
    fn numbers(self, formula: &Formula, scene: &Scene) -> Vec<f32> {
        let mut numbers = Values::defaults(formula, scene).numbers().to_vec();
        let mut set = |name: &str, parameter, value| numbers[indices_of(formula, scene, name, parameter)[0]] = value;
        set("floor", "kr", 0.2);
        for (row, column) in (0..self.spheres_a_side).flat_map(|row| (0..self.spheres_a_side).map(move |column| (row, column))) {
            let name = format!("s{row}_{column}");
            set(&name, "kr", 0.3);
            if is_glass(row, column) {
                set(&name, "kt", 0.6);
            }
        }
        numbers
    }
}

impl Stage {
    /// Measures every stage several times, on the threads of the current pool, and keeps the shortest times.
    pub(crate) fn measure(&mut self) {
        let Self { engine, subject, compiled, dragged, bodies, slider, framebuffer, cost } = self;
        let mut turn = 0;
        shorten(&mut cost.full, || {
            turn = 1 - turn;
            compiled.draw(&bodies[turn], framebuffer);
        });
        shorten(&mut cost.drag, || {
            turn = 1 - turn;
            dragged.frame(&slider[turn], framebuffer);
        });
        shorten(&mut cost.compile, || drop(black_box(Engine::default().compile(subject))));
        shorten(&mut cost.trace, || drop(black_box(engine.trace(subject, &Task::UNWATCHED))));
    }
}

fn is_glass(row: u32, column: u32) -> bool {
    (row + column).is_multiple_of(2)
}

fn add(text: &mut String, more: std::fmt::Arguments) {
    text.write_fmt(more).expect("writing to a string does not fail");
}

/// The indices of the numbers of an owner's parameter.
fn indices_of(formula: &Formula, scene: &Scene, owner: &str, parameter: &str) -> Vec<usize> {
    let values = Values::defaults(formula, scene);
    let owner: OwnerId = values.table().owners().named(owner).expect("an owner of the scene");
    let id = values.table().parameter_named(parameter).expect("a parameter of the model");
    values.table().indices(owner, id).expect("a parameter of this owner").collect()
}

/// The indices of the numbers of these parameters of all bodies.
fn all_indices(formula: &Formula, scene: &Scene, parameters: &[&str]) -> Vec<usize> {
    let values = Values::defaults(formula, scene);
    let table = values.table();
    let ids = parameters.iter().map(|name| table.parameter_named(name).expect("a parameter of the model"));
    let pairs = ids.flat_map(|id| table.owners().of_kind(Owner::Body).map(move |owner| (owner, id)));
    pairs.filter_map(|(owner, id)| table.indices(owner, id)).flatten().collect()
}

/// Two copies of the numbers, those with these indices multiplied by a factor.
fn moved(numbers: &[f32], indices: &[usize], factors: [f32; 2]) -> [Vec<f32>; 2] {
    factors.map(|factor| {
        let mut moved = numbers.to_vec();
        indices.iter().for_each(|index| moved[*index] *= factor);
        moved
    })
}

/// Repeats work and keeps the shortest time, in milliseconds.
fn shorten(best: &mut f64, mut work: impl FnMut()) {
    let begin = Instant::now();
    for _ in 0..MOST_TIMES {
        let start = Instant::now();
        work();
        *best = best.min(start.elapsed().as_secs_f64() * 1e3);
        if begin.elapsed() > PATIENCE {
            break;
        }
    }
}
