//! Compares the frames of drags with full frames, for every slider of the built-in sessions, and of three models whose
//! kernels are expensive on two of their scenes: a rough dielectric (GGX), a thin film and Hapke's regolith. The scene
//! `wall` is the worst case for every model: one body under one light fills the picture.
//!
//! `cargo bench --bench drags` takes about ten minutes. A filter selects cases: `cargo bench --bench drags -- glass`.
//! `ILLUMINATOR_LANES=8` or `4` limits the vectors. Everything runs on one thread. The two frames are drawn in turns
//! from the same numbers, which change from round to round.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

use illuminator::backends::DEFAULT;
use illuminator::engine::{Engine, Task};
use illuminator::evaluate::{Evaluator, Framebuffer};
use illuminator::formula::ParameterId;
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics};
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::picture::Transfer;
use illuminator::workspace::project::{Listener, Project, Request, SessionText};
use illuminator::workspace::{FileKind, Location, OwnerId, presets};
use rayon::ThreadPoolBuilder;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// The size of the pictures.
const SIZE: [u32; 2] = [640, 360];
/// How often each slider is moved, at most and at least. In between, frames are drawn for [`SECONDS`].
const ROUNDS: usize = 25;
const LEAST_ROUNDS: usize = 3;
const SECONDS: f64 = 0.5;
/// The memory that a drag may keep, in bytes.
const BUDGET: usize = 1 << 30;
/// The slowest sliders of a case are listed.
const LISTED: usize = 4;
/// Models that are not built in, in this folder.
const MODELS: [&str; 2] = ["ggx", "thin-film"];
/// The sessions on whose scenes expensive models are measured too.
const SESSIONS: [&str; 2] = ["studio", "glass"];

/// What is opened.
struct Case {
    name: String,
    session: Option<String>,
    formula: Option<Location>,
    scene: Option<Location>,
}

impl Case {
    /// Every case: the built-in sessions, the models on some of them, and all models on the wall.
    fn all() -> Vec<Case> {
        let file = |name: &str| Location::new(Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/drags").join(name));
        let own = MODELS.map(|name| (name, file(&format!("{name}.formula"))));
        let built_in = |name: &'static str| (name, Location::Preset(name.to_owned()));
        let session = |name: &str| Case { name: name.to_owned(), session: Some(name.to_owned()), formula: None, scene: None };
        let mut all: Vec<Case> = presets::names(FileKind::Session).map(session).collect();
        for (name, formula) in own.iter().cloned().chain([built_in("hapke")]) {
            let on = |session: &str| Case {
                name: format!("{name} on {session}"),
                session: Some(session.to_owned()),
                formula: Some(formula.clone()),
                scene: None,
            };
            all.extend(SESSIONS.map(on));
        }
        all.extend(own.into_iter().chain(presets::names(FileKind::Formula).map(built_in)).map(|(name, formula)| Case {
            name: format!("{name} on wall"),
            session: None,
            formula: Some(formula),
            scene: Some(file("wall.scene")),
        }));
        all
    }
}

/// How the frames of a slider compare with full frames.
struct Ratio {
    slider: String,
    method: &'static str,
    /// The quotient of the medians, and that of the best times.
    median: f64,
    best: f64,
}

/// Built-in files have no mistakes; warnings do not matter here.
struct Silent;

impl Listener for Silent {
    fn diagnostics(&mut self, _: &Diagnostics, _: &Source) {}

    fn message(&mut self, _: Diagnostic) {}

