//! Kernels of different widths, parts and allocations.

use super::*;
use crate::formula::Formula;
use crate::formula::binding::Bindings;
use crate::formula::graph::{Node, NodeId};
use crate::jit::target::Allocation;
use crate::lang::scalars::{Floats, Primitive, Recorder, awkward_operands};
use crate::lang::source::Source;
use crate::lang::variables::Variable;
use crate::plan::{Domain, FormulaPlan, KernelPlan, Sink};
use crate::trace::ROUND_LINES;
use crate::workspace::{FileKind, presets};

/// The number of blocks in a round of the contribution kernels of a formula, compiled for this width, and their
/// results for some numbers.
fn contributions(bindings: &Bindings, width: Width) -> (usize, Vec<f32>) {
    let plan = FormulaPlan::of(bindings.clone(), None).contribution.records;
    let specs = [KernelSpec::overwriting(&plan), KernelSpec::adding(&plan).unwrap()];
    let kernels = generate(width, &specs, &bindings.graph, None).unwrap();
    const LINES: usize = 3 * ROUND_LINES;
    let number = |index: usize| 1.25 * ((index as f32 * 0.618_034).fract() - 0.3);
    let line = |first: usize| Line(std::array::from_fn(|lane| number(first + lane)));
    let stream = |columns: &usize| (0..LINES * columns).map(|index| line(16 * index + 1000 * columns)).collect();
    let streams: [Vec<Line>; STREAMS] = kernels[0].streams.each_ref().map(stream);
    let uniforms: Vec<Splat> = (0..kernels[0].uniforms).map(|index| Splat::new(number(7 * index).abs() * 3.0)).collect();
    let mut outputs = vec![vec![Line::default(); LINES]; 3];
    let mut planes: Vec<&mut [Line]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
    // One stores, the other adds twice.
    for kernel in [&kernels[0], &kernels[1], &kernels[1]] {
        kernel.run(streams.each_ref().map(Vec::as_slice), &uniforms, &mut planes, LINES);
    }
    (kernels[0].functions[0].1.round(), outputs.iter().flatten().flat_map(|line| line.0).collect())
}

#[test]
fn kernels_of_all_widths_compute_the_same() {
    let every = "body_specific; a: scalar; b: scalar; formula;
        = <sin(a*alpha) + asin(N.V) + tan(b*beta), exp(a*(N.L)) + log(b + dist) + atan2(a*alpha, beta), (a*dist)^(b*(N.L))>
        + if(a*alpha < b, <1, floor(a*beta), 0>, V*sqrt(b*dist));";
    let presets = presets::names(FileKind::Formula).map(|name| presets::text(FileKind::Formula, name).unwrap().to_owned());
    let mut bright = 0;
    for text in presets.chain([every.to_owned()]) {
        let (formula, _) = Formula::parse(&Source::new("formula", text.clone())).unwrap();
        let bindings = Bindings::new(&formula);
        let (round, narrow) = contributions(&bindings, Width::Four);
        assert!(round <= 4, "{text}");
        // Some models are black for these numbers.
        bright += usize::from(narrow.iter().any(|x| *x != 0.0));
        for width in Width::supported() {
            let (round, wide) = contributions(&bindings, width);
            // Kernels that call the function for noise are not widened.
            let is_wide = round.is_multiple_of(width.lanes() / 4) || text.contains("perlin(");
            assert!(is_wide, "as wide as the vectors: {text}");
            // With four lanes, products are rounded before they are added, and powers of two with negative exponents
            // may differ in the last place, see `vreduceps`.
            let same = |(x, y): (&f32, &f32)| x == y || x.is_nan() && y.is_nan() || (x - y).abs() <= 2e-6 * x.abs().max(1.0);
            let other = narrow.iter().zip(&wide).find(|pair| !same(*pair));
            assert_eq!(other, None, "{width}: {text}");
        }
    }
    assert!(bright > presets::names(FileKind::Formula).count() / 2, "{bright} formulas are not black");
}

