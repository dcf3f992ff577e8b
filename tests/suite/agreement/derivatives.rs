//! Derivatives by parameters: those of random formulas against differences in double precision, and those of built-in
//! formulas as compiled code.

use super::formulas::{Case, ingredients, runner};
use glam::DVec3;
use illuminator::evaluate::at_point::variable_at_point;
use illuminator::formula::derivative::derivatives;
use illuminator::formula::graph::{Graph, Node, NodeId};
use illuminator::formula::{Formula, ParameterId};
use illuminator::instrument::DirectionPair;
use illuminator::instrument::model::{ModelProgram, Place, default_numbers};
use illuminator::lang::scalars::{Doubles, Primitive};
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::lang::variables::{Predefined, Variable};
use illuminator::workspace::{FileKind, presets};
use proptest::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};

fn direction(polar: f64, azimuth: f64) -> DVec3 {
    DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
}

/// The values of all variables for a light and a viewer.
fn variables(light: DVec3, view: DVec3) -> HashMap<Variable, DVec3> {
    let known = [
        (Variable::ToLight, light),
        (Variable::ToViewer, view),
        (Variable::SurfaceU, DVec3::splat(0.31)),
        (Variable::SurfaceV, DVec3::splat(0.62)),
        (Variable::Point, DVec3::new(0.2, 1.3, -0.7)),
    ];
    let given = |variable: Variable| known.iter().find(|(known, _)| *known == variable).map(|(_, value)| *value);
    let value = |variable: &Variable| Some((*variable, variable_at_point(*variable, &given)?));
    Variable::ALL.iter().filter_map(value).collect()
}

/// A graph, with the values of its leaves in double precision.
struct Leaves<'l> {
    graph: &'l Graph,
    variables: &'l HashMap<Variable, DVec3>,
    parameters: &'l [[f64; 3]],
}

impl Leaves<'_> {
    /// The values of nodes where one component of a parameter is moved by `by`.
    fn values(&self, roots: &[NodeId], moved: (ParameterId, u8), by: f64) -> Vec<f64> {
        let leaf = |id| match self.graph.node(id) {
            Node::Variable(variable, component) => self.variables[&variable][usize::from(component)],
            Node::Parameter(parameter, component) => {
                let own = self.parameters[parameter.0 as usize][usize::from(component)];
                own + if (parameter, component) == moved { by } else { 0.0 }
            }
            Node::Constant(_) | Node::Apply(..) => unreachable!("no leaf"),
        };
        self.graph.evaluate_with(&mut Doubles, roots, leaf)
    }

    /// The slope of a node by differences, where the function is smooth: differences over two distances agree, and so
    /// do those on both sides.
    fn slope(&self, root: NodeId, moved: (ParameterId, u8)) -> Option<f64> {
        let size = self.parameters[moved.0.0 as usize][usize::from(moved.1)].abs().max(1.0);
        let h = 1e-5 * size;
        let at = |by: f64| self.values(&[root], moved, by)[0];
        let [far_left, left, here, right, far_right] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|steps| at(steps * h));
        let (near, far) = ((right - left) / (2.0 * h), (far_right - far_left) / (4.0 * h));
        let sides = [(here - left) / h, (right - here) / h];
        let close = |x: f64, y: f64, share: f64| (x - y).abs() <= share * near.abs().max(1e-3);
        // Differences of large values are rounded.
        let exact = here.abs() * 1e-15 / h <= 1e-7 * near.abs().max(1e-3);
        let smooth = close(near, far, 1e-6) && close(sides[0], sides[1], 1e-2) && exact;
        (near.is_finite() && smooth).then_some((4.0 * near - far) / 3.0)
    }
}

/// Those that are not 0.
static COMPARED: AtomicUsize = AtomicUsize::new(0);
static LEFT_OUT: AtomicUsize = AtomicUsize::new(0);

fn check(parts: [&str; 3], numbers: &[f32], angles: [f64; 4]) -> Result<(), TestCaseError> {
    let source = Source::new("random", Case::text(parts));
    let (formula, _) = Formula::parse(&source).map_err(|errors| TestCaseError::fail(errors.located(&source).to_string()))?;
    let mut graph = Graph::new(&formula);
    let (roots, own_nodes) = (graph.result(), graph.len() as u32);
    let by: Vec<(ParameterId, u8)> = formula
        .parameter_ids()
        .filter(|id| formula.parameter(*id).ty != Type::Texture)
        .flat_map(|id| (0..formula.parameter(id).ty.slots() as u8).map(move |component| (id, component)))
        .collect();
    let slopes = derivatives(&mut graph, &roots, &by);
    let variables = variables(direction(angles[0], angles[1]), direction(angles[2], angles[3]));
    // Textures are white.
    let value = |id: ParameterId| match formula.parameter(id).ty {
        Type::Texture => [0.0; 3],
        // Around larger numbers, differences over a small distance say nothing.
        Type::Scalar | Type::Vector | Type::Truth => std::array::from_fn(|component| {
            f64::from(numbers[(3 * id.0 as usize + component) % numbers.len()].clamp(-20.0, 100.0))
        }),
    };
    let parameters: Vec<[f64; 3]> = formula.parameter_ids().map(value).collect();
    let leaves = Leaves { graph: &graph, variables: &variables, parameters: &parameters };
    // Noise and textures are measured over a distance that is not small for noise of a high frequency.
    let is_measured = |index: usize| {
        matches!(graph.node(NodeId(index as u32)), Node::Apply(Primitive::Perlin | Primitive::Texture | Primitive::Measured, _))
    };
    // Where a value on the way is infinite, the slope may be the product of 0 and infinity. Steps of large whole
    // numbers look like a slope.
    let all: Vec<NodeId> = (0..own_nodes).map(NodeId).collect();
    let finite = leaves.values(&all, (ParameterId(u32::MAX), 0), 0.0).iter().all(|value| value.abs() < 1e5);
    let tolerance = (finite && !(0..own_nodes as usize).any(is_measured)).then_some(1e-4);
    let text = source.text();
    for (moved, slopes) in by.iter().zip(&slopes) {
        let found = leaves.values(slopes, *moved, 0.0);
        for (root, found) in roots.iter().zip(found) {
            let (Some(wanted), Some(tolerance)) = (leaves.slope(*root, *moved), tolerance) else {
                LEFT_OUT.fetch_add(1, Ordering::Relaxed);
                continue;
            };
            COMPARED.fetch_add(usize::from(wanted != 0.0), Ordering::Relaxed);
            let near = (found - wanted).abs() <= tolerance * wanted.abs().max(1.0);
            prop_assert!(near, "∂/∂{}: {found}, {wanted} by differences\n{text}", formula.parameter(moved.0).name);
        }
    }
    Ok(())
}