    fn remark(&mut self, _: &str) {}
}

fn main() {
    // `cargo test --benches` only builds it.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let filters: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("drag / full: quotients of medians, and of best times in brackets");
    for case in Case::all() {
        let name = &case.name;
        if !filters.is_empty() && !filters.iter().any(|filter| name.contains(filter)) {
            continue;
        }
        let mut ratios = pool.install(|| measure(&case));
        ratios.sort_by(|a, b| b.median.total_cmp(&a.median));
        let middle = ratios.get(ratios.len() / 2).map_or(0.0, |ratio| ratio.median);
        println!("{name}: {} sliders, half of them below {middle:.2}; the slowest:", ratios.len());
        for Ratio { slider, method, median, best } in ratios.iter().take(LISTED) {
            println!("    {slider:<20} {method:<12} {median:.2} ({best:.2})");
        }
    }
}

/// Opens a case and measures every slider that can be moved and that some pixel shows.
fn measure(case: &Case) -> Vec<Ratio> {
    let request = Request {
        session: case.session.clone().map(|name| SessionText::At(Location::Preset(name))),
        formula: case.formula.clone(),
        scene: case.scene.clone(),
        picture: Some(&|picture| picture.size = SIZE),
        ..Request::default()
    };
    let project = Project::open(&request, &mut Silent).expect("a sound session");
    let engine = Engine::new(DEFAULT.make()).with_memory(u64::MAX);
    let evaluator = engine.evaluator(&project.subject, &[], &Task::UNWATCHED).expect("tracing that nobody cancels");
    let mut found = Vec::new();
    let all = project.values.iter().map(|(owner, id, _)| (owner, id));
    for (owner, id) in all.filter(|(owner, id)| project.values.lock_of(*owner, *id).is_none()) {
        let components = match project.values.table().parameter(id).ty {
            Type::Vector => &[None, Some(0)][..],
            Type::Scalar | Type::Truth | Type::Texture => &[None],
        };
        found.extend(components.iter().filter_map(|component| ratio(&project, &evaluator, owner, id, *component)));
    }
    found
}

/// Drags one slider, or one component of a colour. `None`: no pixel shows it.
fn ratio(
    project: &Project,
    evaluator: &Arc<dyn Evaluator>,
    owner: OwnerId,
    id: ParameterId,
    component: Option<usize>,
) -> Option<Ratio> {
    let mut values = project.values.clone();
    let mut moved = values.moved_indices(owner, id);
    if let (Some(component), Some(first)) = (component, moved.first()) {
        moved = vec![first + component];
    }
    let mut drag = Arc::clone(evaluator).drag(&moved, values.numbers(), BUDGET, None).expect("kernels for a slider");
    while !drag.prepare() {}
    if drag.pixels() == 0 {
        return None;
    }
    let [mut dragged, mut drawn, mut first] = [(); 3].map(|()| Framebuffer::black(SIZE[0], SIZE[1], Transfer::Linear));
    drag.frame(values.numbers(), &mut dragged);
    let [low, high] = values.range_of(owner, id).unwrap_or([0.0, 1.0]);
    let [mut frames, mut full] = [Vec::new(), Vec::new()];
    let begin = Instant::now();
    for round in 0..ROUNDS {
        if round >= LEAST_ROUNDS && begin.elapsed().as_secs_f64() > SECONDS {
            break;
        }
        let target = low + [0.25, 0.6, 0.4, 0.75][round % 4] * (high - low);
        let mut value = [target; 3];
        if let Some(component) = component {
            value.copy_from_slice(values.get(owner, id));
            value[component] = target;
        }
        values.move_to(owner, id, value);
        let start = Instant::now();
        drag.frame(values.numbers(), &mut dragged);
        frames.push(start.elapsed().as_secs_f64());
        // A formula may choose otherwise with these numbers. Then the first full frame computes columns. The second one
        // is up to a tenth faster even where it does not.
        evaluator.draw(values.numbers(), &mut first);
        let start = Instant::now();
        evaluator.draw(values.numbers(), &mut drawn);
        full.push(start.elapsed().as_secs_f64());
    }
    [&mut frames, &mut full].into_iter().for_each(|times| times.sort_by(f64::total_cmp));
    let label = values.table().label(owner, id);
    let slider = component.map_or_else(|| label.clone(), |_| format!("{label}.r"));
    let (median, best) = (frames[frames.len() / 2] / full[full.len() / 2], frames[0] / full[0]);
    Some(Ratio { slider, method: drag.method().name(), median, best })
}