/// The number of lanes of a kernel that computes a primitive, compiled for this width, and its results for operands
/// from columns, one case in each lane.
fn results(primitive: Primitive, cases: &[Vec<f32>], width: Width, sink: Sink) -> (usize, Vec<f32>) {
    let mut graph = Graph::empty([].into());
    let leaf = |index: usize| {
        let variable = [Variable::Normal, Variable::ToViewer][index / 3];
        Node::Variable(variable, (index % 3) as u8)
    };
    let leaves: Vec<NodeId> = (0..primitive.arity()).map(|index| graph.insert(leaf(index))).collect();
    let mut result = graph.record(primitive, &leaves);
    if primitive.yields_truth() {
        let [one, zero] = [1.0, 0.0].map(|value| graph.record_constant(value));
        result = graph.record(Primitive::Select, &[result, one, zero]);
    }
    let plan = KernelPlan {
        name: "primitive",
        domain: Domain::LitRecords,
        streams: [leaves.clone(), Vec::new(), Vec::new()],
        uniforms: Vec::new(),
        outputs: vec![result],
        sink,
    };
    let kernel = generate(width, &[KernelSpec::overwriting(&plan)], &graph, None).unwrap().remove(0);
    let lines = cases.len().div_ceil(Line::RECORDS).next_multiple_of(ROUND_LINES);
    let mut stream = vec![Line::default(); lines * leaves.len()];
    for (case, operands) in cases.iter().enumerate() {
        for (column, operand) in operands.iter().enumerate() {
            stream[case / Line::RECORDS * leaves.len() + column].0[case % Line::RECORDS] = *operand;
        }
    }
    let mut output = vec![Line::default(); lines];
    kernel.run([&stream, &[], &[]], &[], &mut [&mut output], lines);
    (4 * kernel.functions[0].1.blocks, output.iter().flat_map(|line| line.0).take(cases.len()).collect())
}

/// Whether two results differ by at most a few units in the last place. Numbers near the smallest normal number count
/// as 0.
fn agree(one: f32, other: f32) -> bool {
    const UNITS: u32 = 5;
    let near = one.is_sign_negative() == other.is_sign_negative() && one.to_bits().abs_diff(other.to_bits()) <= UNITS;
    let tiny = |x: f32| x.abs() <= f32::MIN_POSITIVE * (1.0 + UNITS as f32 * f32::EPSILON);
    one == other || (one.is_nan() && other.is_nan()) || (near && !one.is_nan() && !other.is_nan()) || (tiny(one) && tiny(other))
}

#[test]
fn every_primitive_is_widened_and_computes_its_meaning_at_every_width() {
    for &primitive in Primitive::ALL {
        // Shifted by one case each time, so that every case is in each of sixteen lanes once.
        let cases = awkward_operands(primitive);
        let turned = (0..if cases.len() < 2000 { 16 } else { 1 }).flat_map(|turn| cases.iter().chain(&cases[..turn]));
        let cases: Vec<Vec<f32>> = turned.cloned().collect();
        for width in Width::supported() {
            // Columns are computed one vector at a time, sums several side by side.
            for sink in [Sink::Columns, Sink::Sums] {
                let (lanes, results) = results(primitive, &cases, width, sink);
                // Noise is called, four points at a time.
                let expected = if Callee::of(primitive).is_some() { 4 } else { width.lanes() };
                assert_eq!(lanes, expected, "{primitive:?} in vectors of {width}");
                for (operands, result) in cases.iter().zip(results) {
                    let turns = matches!(primitive, Primitive::Sin | Primitive::Cos | Primitive::Tan);
                    let expected = primitive.apply(&mut Floats, operands);
                    let right = match turns && operands[0].is_finite() && operands[0].abs() > 1e5 {
                        true => result.is_finite() && (primitive == Primitive::Tan || result.abs() <= 1.0),
                        false => agree(result, expected),
                    };
                    assert!(right, "{primitive:?}{operands:?} is {result} in {lanes} lanes, not {expected}");
                }
            }
        }
    }
}

