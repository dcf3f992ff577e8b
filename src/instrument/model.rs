//! A formula as a [`Reflectance`]: compiled for pairs of directions instead of hits.
//!
//! A [`ModelProgram`] belongs to a formula, and computes any of its expressions or derivatives for
//! [prepared pairs](ModelProgram::prepare). Values of parameters are given at each evaluation, so a moved slider costs
//! one run of the code. Where code cannot be compiled, the reference meaning gives the same values more slowly.

use crate::evaluate::at_point::variable_at_point;
use crate::formula::derivative::derivatives;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::formula::{Formula, ParameterId, Term, TermId};
use crate::instrument::{DirectionPair, Reflectance};
use crate::jit::{Kernel, Line, Splat, Width, compile_stage};
use crate::lang::scalars::{Doubles, flush};
use crate::lang::variables::{Predefined, Variable};
use crate::plan::{Domain, KernelPlan, Sink};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

/// The values of all parameters of a formula, by their index. Those of a scalar are repeated three times.
pub type ParameterNumbers = Vec<[f32; 3]>;

/// The defaults of all parameters.
pub fn default_numbers(formula: &Formula) -> ParameterNumbers {
    let value = |id| {
        let parameter = formula.parameter(id);
        if parameter.ty.slots() == 3 { parameter.default } else { [parameter.default[0]; 3] }
    };
    formula.parameter_ids().map(value).collect()
}

/// Where on a surface a formula is evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Tangent, bitangent and normal in world coordinates, as columns.
    pub frame: DMat3,
    /// The values of further variables there, such as `u` and `point`. Others are plain, see [`variable_at_point`].
    pub given: Vec<(Variable, DVec3)>,
}

impl Default for Place {
    /// The origin, with the axes of the world as the frame.
    fn default() -> Self {
        Self { frame: DMat3::IDENTITY, given: Vec::new() }
    }
}

impl Place {
    /// The place at other coordinates of its surface, `u` and `v`.
    #[must_use]
    pub fn at_coordinates(mut self, [u, v]: [f64; 2]) -> Self {
        self.given.retain(|(variable, _)| !variable.is_coordinate());
        self.given.extend([(Variable::SurfaceU, DVec3::splat(u)), (Variable::SurfaceV, DVec3::splat(v))]);
        self
    }
}

/// Whether a formula reads coordinates of the surface, as patterns and textures do.
pub fn reads_coordinates(formula: &Formula) -> bool {
    formula.terms.iter().any(|term| matches!(term, Term::Variable(variable) if variable.is_coordinate()))
}

/// Expressions of a formula, compiled for pairs of directions.
pub struct ModelProgram {
    graph: Graph,
    /// What is computed for each pair.
    outputs: Vec<NodeId>,
    /// What is read of each pair, a column each.
    variables: Vec<(NodeId, Variable, usize)>,
    /// The same by variables: the columns of each, with their components.
    columns: Vec<(Variable, Vec<(usize, usize)>)>,
    /// What parameters alone decide: computed once for all pairs.
    uniforms: Vec<NodeId>,
    /// `None` where no code can be compiled.
    kernel: Option<Kernel>,
    /// The light is white, whatever its parameter says.
    colour_of_light: ParameterId,
}

/// What a program reads of pairs of directions: valid for every value of parameters.
pub struct PreparedPairs {
    pairs: usize,
    /// Blocks of pairs. In each, line by line, a line of every column.
    blocks: Vec<Vec<Line>>,
}

/// Pairs in a block: enough for a thread, and little enough to stay in the caches.
const BLOCK: usize = 128 * Line::RECORDS;

impl ModelProgram {
    /// The program of the result of a formula: three outputs.
    pub fn new(formula: &Formula) -> Self {
        Self::of_terms(formula, &[formula.result])
    }

    /// A program of these expressions. Each has as many outputs as its type has components.
    pub fn of_terms(formula: &Formula, terms: &[TermId]) -> Self {
        let (graph, roots) = Graph::of(formula, terms);
        let outputs = roots.iter().zip(terms).flat_map(|(nodes, term)| nodes[..formula.ty(*term).slots()].to_vec()).collect();
        Self::of_graph(formula, graph, outputs)
    }

    /// A program of the result of a formula and of its derivatives: red, green and blue of the result, then of the
    /// derivative by each of these components of parameters.
    pub fn with_derivatives(formula: &Formula, by: &[(ParameterId, u8)]) -> Self {
        let mut graph = Graph::new(formula);
        let result = graph.result();
        let changes = derivatives(&mut graph, &result, by);
        Self::of_graph(formula, graph, result.into_iter().chain(changes.into_iter().flatten()).collect())
    }

