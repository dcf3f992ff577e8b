//! Every operator and function of the table with extreme inputs: compiled code against the reference meaning.

use illuminator::formula::Formula;
use illuminator::formula::graph::{Node, NodeId};
use illuminator::jit::{CompiledFormula, Kernel, Line, Splat, Width};
use illuminator::lang::builtins::{Form, Operation, Stack};
use illuminator::lang::scalars::{Floats, flush};
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Variable;
use illuminator::trace::ROUND_LINES;

/// Zeros, the ends of the normal numbers, subnormals (which count as 0), infinities, NaN, and numbers near special
/// points of functions.
const AWKWARD: [f32; 38] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    1.5,
    -2.0,
    2.0,
    3.0,
    -3.0,
    4.0,
    0.999_999_94,
    1.000_000_1,
    -0.999_999_94,
    std::f32::consts::PI,
    -std::f32::consts::FRAC_PI_2,
    std::f32::consts::FRAC_PI_4,
    10.0,
    -100.5,
    1e5,
    -1e5,
    8_388_608.5,
    16_777_216.0,
    -16_777_215.0,
    1e-10,
    1e10,
    -1e20,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-40,
    -1e-42,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    88.0,
];

/// The tolerance of a result in units in the last place: one for each rounding if the graph computes in another way
/// (powers), four for compiled elementary functions.
const UNITS: u32 = 5;

/// The kind of operands of an operation.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Operands {
    /// Parameters, so that the kernel of uniform values computes it.
    Uniforms,
    /// Variables times a parameter that is 1, so that the kernel of contributions computes it from columns, several
    /// lines at a time.
    Columns,
}

/// The components of variables that stand for the numbers, in order. No operation has more than seven.
const VARIABLES: [&str; 7] = ["getx(N)", "gety(N)", "getz(N)", "getx(V)", "gety(V)", "getz(V)", "getx(point)"];

/// A formula whose colour is the operation on parameters p0, p1, … or on variables. Also returns how many numbers it
/// reads.
pub(super) fn formula_of(operation: Operation, from: Operands) -> (Formula, usize) {
    let mut declarations = String::from("body_specific;\none: scalar;\n");
    let (mut operands, mut count) = (Vec::new(), 0);
    for ty in operation.operands() {
        let mut scalar = || {
            count += 1;
            if from == Operands::Columns {
                return format!("({}*one)", VARIABLES[count - 1]);
            }
            let name = format!("p{}", count - 1);
            declarations.push_str(&format!("{name}: scalar;\n"));
            name
        };
        operands.push(match ty {
            Type::Scalar => scalar(),
            Type::Vector => format!("<{}, {}, {}>", scalar(), scalar(), scalar()),
            // A truth value is true if its number is not 0.
            Type::Truth => format!("({} != 0)", scalar()),
            Type::Texture => panic!("textures are parameters"),
        });
    }
    let call = match operation.form() {
        Form::Prefix(mark) => format!("{}({})", mark.spelling(), operands[0]),
        Form::Infix(mark) => format!("({}) {} ({})", operands[0], mark.spelling(), operands[1]),
        // Of operands without unit length it is the other dot product, which has the same form.
        Form::UnitDot => format!("({}) . ({})", operands[0], operands[1]),
        Form::Function(name) => format!("{name}({})", operands.join(", ")),
        Form::Constant(name) => name.to_owned(),
        Form::Texture => panic!("textures are parameters"),
        Form::Measured => panic!("measured materials are files"),
        Form::Vector => format!("<{}>", operands.join(", ")),
        Form::Conditional => format!("if({})", operands.join(", ")),
    };
    let result = match operation.result() {
        Type::Scalar => format!("<{call}, 0, 0>"),
        Type::Vector => call,
        Type::Truth => format!("<if({call}, 1, 0), 0, 0>"),
        Type::Texture => panic!("no operation yields a texture"),
    };
    let text = format!("{declarations}formula;\n= {result};\n");
    let source = Source::new("operation", text.clone());
    let (formula, _) = Formula::parse(&source).unwrap_or_else(|errors| panic!("{text}\n{}", errors.located(&source)));
    (formula, count)
}

