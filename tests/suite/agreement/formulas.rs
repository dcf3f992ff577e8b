//! Random well-typed formulas, parameter values and scenes: compiled code must agree with the interpreter.

use crate::agreement::{backends, only_draws_in_full};
use illuminator::backends::interpreter::Interpreted;
use illuminator::backends::verify::verify;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Backend, Evaluator};
use illuminator::formula::Formula;
use illuminator::formula::layout::Layout;
use illuminator::lang::builtins::{Form, Operation};
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::{Owner, Variable};
use illuminator::scene::Scene;
use illuminator::trace::View;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Glass over a floor, with a mirror behind, and two lights. Rays reflect, refract, are shadowed and leave the scene.
const SCENE: &str = "
    bodies;
    floor: rectangle, <-4,0,-4>, <4,0,-4>, <4,0,4>;
    glass: sphere, center <-0.6,1,0>, radius 1;
    bubble: sphere, center <-0.6,1,0>, radius 0.6, refractive_index 0.667;
    mirror: rectangle, <0.2,2.5,-2>, <3,2.5,-1.5>, <3,0,-1.5>, opaque;
    matte: sphere, center <1.4,0.5,0.8>, radius 0.5, matte;
    lights;
    key: point, <4,6,5>;
    fill: point, <-5,3,2>;
    camera;
    position <0,1.6,6>; gaze <0,-0.1,-1>; up <0,1,0>; fov 45;";

/// The last of the cells of sixteen pixels, which drags draw, is not full.
pub(super) const SIZE: (u32, u32) = (15, 13);

/// An operand as text. Everything that binds less tightly than a call is in parentheses.
fn leaf(ty: Type) -> BoxedStrategy<String> {
    let variables = |ty: Type| -> Vec<String> {
        // `v` is a parameter of these formulas.
        let usable = |variable: &&Variable| !variable.is_of_crossing() && **variable != Variable::SurfaceV;
        let known = Variable::written().filter(usable).filter(|variable| variable.ty() == ty);
        known.map(|variable| variable.name().to_owned()).collect()
    };
    let number = prop_oneof![
        6 => (0..300u32).prop_map(|n| format!("{}", f64::from(n) / 100.0)),
        1 => select(vec!["0", "1", "2", "3", "0.5", "1e-3", "1e4", "1e-20", "1e20", "1e30", "1e-39"]).prop_map(str::to_owned),
    ];
    match ty {
        Type::Scalar => prop_oneof![
            3 => number,
            3 => select(variables(Type::Scalar)),
            4 => select(vec!["p", "q", "g", "l", "kr", "ki", "ka"]).prop_map(str::to_owned),
            1 => Just("MS".to_owned()),
        ]
        .boxed(),
        Type::Vector => prop_oneof![
            4 => select(variables(Type::Vector)),
            3 => select(vec!["Cd", "IL", "v"]).prop_map(str::to_owned),
            1 => Just("MV".to_owned()),
        ]
        .boxed(),
        Type::Truth => select(vec!["(p < q)", "(alpha >= beta)", "(g != 0)"]).prop_map(str::to_owned).boxed(),
        Type::Texture => Just("wood".to_owned()).boxed(),
    }
}

/// A random expression of a type, from the table of operations.
pub(super) fn expression(ty: Type, depth: u32, macros: bool) -> BoxedStrategy<String> {
    let leaves = leaf(ty).prop_filter("macros do not use macros here", move |text| macros || !text.starts_with('M')).boxed();
    if depth == 0 || ty == Type::Texture {
        return leaves;
    }
    // Without a file, a measured material is 0. `measured` has formulas with files.
    let is_tried = |operation: &Operation| operation.result() == ty && operation.form() != Form::Measured;
    let operations: Vec<Operation> = Operation::ALL.iter().copied().filter(is_tried).collect();
    let applied = select(operations).prop_flat_map(move |operation| {
        let operands: Vec<BoxedStrategy<String>> =
            operation.operands().iter().map(|operand| expression(*operand, depth - 1, macros)).collect();
        operands.prop_map(move |operands| match operation.form() {
            Form::Prefix(mark) => format!("({}{})", mark.spelling(), operands[0]),
            Form::Infix(mark) => format!("({} {} {})", operands[0], mark.spelling(), operands[1]),
            Form::UnitDot => format!("({} . {})", operands[0], operands[1]),
            Form::Function(name) => format!("{name}({})", operands.join(", ")),
            Form::Constant(name) => name.to_owned(),
            Form::Texture => format!("{}({}, {})", operands[0], operands[1], operands[2]),
            Form::Measured => format!("measured(\"none\", {}, {})", operands[1], operands[2]),
            Form::Vector => format!("<{}>", operands.join(", ")),
            Form::Conditional => format!("if({})", operands.join(", ")),
        })
    });
    if ty != Type::Vector {
        return prop_oneof![1 => leaves, 4 => applied].boxed();
    }
    // A function of numbers by components: at least one of its operands is a vector.
    let functions = Operation::ALL.iter().copied().filter(|operation| operation.works_by_components());
    let functions: Vec<Operation> = functions.filter(|operation| matches!(operation.form(), Form::Function(_))).collect();
    let by_components = (select(functions), any::<u8>()).prop_flat_map(move |(operation, vectors)| {
        let is_vector = |index: usize| index == 0 || vectors >> index & 1 == 1;
        let ty = |index: usize| if is_vector(index) { Type::Vector } else { Type::Scalar };
        let count = operation.operands().len();
        let operands: Vec<BoxedStrategy<String>> = (0..count).map(|index| expression(ty(index), depth - 1, macros)).collect();
        operands.prop_map(move |operands| format!("{}({})", operation.form().spelling(), operands.join(", ")))
    });
    prop_oneof![1 => leaves, 4 => applied, 2 => by_components].boxed()
}