    fn of_graph(formula: &Formula, graph: Graph, outputs: Vec<NodeId>) -> Self {
        // Nodes of parameters alone, and those of them that others read.
        let mut uniform = vec![false; graph.len()];
        let mut variables = Vec::new();
        let needed = graph.needed(&outputs);
        let mut is_read = vec![false; graph.len()];
        outputs.iter().for_each(|output| is_read[output.0 as usize] = true);
        for (index, _) in needed.iter().enumerate().filter(|(_, needed)| **needed) {
            let id = NodeId(index as u32);
            let node = graph.node(id);
            uniform[index] = match node {
                Node::Constant(_) | Node::Parameter(..) => true,
                Node::Variable(variable, component) => {
                    variables.push((id, variable, usize::from(component)));
                    false
                }
                Node::Apply(..) => node.operands().iter().all(|operand| uniform[operand.0 as usize]),
            };
            if !uniform[index] {
                node.operands().iter().for_each(|operand| is_read[operand.0 as usize] = true);
            }
        }
        let is_uniform = |index: usize| needed[index] && uniform[index] && is_read[index];
        let constant = |id: &NodeId| graph.constant(*id).is_some();
        let uniforms = (0..graph.len()).filter(|index| is_uniform(*index)).map(|index| NodeId(index as u32));
        let uniforms: Vec<NodeId> = uniforms.filter(|id| !constant(id)).collect();
        let plan = KernelPlan {
            name: "directions",
            domain: Domain::LitRecords,
            streams: [variables.iter().map(|(id, ..)| *id).collect(), Vec::new(), Vec::new()],
            uniforms: uniforms.clone(),
            outputs: outputs.clone(),
            sink: Sink::Columns,
        };
        let kernel = Width::widest().ok().and_then(|width| compile_stage(&plan, &graph, width).ok());
        let mut columns: Vec<(Variable, Vec<(usize, usize)>)> = Vec::new();
        for (column, (_, variable, component)) in variables.iter().enumerate() {
            match columns.iter_mut().find(|(known, _)| known == variable) {
                Some((_, columns)) => columns.push((column, *component)),
                None => columns.push((*variable, vec![(column, *component)])),
            }
        }
        let colour_of_light = formula.predefined(Predefined::LightColour);
        Self { graph, outputs, variables, columns, uniforms, kernel, colour_of_light }
    }