/// Holds a kernel that reads one stream and stores columns against the meaning of its nodes, compiled for vectors of
/// this width.
fn assert_columns(plan: &KernelPlan, graph: &Graph, width: Width) {
    const LINES: usize = 2;
    let leaves = &plan.streams[0];
    let number = |record: usize, leaf: usize| 1.25 * ((record as f32 * 0.618_034 + leaf as f32 * 0.414).fract() - 0.3);
    let mut stream = vec![Line::default(); LINES * leaves.len()];
    for (record, column) in (0..LINES * Line::RECORDS).flat_map(|record| (0..leaves.len()).map(move |leaf| (record, leaf))) {
        stream[record / Line::RECORDS * leaves.len() + column].0[record % Line::RECORDS] = number(record, column);
    }
    let columns = plan.outputs.len();
    let mut output = vec![Line::default(); LINES * columns];
    let kernel = generate(width, &[KernelSpec::overwriting(plan)], graph, None).unwrap().remove(0);
    kernel.run([&stream, &[], &[]], &[], &mut [&mut output], LINES);
    for record in 0..LINES * Line::RECORDS {
        let leaf = |id: NodeId| number(record, leaves.iter().position(|leaf| *leaf == id).unwrap());
        for (column, expected) in graph.evaluate(&plan.outputs, leaf).into_iter().enumerate() {
            let result = output[record / Line::RECORDS * columns + column].0[record % Line::RECORDS];
            let near = (result - expected).abs() <= 1e-5 * expected.abs().max(1.0);
            assert!(
                near,
                "{}, output {column} of record {record} is {result}, not {expected}, {width}, {:?}",
                plan.name, kernel.functions[0].1
            );
        }
    }
}

#[test]
fn kernels_of_many_outputs_are_compiled_in_parts() {
    let term = |n: usize| format!("sin({n}*alpha)*cos({n}*a)*IL");
    let sum = (1..=400).map(term).collect::<Vec<String>>().join(" + ");
    let text = format!("body_specific; a: scalar; formula; = {sum};");
    let (formula, _) = Formula::parse(&Source::new("formula", text)).unwrap();
    let plan = FormulaPlan::new(&formula);
    let graph = &plan.bindings.graph;
    for kernel in [&plan.records, &plan.contribution.uniforms] {
        let parts = KernelSpec::overwriting(kernel).parts(graph);
        assert!(kernel.outputs.len() >= 400 && parts.len() > 1, "{}: {} parts", kernel.name, parts.len());
        let outputs: Vec<usize> = parts.iter().flat_map(|part| part.outputs.clone()).collect();
        assert_eq!(outputs, (0..kernel.outputs.len()).collect::<Vec<usize>>());
        Width::supported().for_each(|width| assert_columns(kernel, graph, width));
    }
}

#[test]
fn built_in_formulas_have_kernels_of_one_part() {
    for name in presets::names(FileKind::Formula) {
        let (formula, _) = Formula::parse(&Source::new(name, presets::text(FileKind::Formula, name).unwrap())).unwrap();
        let plan = FormulaPlan::new(&formula);
        for kernel in [&plan.hits, &plan.records, &plan.contribution.uniforms, &plan.contribution.records] {
            assert_eq!(KernelSpec::overwriting(kernel).parts(&plan.bindings.graph).len(), 1, "{name}, {}", kernel.name);
        }
    }
}

#[test]
fn kernels_with_very_many_values_alive_are_allocated_quickly() {
    const COUNT: usize = 800;
    let mut graph = Graph::empty([].into());
    let leaf = graph.insert(Node::Variable(Variable::Normal, 0));
    let mut value = |n: usize| {
        let factor = graph.record_constant(0.01 * n as f32);
        let angle = graph.record(Primitive::Mul, &[leaf, factor]);
        graph.record(Primitive::Sin, &[angle])
    };
    let values: Vec<NodeId> = (1..=COUNT).map(&mut value).collect();
    // Each is used again in the second half, in the opposite order.
    let mut sum = graph.record_constant(0.0);
    for (one, other) in values.iter().zip(values.iter().rev()) {
        let product = graph.record(Primitive::Mul, &[*one, *other]);
        sum = graph.record(Primitive::Add, &[sum, product]);
    }
    let plan = KernelPlan {
        name: "web",
        domain: Domain::LitRecords,
        streams: [vec![leaf], Vec::new(), Vec::new()],
        uniforms: Vec::new(),
        outputs: vec![sum],
        sink: Sink::Columns,
    };
    let allocation = |root| kernel::allocation(&plan.schedule(&graph, [root]).unwrap(), &graph);
    assert_eq!([values[0], sum].map(allocation), [Allocation::Careful, Allocation::Quick]);
    Width::supported().for_each(|width| assert_columns(&plan, &graph, width));
}