/// A number for a parameter: mostly ordinary, sometimes extreme. Colours whose sums overflow are left out, because the
/// backends add the terms of a pixel in different orders.
pub(super) fn number() -> BoxedStrategy<f32> {
    prop_oneof![
        6 => 0.0..1.0_f32,
        2 => -10.0..100.0_f32,
        1 => select(vec![0.0, -0.0, 1.0, -1.0, 2.0, 0.5, 1e-40, -1e-39, f32::MIN_POSITIVE, 1e-20, 1e20, 1e30, -1e30, 1e5]),
    ]
    .boxed()
}

static EXCUSED: AtomicUsize = AtomicUsize::new(0);
static COMPARED: AtomicUsize = AtomicUsize::new(0);

/// A formula on the scene by both backends, and numbers for its parameters.
pub(super) struct Case {
    pub(super) text: String,
    pub(super) subject: Subject,
    pub(super) formula: Arc<Formula>,
    pub(super) layout: Layout,
    /// One for each backend under test.
    pub(super) evaluators: Vec<Arc<dyn Evaluator>>,
    pub(super) interpreted: Interpreted,
    pub(super) memory: Vec<f32>,
}

impl Case {
    /// A formula of two macros and a result. Some of its parameters have bounds.
    pub(super) fn new(parts: [&str; 3], numbers: &[f32]) -> Result<Self, TestCaseError> {
        Self::of(Self::text(parts), numbers, &backends())
    }

    /// A formula of two macros and a result. Some of its parameters have bounds.
    pub(super) fn text([scalar, vector, result]: [&str; 3]) -> String {
        format!(
            "global; g: scalar, constraint -1..50; body_specific; p: scalar; q: scalar, constraint 0..1; v: vector; wood: texture; \
             light_specific; l: scalar; formula; MS = {scalar}; MV = {vector}; = {result};"
        )
    }

    /// The nearest value that the number with this index can take.
    pub(super) fn clamped(&self, index: usize, value: f32) -> f32 {
        let holds = |parameter: &&illuminator::formula::Parameter| {
            let (owner, _, slot) = self.layout.owner_of(index).expect("an owner");
            let first = parameter.slot as usize;
            parameter.owner == owner && (first..first + parameter.ty.slots()).contains(&slot)
        };
        self.formula.parameters.iter().find(holds).expect("a parameter").clamp(value).0
    }

    /// A formula on the scene by these backends.
    pub(super) fn of(text: String, numbers: &[f32], backends: &[Arc<dyn Backend>]) -> Result<Self, TestCaseError> {
        Self::in_pass(text, numbers, backends, SCENE, 0)
    }