/// How many lines this number of cases takes, in whole rounds of any kernel.
fn whole_rounds(cases: usize) -> usize {
    cases.div_ceil(Line::RECORDS).next_multiple_of(ROUND_LINES)
}

/// A stream with a column for each of these nodes. It holds a number for each case.
fn stream(nodes: &[NodeId], cases: usize, number: impl Fn(NodeId, usize) -> f32) -> Vec<Line> {
    let mut lines = vec![Line::default(); whole_rounds(cases) * nodes.len()];
    for (column, node) in nodes.iter().enumerate() {
        for case in 0..cases {
            lines[case / 16 * nodes.len() + column].0[case % 16] = flush(number(*node, case));
        }
    }
    lines
}

/// Runs a kernel over a stream. Returns the outputs of each case.
fn run(kernel: &Kernel, input: &[Line], uniforms: &[Splat], terms: bool, cases: usize) -> Vec<Vec<f32>> {
    let outputs = kernel.outputs();
    // Values are stored in one stream, terms in columns.
    let (count, columns) = if terms { (outputs, 1) } else { (1, outputs) };
    let mut results = vec![vec![Line::default(); whole_rounds(cases) * columns]; count];
    let mut streams: Vec<&mut [Line]> = results.iter_mut().map(Vec::as_mut_slice).collect();
    kernel.run([input, &[], &[]], uniforms, &mut streams, cases.div_ceil(Line::RECORDS));
    let result = |case: usize, output: usize| {
        let line = case / 16 * columns + output % columns;
        results[output / columns][line].0[case % 16]
    };
    (0..cases).map(|case| (0..outputs).map(|output| result(case, output)).collect()).collect()
}

/// The results of many cases by code for vectors of one width. A case is the operation's numbers, a result its
/// components.
pub(super) fn compiled(formula: &Formula, width: Width, cases: &[Vec<f32>], from: Operands) -> Vec<[f32; 3]> {
    let compiled = CompiledFormula::with_width(formula, width).expect("this machine runs compiled code");
    let bindings = &compiled.plan.bindings;
    let number = |leaf: NodeId, case: usize| match bindings.graph.node(leaf) {
        // The intensity of the light and the factor `one` are 1.
        Node::Parameter(id, _) => {
            match formula.parameter(id).name.strip_prefix('p').and_then(|index| index.parse::<usize>().ok()) {
                Some(index) => cases[case][index],
                None => 1.0,
            }
        }
        Node::Variable(variable, component) => {
            let first = [Variable::Normal, Variable::ToViewer, Variable::Point].iter().position(|known| *known == variable);
            cases[case][3 * first.expect("a variable of the formula") + usize::from(component)]
        }
        Node::Constant(_) | Node::Apply(..) => panic!("leaves are parameters and variables"),
    };
    let leaves = stream(&compiled.plan.contribution.uniforms.streams[0], cases.len(), number);
    let uniforms = run(&compiled.contribution.uniforms, &leaves, &[], false, cases.len());
    let results = match from {
        Operands::Uniforms => uniforms,
        Operands::Columns => {
            assert!(
                bindings.frontier.hits.len() <= 7 && bindings.frontier.records.is_empty(),
                "only the numbers themselves are static"
            );
            let splat: Vec<Splat> = uniforms[0].iter().map(|number| Splat::new(*number)).collect();
            let input = stream(&bindings.frontier.hits, cases.len(), number);
            let [stored, added] = [&compiled.contribution.overwrite, &compiled.contribution.add]
                .map(|kernel| run(kernel, &input, &splat, true, cases.len()));
            let same = |(x, y): (&f32, &f32)| x == y || x.is_nan() && y.is_nan();
            assert!(stored.iter().flatten().zip(added.iter().flatten()).all(same), "stored, or added to 0");
            stored
        }
    };
    (0..cases.len())
        .map(|case| {
            let component = |index: usize| match from {
                Operands::Columns => Some(index),
                Operands::Uniforms => {
                    bindings.frontier.uniforms.iter().position(|uniform| *uniform == bindings.contribution[index])
                }
            };
            std::array::from_fn(|index| match component(index) {
                Some(output) => results[case][output],
                // Constant components are folded.
                None => bindings.graph.constant(bindings.contribution[index]).expect("what depends on nothing is constant"),
            })
        })
        .collect()
}