    /// How many numbers are computed for each pair.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Computes what the program reads of pairs at a place.
    pub fn prepare(&self, pairs: &[DirectionPair], place: &Place) -> PreparedPairs {
        let columns = self.variables.len();
        let block = |pairs: &[DirectionPair]| {
            let mut block = vec![Line::default(); self.whole(pairs.len()) * columns];
            for (index, pair) in pairs.iter().enumerate() {
                let directions = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3());
                let (line, lane) = (index / Line::RECORDS, index % Line::RECORDS);
                self.read(directions, place, |column, value| {
                    block[line * columns + column].0[lane] = flush(value as f32);
                });
            }
            block
        };
        PreparedPairs { pairs: pairs.len(), blocks: pairs.par_chunks(BLOCK).map(block).collect() }
    }

    /// Computes what the program reads of a light and a viewer: the number of each column, and its value.
    fn read(&self, directions: [DVec3; 2], place: &Place, mut put: impl FnMut(usize, f64)) {
        let directions = directions.map(|direction| place.frame * direction);
        let own = [
            (Variable::ToLight, directions[0]),
            (Variable::ToViewer, directions[1]),
            (Variable::Normal, place.frame.z_axis),
            (Variable::Tangent, place.frame.x_axis),
            (Variable::Bitangent, place.frame.y_axis),
        ];
        let given =
            |variable: Variable| own.iter().chain(&place.given).find(|(known, _)| *known == variable).map(|(_, value)| *value);
        for (variable, columns) in &self.columns {
            let value = variable_at_point(*variable, &given).unwrap_or_default();
            columns.iter().for_each(|(column, component)| put(*column, value[*component]));
        }
    }

    /// The first three outputs of each pair in double precision, see [`Reflectance::exact_values`].
    pub fn run_exactly(&self, pairs: &[DirectionPair], place: &Place, numbers: &[[f32; 3]]) -> Vec<[f64; 3]> {
        let of_pair = |pair: &DirectionPair| {
            let directions = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3().normalize_or_zero());
            let mut columns = vec![0.0; self.variables.len()];
            self.read(directions, place, |column, value| columns[column] = value);
            let leaf = |id: NodeId| match self.variables.binary_search_by_key(&id, |(known, ..)| *known) {
                Ok(column) => columns[column],
                Err(_) => f64::from(self.parameter(id, numbers)),
            };
            let outputs = self.graph.evaluate_with(&mut Doubles, &self.outputs, leaf);
            std::array::from_fn(|component| outputs.get(component).copied().unwrap_or(0.0))
        };
        pairs.iter().map(of_pair).collect()
    }

    /// The value of a parameter; IL is white.
    fn parameter(&self, id: NodeId, numbers: &[[f32; 3]]) -> f32 {
        match self.graph.node(id) {
            Node::Parameter(parameter, _) if parameter == self.colour_of_light => 1.0,
            Node::Parameter(parameter, component) => {
                flush(numbers.get(parameter.0 as usize).map_or(0.0, |value| value[usize::from(component)]))
            }
            Node::Constant(_) | Node::Variable(..) | Node::Apply(..) => 0.0,
        }
    }

    /// The outputs of each pair, with these values of parameters; IL is white. Record after record.
    ///
    /// # Panics
    /// The pairs were prepared by a program that reads other variables.
    pub fn run(&self, prepared: &PreparedPairs, numbers: &[[f32; 3]]) -> Vec<f32> {
        let parameter = |id: NodeId| self.parameter(id, numbers);
        let uniforms: Vec<Splat> = self.graph.evaluate(&self.uniforms, parameter).into_iter().map(Splat::new).collect();
        let width = self.outputs.len();
        let mut result = vec![0.0; prepared.pairs * width];
        let targets = result.par_chunks_mut(BLOCK * width.max(1));
        targets.zip(&prepared.blocks).for_each(|(target, block)| match &self.kernel {
            Some(kernel) => self.run_kernel(kernel, block, &uniforms, target),
            None => self.run_reference(block, &parameter, target),
        });
        result
    }

    fn run_kernel(&self, kernel: &Kernel, block: &[Line], uniforms: &[Splat], target: &mut [f32]) {
        let (width, records) = (self.outputs.len(), target.len() / self.outputs.len().max(1));
        let lines = records.div_ceil(Line::RECORDS);
        let mut columns = vec![Line::default(); self.whole(records) * width];
        kernel.run([block, &[], &[]], uniforms, &mut [&mut columns], lines);
        for (record, outputs) in target.chunks_exact_mut(width).enumerate() {
            let (line, lane) = (record / Line::RECORDS, record % Line::RECORDS);
            for (column, output) in outputs.iter_mut().enumerate() {
                *output = columns[line * width + column].0[lane];
            }
        }
    }

    /// The same by the reference meaning.
    fn run_reference(&self, block: &[Line], parameter: &dyn Fn(NodeId) -> f32, target: &mut [f32]) {
        let (width, columns) = (self.outputs.len(), self.variables.len());
        for (record, outputs) in target.chunks_exact_mut(width).enumerate() {
            let (line, lane) = (record / Line::RECORDS, record % Line::RECORDS);
            let leaf = |id: NodeId| match self.variables.binary_search_by_key(&id, |(known, ..)| *known) {
                Ok(column) => block[line * columns + column].0[lane],
                Err(_) => parameter(id),
            };
            outputs.copy_from_slice(&self.graph.evaluate(&self.outputs, leaf));
        }
    }

    /// The lines that this many records take in a kernel.
    fn whole(&self, records: usize) -> usize {
        let lines = records.div_ceil(Line::RECORDS);
        self.kernel.as_ref().map_or(lines, |kernel| kernel.whole_rounds(lines))
    }
}

/// A formula with values of its parameters at a place: what its result is there.
#[derive(Clone)]
pub struct FormulaModel {
    program: Arc<ModelProgram>,
    numbers: ParameterNumbers,
    place: Place,
}

impl FormulaModel {
    /// A model by a program of the result of its formula, see [`ModelProgram::new`].
    pub fn new(program: Arc<ModelProgram>, numbers: ParameterNumbers, place: Place) -> Self {
        Self { program, numbers, place }
    }
}