#[test]
fn derivatives_of_random_formulas_are_slopes() {
    let angle = || (0.02..1.55_f64, -3.1..3.1_f64);
    let cases = (ingredients(), angle(), angle());
    let outcome = runner(1000).run(&cases, |((scalar, vector, result, numbers), light, view)| {
        check([&scalar, &vector, &result], &numbers, [light.0, light.1, view.0, view.1])
    });
    let (compared, left_out) = (COMPARED.load(Ordering::Relaxed), LEFT_OUT.load(Ordering::Relaxed));
    println!("{compared} derivatives other than 0 compared, {left_out} left out: not smooth, not small, or measured");
    if let Err(error) = outcome {
        panic!("{error}");
    }
    assert!(compared > 1000, "{compared} compared, {left_out} left out");
}

#[test]
fn compiled_derivatives_of_built_in_formulas_are_slopes() {
    let (mut compared, mut left_out) = (0, 0);
    for name in presets::names(FileKind::Formula) {
        let source = Source::new(name, presets::text(FileKind::Formula, name).expect("a formula"));
        let (formula, _) = Formula::parse(&source).expect("a formula");
        let smooth = |id: &ParameterId| {
            let parameter = formula.parameter(*id);
            let is_white = parameter.predefined == Some(Predefined::LightColour);
            parameter.ty == Type::Scalar && !parameter.is_whole() && !is_white
        };
        let by: Vec<(ParameterId, u8)> = formula.parameter_ids().filter(smooth).map(|id| (id, 0)).collect();
        let program = ModelProgram::with_derivatives(&formula, &by);
        let numbers = default_numbers(&formula);
        let pairs: Vec<[DVec3; 2]> = (1..=30)
            .map(|index| {
                let at = |step: f64| (f64::from(index) * step).fract();
                let angles = [0.618, 0.755, 0.57, 0.32].map(at);
                [direction(1.4 * angles[0], 6.3 * angles[1]), direction(1.4 * angles[2], 6.3 * angles[3])]
            })
            .collect();
        let prepared: Vec<DirectionPair> = pairs
            .iter()
            .map(|[light, view]| DirectionPair { light: light.as_vec3().to_array(), view: view.as_vec3().to_array() })
            .collect();
        let found = program.run(&program.prepare(&prepared, &Place::default()), &numbers);
        let graph = Graph::new(&formula);
        let white = formula.predefined(Predefined::LightColour).0 as usize;
        let mut parameters: Vec<[f64; 3]> = numbers.iter().map(|value| value.map(f64::from)).collect();
        parameters[white] = [1.0; 3];
        for (pair, found) in prepared.iter().zip(found.chunks(program.outputs())) {
            let [light, view] = [pair.light, pair.view].map(|direction| glam::Vec3::from(direction).as_dvec3());
            let mut variables = variables(light, view);
            variables.extend([Variable::SurfaceU, Variable::SurfaceV, Variable::Point].map(|variable| (variable, DVec3::ZERO)));
            let leaves = Leaves { graph: &graph, variables: &variables, parameters: &parameters };
            let values = leaves.values(&graph.result(), (ParameterId(u32::MAX), 0), 0.0);
            for (index, moved) in by.iter().enumerate() {
                for (component, root) in graph.result().into_iter().enumerate() {
                    let Some(wanted) = leaves.slope(root, *moved) else {
                        left_out += 1;
                        continue;
                    };
                    compared += 1;
                    let found = f64::from(found[3 + 3 * index + component]);
                    // Directions and values are rounded to `f32`.
                    let size = wanted.abs().max(values[component].abs()).max(0.1);
                    let near = (found - wanted).abs() <= 2e-3 * size;
                    let parameter = &formula.parameter(moved.0).name;
                    assert!(near, "{name}: ∂/∂{parameter} = {found}, {wanted} by differences at {pair:?}");
                }
            }
        }
    }
    println!("{compared} derivatives compared, {left_out} left out");
    assert!(compared > 10 * left_out, "{compared} compared, {left_out} left out");
}