/// The reference meaning.
fn reference(operation: Operation, case: &[f32]) -> Vec<f32> {
    let mut stack = Stack::new(16, 0.0);
    let truths: Vec<bool> = operation.operands().iter().flat_map(|ty| vec![*ty == Type::Truth; ty.slots()]).collect();
    for (number, truth) in case.iter().zip(truths) {
        let number = flush(*number);
        stack.push(if truth { f32::from(u8::from(number != 0.0)) } else { number });
    }
    operation.apply(&mut Floats, &mut stack);
    match operation.result() {
        Type::Scalar | Type::Truth | Type::Texture => stack.pop::<1>().to_vec(),
        Type::Vector => stack.pop::<3>().to_vec(),
    }
}

/// Whether two results differ by rounding only. Infinity counts as the number after the largest one. Near the smallest
/// normal number, rounding decides between that number and 0.
fn agree(one: f32, other: f32) -> bool {
    let near = one.is_sign_negative() == other.is_sign_negative() && one.to_bits().abs_diff(other.to_bits()) <= UNITS;
    let tiny = |x: f32| x.abs() <= f32::MIN_POSITIVE * (1.0 + UNITS as f32 * f32::EPSILON);
    one == other || (one.is_nan() && other.is_nan()) || (near && !one.is_nan() && !other.is_nan()) || (tiny(one) && tiny(other))
}

/// The cases: all combinations of extreme numbers for one or two operands, a selection of them for more.
fn cases(count: usize) -> Vec<Vec<f32>> {
    let awkward = |index: usize| AWKWARD[index % AWKWARD.len()];
    match count {
        0 => vec![Vec::new()],
        1 => AWKWARD.iter().map(|x| vec![*x]).collect(),
        2 => AWKWARD.iter().flat_map(|x| AWKWARD.iter().map(move |y| vec![*x, *y])).collect(),
        _ => (0..20_000)
            .map(|case| (0..count).map(|index| awkward(case * (2 * index + 1) / (index + 1) + 7 * index * case)).collect())
            .collect(),
    }
}

#[test]
fn every_operation_agrees_on_uniform_values() {
    disagreements_are_none(Operands::Uniforms);
}

#[test]
fn every_operation_agrees_on_columns() {
    disagreements_are_none(Operands::Columns);
}

fn disagreements_are_none(from: Operands) {
    let mut failures = Vec::new();
    // Operands of the dot product of directions must have unit length, and a texture is a parameter. Random formulas
    // cover both. Measured materials have tests of their own.
    let has_free_operands = |operation: &&Operation| !matches!(operation.form(), Form::UnitDot | Form::Texture | Form::Measured);
    for operation in Operation::ALL.iter().filter(has_free_operands) {
        if operation.operands().is_empty() && from == Operands::Columns {
            continue;
        }
        let (formula, count) = formula_of(*operation, from);
        assert!(operation.operands().iter().map(|ty| ty.slots()).sum::<usize>() == count);
        let cases = cases(count);
        let results = Width::supported().flat_map(|width| {
            let results = compiled(&formula, width, &cases, from);
            cases.iter().zip(results).map(move |(case, got)| (width, case, got))
        });
        for (width, case, got) in results {
            let angle_too_large = matches!(operation, Operation::Sin | Operation::Cos | Operation::Tan)
                && case[0].is_finite()
                && case[0].abs() > 1e5;
            if angle_too_large {
                let bounded = if *operation == Operation::Tan { got[0].is_finite() } else { got[0].abs() <= 1.0 };
                assert!(bounded, "{operation:?}{case:?} = {} in {width}", got[0]);
                continue;
            }
            let expected = reference(*operation, case);
            if !expected.iter().zip(got).all(|(expected, got)| agree(got, *expected)) {
                failures.push(format!("{operation:?}{case:?}: in {width} {got:?}, reference {expected:?}"));
            }
        }
    }
    let shown = failures.iter().take(40).cloned().collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} failures:\n{shown}", failures.len());
}