    /// A formula on a scene in one pass, by these backends.
    pub(super) fn in_pass(
        text: String,
        numbers: &[f32],
        backends: &[Arc<dyn Backend>],
        scene: &str,
        pass: u32,
    ) -> Result<Self, TestCaseError> {
        // Numbers from 0.5 to 1.5 are then those of a texture.
        assert_eq!(crate::agreement::textures::number(), 1.0);
        let source = Source::new("random", text.clone());
        let (formula, _) = Formula::parse(&source).map_err(|errors| TestCaseError::fail(errors.located(&source).to_string()))?;
        let (scene, _) = Scene::parse(&Source::new("scene", scene)).map_err(|_| TestCaseError::fail("the scene is right"))?;
        let failed = |error: &dyn std::fmt::Display| TestCaseError::fail(error.to_string());
        let view = View::new(SIZE.0, SIZE.1).and_then(|view| view.with_depth(4)).map_err(|error| failed(&error))?.with_pass(pass);
        let subject = Subject::new(formula, scene, &illuminator::world::Assets::NONE, view).expect("no meshes");
        let evaluator = |backend: &Arc<dyn Backend>| {
            Engine::new(Arc::clone(backend)).evaluator(&subject, &[], &Task::UNWATCHED).map_err(|error| failed(&error))
        };
        let evaluators = backends.iter().map(evaluator).collect::<Result<_, _>>()?;
        let Subject { formula, world, .. } = subject.clone();
        let scene = world.scene();
        let interpreted = Interpreted::new(&formula, &world, view).map_err(|error| failed(&error))?;
        let layout = Layout::new(&formula, scene.bodies.len(), scene.lights.len());
        let mut memory: Vec<f32> = (0..layout.len()).map(|index| numbers[index % numbers.len()]).collect();
        for parameter in &formula.parameters {
            for owner in 0..layout.owners(parameter.owner) {
                let first = layout.index(parameter, owner);
                memory[first..first + parameter.ty.slots()].iter_mut().for_each(|number| *number = parameter.clamp(*number).0);
            }
        }
        Ok(Self { text, subject, formula, layout, evaluators, interpreted, memory })
    }
}

/// The parts of a formula, and numbers.
pub(super) fn ingredients() -> impl Strategy<Value = (String, String, String, Vec<f32>)> {
    (
        expression(Type::Scalar, 2, false),
        expression(Type::Vector, 2, false),
        expression(Type::Vector, 4, true),
        proptest::collection::vec(number(), 61),
    )
}

/// Every run has the same formulas, so that a failure is caused by a change of the code. `PROPTEST_CASES=20000` tries
/// more of them.
pub(super) fn runner(cases: u32) -> TestRunner {
    // A device in software takes its time.
    let cases = if only_draws_in_full() { cases / 5 } else { cases };
    let wanted = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    let config = ProptestConfig {
        cases: wanted.unwrap_or(cases),
        failure_persistence: None,
        max_shrink_iters: 2000,
        ..ProptestConfig::default()
    };
    match wanted {
        None => TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha)),
        Some(_) => TestRunner::new(config),
    }
}

pub(super) fn check(case: &Case) -> Result<(), TestCaseError> {
    for (backend, evaluator) in case.evaluators.iter().enumerate() {
        let found = verify(&**evaluator, &case.interpreted, &case.memory);
        COMPARED.fetch_add(found.components, Ordering::Relaxed);
        EXCUSED.fetch_add(found.excused, Ordering::Relaxed);
        prop_assert_eq!(found.failed, 0, "backend {}: {}\n{:?}", backend, case.text, found);
    }
    Ok(())
}

#[test]
pub(super) fn random_formulas_agree() {
    let outcome = runner(600)
        .run(&ingredients(), |(scalar, vector, result, numbers)| check(&Case::new([&scalar, &vector, &result], &numbers)?));
    let (excused, compared) = (EXCUSED.load(Ordering::Relaxed), COMPARED.load(Ordering::Relaxed));
    println!("{excused} of {compared} components excused ({:.3} %)", 100.0 * excused as f64 / compared.max(1) as f64);
    if let Err(error) = outcome {
        panic!("{error}");
    }
    assert!(excused * 20 < compared, "excuses must stay rare, or the comparison says nothing");
}

#[test]
pub(super) fn powers_of_cosines_just_below_one_are_exact() {
    // 0.99999994 is the largest number below 1. Its power by −1e9 is 7.7e25.
    for (exponent, least) in [(-1e9, 1e25), (-3e8, 1e7), (1e9, 0.0), (-0.0, 0.1)] {
        for power in ["(0.99999994*gety(N))^p", "(0.99999994*gety(N)*gety(N))^p", "(0.99999994*max(0, gety(N)))^p"] {
            let mut case = Case::new(["1", "N", &format!("IL*({power})")], &[0.5]).expect("a formula");
            let parameter = case.formula.parameter_named("p").map(|id| case.formula.parameter(id)).expect("a parameter");
            for body in 0..case.layout.owners(Owner::Body) {
                case.memory[case.layout.index(parameter, body)] = exponent;
            }
            for evaluator in &case.evaluators {
                let found = verify(&**evaluator, &case.interpreted, &case.memory);
                assert_eq!((found.failed, found.excused), (0, 0), "{power}, {exponent}: {found:?}");
                let linear = evaluator.frame(&case.memory).linear;
                let large =
                    linear.iter().flatten().filter(|component| component.is_finite()).any(|component| *component >= least);
                assert!(large, "{power}, {exponent}: the power is {least} or more on the floor");
            }
        }
    }
}
