//! What the benchmarks share: the built-in session `glass` with one of two models, traced and compiled, and frames
//! between which parameters really change. Nothing is measured here.

use illuminator::backends::REFERENCE;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Drag, Evaluator, Framebuffer};
use illuminator::files::Readable;
use illuminator::formula::{Formula, ParameterId};
use illuminator::lang::variables::Owner;
use illuminator::picture::Transfer;
use illuminator::scene::Scene;
use illuminator::trace::{Hits, View};
use illuminator::workspace::FileKind;
use illuminator::workspace::Location;
use illuminator::workspace::{OwnerId, Session, Values};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::fmt;
use std::sync::Arc;

/// The built-in session that is measured.
pub(crate) const SESSION: &str = "preset:glass";
/// The memory that a drag may keep, in bytes, as in `illuminator bench`.
pub(crate) const DRAG_BUDGET: usize = 1 << 30;
/// By how much the peers change a number from one frame to the next; see `benches/peer/README.md`.
const STEP: f32 = 1e-3;

/// The models that are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Model {
    Phong,
    Strauss,
}

impl Model {
    pub(crate) const ALL: [Model; 2] = [Model::Phong, Model::Strauss];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Model::Phong => "phong",
            Model::Strauss => "strauss",
        }
    }

    /// The built-in formula.
    pub(crate) fn location(self) -> Location {
        Location::Preset(self.name().to_owned())
    }

    /// A slider of which the picture is a polynomial.
    pub(crate) fn weight(self) -> Slider {
        Slider { owner: "floor", parameter: if self == Model::Phong { "kd" } else { "m" }, component: None }
    }

    /// A slider on which an exponent depends.
    pub(crate) fn exponent(self) -> Slider {
        Slider { owner: "floor", parameter: if self == Model::Phong { "h" } else { "s" }, component: None }
    }
}

/// A slider: a value, or one component of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slider {
    owner: &'static str,
    parameter: &'static str,
    component: Option<usize>,
}

/// A slider that changes one colour channel.
pub(crate) const RED: Slider = Slider { owner: "floor", parameter: "Cd", component: Some(0) };

impl fmt::Display for Slider {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let component = self.component.map_or("", |component| [".r", ".g", ".b"][component]);
        write!(f, "{}.{}{component}", self.owner, self.parameter)
    }
}

/// The session with a model, before anything is traced or compiled.
pub(crate) struct Script {
    pub(crate) subject: Subject,
    pub(crate) values: Values,
}

impl Script {
    /// Reads the session. Its values are kept where the model has such parameters.
    pub(crate) fn new(model: Model, [width, height]: [u32; 2]) -> Self {
        let read = |location: &Location, kind| location.read(kind, Readable::Regular).expect("a built-in file");
        let session = read(&Location::new(SESSION), FileKind::Session);
        let (session, _) = Session::parse(&session).expect("a sound session");
        let (scene, _) = Scene::parse(&read(&session.scene, FileKind::Scene)).expect("a sound scene");
        let (formula, _) = Formula::parse(&read(&model.location(), FileKind::Formula)).expect("a sound formula");
        let kept = session.assignments(Values::defaults(&formula, &scene).table()).0;
        let (values, _) = Values::carried_over(&formula, &scene, &kept, &[]);
        let picture = session.picture;
        let view = View::new(width, height)
            .and_then(|view| view.with_depth(picture.depth))
            .and_then(|view| view.with_default_index(picture.default_index))
            .map(|view| view.with_shadows(picture.shadows))
            .expect("settings within their ranges");
        Self { subject: Subject::new(formula, scene, &illuminator::world::Assets::NONE, view).expect("no meshes"), values }
    }

    /// An engine that has compiled the formula.
    pub(crate) fn compile(&self) -> Engine {
        let engine = Engine::default().with_memory(u64::MAX);
        engine.compile(&self.subject).expect("a formula that can be compiled");
        engine
    }

    /// Traces the scene, on all threads of the current pool. The hits do not depend on the model.
    pub(crate) fn trace(&self) -> Arc<Hits> {
        let engine = Engine::new(REFERENCE.make()).with_memory(u64::MAX);
        engine.trace(&self.subject, &Task::UNWATCHED).expect("tracing that nobody cancels")
    }

    /// The reference interpreter.
    pub(crate) fn interpreter(&self) -> Arc<dyn Evaluator> {
        let engine = Engine::new(REFERENCE.make()).with_memory(u64::MAX);
        engine.evaluator(&self.subject, &[], &Task::UNWATCHED).expect("a formula with bytecode")
    }