impl Reflectance for FormulaModel {
    fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
        let numbers = self.program.run(&self.program.prepare(pairs, &self.place), &self.numbers);
        let (colours, _) = numbers.as_chunks::<3>();
        colours.to_vec()
    }

    fn exact_values(&self, pairs: &[DirectionPair]) -> Option<Vec<[f64; 3]>> {
        Some(self.program.run_exactly(pairs, &self.place, &self.numbers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::at_point::term_values;
    use crate::lang::source::Source;
    use crate::workspace::{FileKind, presets};
    use std::f32::consts::TAU;

    fn direction(polar: f32, azimuth: f32) -> [f32; 3] {
        [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
    }

    fn pairs(count: usize) -> Vec<DirectionPair> {
        let at = |index: usize, step: f32| (index as f32 * step).fract();
        let pair = |index| DirectionPair {
            light: direction(1.5 * at(index, 0.618), TAU * at(index, 0.755)),
            view: direction(1.5 * at(index, 0.57), TAU * at(index, 0.32)),
        };
        (1..=count).map(pair).collect()
    }

    #[test]
    fn built_in_formulas_have_their_values_in_one_block_and_in_several() {
        for name in presets::names(FileKind::Formula) {
            let (formula, _) = Formula::parse(&Source::new(name, presets::text(FileKind::Formula, name).unwrap())).unwrap();
            let program = ModelProgram::new(&formula);
            assert!(cfg!(not(target_arch = "x86_64")) || program.kernel.is_some(), "{name}");
            let numbers = default_numbers(&formula);
            for count in [1, 17, BLOCK + 33] {
                let pairs = pairs(count);
                let found = program.run(&program.prepare(&pairs, &Place::default()), &numbers);
                assert_eq!(found.len(), 3 * count);
                for (pair, found) in pairs.iter().zip(found.chunks(3)).skip(count.saturating_sub(40)) {
                    let [light, view] = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3());
                    let known = [(Variable::ToLight, light), (Variable::ToViewer, view)];
                    let given = |variable| known.iter().find(|(known, _)| *known == variable).map(|(_, value)| *value);
                    let variable = |variable| variable_at_point(variable, &given).unwrap().as_vec3().to_array();
                    let wanted = term_values(&formula, &variable, &|id| numbers[id.0 as usize]);
                    for (found, wanted) in found.iter().zip(wanted[formula.result.0 as usize]) {
                        let near = (found - wanted).abs() <= 1e-4 * wanted.abs().max(1.0);
                        assert!(near || found.is_nan() && wanted.is_nan(), "{name} {pair:?}: {found} {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_reference_meaning_stands_in_for_compiled_code() {
        let text = "body_specific; p: scalar, default 2; formula; = p*Cd*IL*<alpha, N.V, pow(0.5, p)>;";
        let (formula, _) = Formula::parse(&Source::new("test", text)).unwrap();
        let compiled = ModelProgram::with_derivatives(&formula, &[(formula.parameter_named("p").unwrap(), 0)]);
        let mut interpreted = ModelProgram::with_derivatives(&formula, &[(formula.parameter_named("p").unwrap(), 0)]);
        interpreted.kernel = None;
        let (pairs, mut numbers) = (pairs(100), default_numbers(&formula));
        numbers[formula.predefined(Predefined::LightColour).0 as usize] = [0.0; 3];
        let [one, other] = [compiled, interpreted].map(|program| {
            assert_eq!(program.outputs(), 6);
            program.run(&program.prepare(&pairs, &Place::default()), &numbers)
        });
        assert!(one.iter().zip(&other).all(|(one, other)| (one - other).abs() <= 1e-5), "{one:?} {other:?}");
        // Red is p · Cd · alpha under white light, and its derivative Cd · alpha.
        let alpha = pairs[4].light[2].acos();
        assert!((other[24] - 1.6 * alpha).abs() < 1e-6 && (other[27] - 0.8 * alpha).abs() < 1e-6);
    }

    #[test]
    fn double_precision_keeps_the_digits_of_differences() {
        let (formula, _) = Formula::parse(&Source::new("test", "formula; = IL*<1 - N.L*N.L>;")).unwrap();
        let model = FormulaModel::new(Arc::new(ModelProgram::new(&formula)), default_numbers(&formula), Place::default());
        let pair = DirectionPair { light: direction(1e-3, 0.3), view: direction(0.5, 0.0) };
        // sin² 0.001, as far as directions in single precision have that angle.
        let wanted = 1e-3_f64.sin().powi(2);
        let exact = model.exact_values(&[pair]).unwrap()[0][0];
        assert!((exact / wanted - 1.0).abs() < 1e-4, "{exact}");
        let single = f64::from(model.values(&[pair])[0][0]);
        assert!((single / wanted - 1.0).abs() > 1e-3, "{single}");
    }

    #[test]
    fn directions_are_turned_to_the_place() {
        let (formula, _) = Formula::parse(&Source::new("test", "formula; = L + <u, v, 0>;")).unwrap();
        let place = Place {
            frame: DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
            given: vec![(Variable::SurfaceU, DVec3::splat(0.25))],
        };
        let program = Arc::new(ModelProgram::new(&formula));
        let model = FormulaModel::new(program, default_numbers(&formula), place);
        let pair = DirectionPair { light: [0.6, 0.0, 0.8], view: [0.0, 0.0, 1.0] };
        assert_eq!(model.values(&[pair]), [[0.8 + 0.25, 0.6, 0.0]]);
    }
}