    /// Two arrays of parameter numbers. They differ in every number of a body that the peers change.
    pub(crate) fn bodies_moved(&self) -> [Vec<f32>; 2] {
        let numbers = self.values.numbers().to_vec();
        let mut moved = numbers.clone();
        for name in ["kd", "h", "s", "m"] {
            for owner in self.values.table().owners().of_kind(Owner::Body) {
                let id = self.values.table().parameter_named(name);
                let Some(indices) = id.and_then(|id| self.values.table().indices(owner, id)) else { continue };
                for number in &mut moved[indices] {
                    *number += if name == "s" && *number >= 0.5 { -STEP } else { STEP };
                }
            }
        }
        [numbers, moved]
    }

    /// The positions of the numbers that a slider changes, and two arrays of parameter numbers between which it changes
    /// them.
    fn slider_moved(&self, slider: Slider) -> (Vec<usize>, [Vec<f32>; 2]) {
        let (owner, id) = self.find(slider);
        let mut indices = self.values.moved_indices(owner, id);
        if let Some(component) = slider.component {
            indices = vec![indices[component]];
        }
        let [low, high] = self.values.range_of(owner, id).unwrap_or([0.0, 1.0]);
        let turns = [0.25, 0.75].map(|share| {
            let mut value = [low + share * (high - low); 3];
            if let Some(component) = slider.component {
                let target = value[component];
                value.copy_from_slice(self.values.get(owner, id));
                value[component] = target;
            }
            let mut values = self.values.clone();
            values.move_to(owner, id, value);
            values.numbers().to_vec()
        });
        (indices, turns)
    }

    fn find(&self, slider: Slider) -> (OwnerId, ParameterId) {
        let table = self.values.table();
        let owner = table.owners().named(slider.owner).expect("a body of the scene");
        (owner, table.parameter_named(slider.parameter).expect("a parameter of the model"))
    }
}

/// The session with a model, traced and compiled.
pub(crate) struct Stage {
    pub(crate) script: Script,
    pub(crate) compiled: Arc<dyn Evaluator>,
}

impl Stage {
    pub(crate) fn new(script: Script, hits: &Arc<Hits>) -> Self {
        let compiled = script.compile().prepare(&script.subject, hits, &[]).expect("hits of this scene");
        Self { script, compiled }
    }

    pub(crate) fn framebuffer(&self) -> Framebuffer {
        let view = self.script.subject.view;
        Framebuffer::black(view.width(), view.height(), Transfer::Linear)
    }
}

/// Gives one of two arrays of numbers, then the other, and so on.
pub(crate) struct Turns {
    turns: [Vec<f32>; 2],
    next: usize,
}

impl Turns {
    pub(crate) fn new(turns: [Vec<f32>; 2]) -> Self {
        assert_ne!(turns[0], turns[1], "the arrays differ");
        Self { turns, next: 0 }
    }

    pub(crate) fn turn(&mut self) -> &[f32] {
        self.next = 1 - self.next;
        &self.turns[self.next]
    }
}

/// Full evaluations by compiled code; the numbers of all bodies change from one to the next.
pub(crate) struct Full {
    compiled: Arc<dyn Evaluator>,
    turns: Turns,
    framebuffer: Framebuffer,
}

impl Full {
    pub(crate) fn new(stage: &Stage) -> Self {
        let turns = Turns::new(stage.script.bodies_moved());
        Self { compiled: Arc::clone(&stage.compiled), turns, framebuffer: stage.framebuffer() }
    }

    pub(crate) fn frame(&mut self) {
        self.compiled.draw(self.turns.turn(), &mut self.framebuffer);
    }
}

/// Frames while a slider is dragged back and forth, with everything prepared.
pub(crate) struct Dragged {
    pub(crate) drag: Box<dyn Drag>,
    turns: Turns,
    framebuffer: Framebuffer,
}

impl Dragged {
    /// With a budget of 0 nothing is kept, and every tile that the slider affects is evaluated in full.
    pub(crate) fn new(stage: &Stage, slider: Slider, budget: usize) -> Self {
        let (indices, turns) = stage.script.slider_moved(slider);
        let drag = Arc::clone(&stage.compiled).drag(&indices, &turns[0], budget, None).expect("kernels for a slider");
        let mut dragged = Self { drag, turns: Turns::new(turns), framebuffer: stage.framebuffer() };
        while !dragged.drag.prepare() {}
        // The first frame draws everything.
        dragged.frame();
        dragged
    }

    pub(crate) fn frame(&mut self) {
        self.drag.frame(self.turns.turn(), &mut self.framebuffer);
    }
}

/// Thread pools: one with one thread, one with a thread for each processor.
pub(crate) fn pools() -> Vec<ThreadPool> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut counts = vec![1, all];
    counts.dedup();
    counts.into_iter().map(|count| ThreadPoolBuilder::new().num_threads(count).build().expect("threads")).collect()
}
