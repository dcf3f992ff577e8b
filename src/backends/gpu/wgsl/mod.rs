//! The kernel of a formula as WGSL text.
//!
//! `picture.wgsl` evaluates equation (2) for a pixel, with gaps for the nodes of the formula's plan, which
//! [`nodes`] writes. `functions.wgsl` holds the operations that WGSL leaves to the device. They follow those of
//! compiled code and have their coefficients.

mod needed;
mod nodes;

use crate::export::wgsl_noise;
use crate::jit::math::exponential as powers;
use crate::jit::math::trigonometric as angles;
use crate::jit::math::{FRAC_PI_2_TAIL, ROUNDER, inverse};
use crate::plan::{FormulaPlan, SurfacePlan};
use crate::trace::MAX_DEPTH;
use nodes::Statements;
use std::f32::consts::{FRAC_1_PI, FRAC_2_PI, FRAC_PI_2, LOG2_E, PI};
use std::fmt::Write;

/// The entry point of the kernel.
pub(super) const ENTRY: &str = "add_up";

/// Pixels that a workgroup computes.
pub(super) const WORKGROUP: u32 = 64;

const PICTURE: &str = include_str!("picture.wgsl");
const FUNCTIONS: &str = include_str!("functions.wgsl");

/// Numbers of functions.
const CONSTANTS: [(&str, f32); 22] = [
    ("LOG2_E", LOG2_E),
    ("LN_2_HEAD", powers::LN_2_HEAD),
    ("LN_2_TAIL", powers::LN_2_TAIL),
    ("TWO_LOG2_E", powers::TWO_LOG2_E),
    ("TWO_LOG2_E_HEAD", powers::TWO_LOG2_E_HEAD),
    ("TWO_LOG2_E_TAIL", powers::TWO_LOG2_E_TAIL),
    ("TAIL_LIMIT", powers::TAIL_LIMIT),
    ("FIELD", 1.0 / (1 << 23) as f32),
    ("ROUNDER", ROUNDER),
    ("FRAC_1_PI", FRAC_1_PI),
    ("FRAC_2_PI", FRAC_2_PI),
    ("FRAC_PI_2", FRAC_PI_2),
    ("FRAC_PI_2_TAIL", FRAC_PI_2_TAIL),
    ("PI", PI),
    ("PI_0", angles::PI_SHORT[0]),
    ("PI_1", angles::PI_SHORT[1]),
    ("PI_2", angles::PI_SHORT[2]),
    ("PI_3", angles::PI_SHORT[3]),
    ("PI_4", angles::PI_SHORT[4]),
    ("PI_5", angles::PI_SHORT[5]),
    ("PI_6", angles::PI_SHORT[6]),
    ("TAN_RANGE", angles::TAN_RANGE),
];

/// Polynomials of functions.
const POLYNOMIALS: [(&str, &[f32]); 10] = [
    ("exp2", &powers::EXP2),
    ("exp", &powers::EXP),
    ("log2", &powers::LOG2),
    ("log", &powers::LOG),
    ("artanh", &powers::ARTANH),
    ("sin", &angles::SIN),
    ("tan", &angles::TAN),
    ("asin", &inverse::ASIN),
    ("acos", &inverse::ACOS),
    ("atan", &inverse::ATAN),
];

/// The kernel of a formula.
pub(super) fn kernel(plan: &FormulaPlan, keeps_subnormals: bool) -> String {
    let records = &plan.contribution.records;
    let mut statements = Statements::new(records, &plan.bindings.graph);
    statements.load(&records.streams[0], |index| column("columns", "line.x * 16u + lane", index));
    let hits = statements.take();
    statements.load(&records.streams[1], |index| column("columns", "record", index));
    statements.load(&records.uniforms, |index| format!("numbers[uniforms + {index}u]"));
    statements.compute(&records.outputs);
    let outputs = [records.outputs[0], records.outputs[1], records.outputs[2]];
    let result = statements.vector(outputs);
    let (given, weights) = plan.surface.as_ref().map(surface).unwrap_or_default();
    let weighed = |index: usize, name: &str| match weights[index] {
        true => format!("weighed_by(own.{name}, {name})"),
        false => {
            let parts = ["x", "y", "z"].map(|part| format!("weighed(numbers[weights + {index}u], {name}.{part})"));
            format!("vec3<f32>({})", parts.join(", "))
        }
    };
    let picture = PICTURE
        .replace("@HIT_COLUMNS@", hits.trim_end())
        .replace("@CONTRIBUTION@", statements.take().trim_end())
        .replace("@UNIFORMS@", &records.uniforms.len().to_string())
        .replace("@RESULT@", &result)
        .replace("@GIVEN@", given.trim_end())
        .replace("@REFLECTED@", &weighed(0, "reflected"))
        .replace("@REFRACTED@", &weighed(1, "refracted"))
        .replace("@LEVELS@", &(MAX_DEPTH + 1).to_string());
    needed::with_definitions(picture, &definitions(keeps_subnormals))
}

/// The statements for what a formula gives at a hit, and whether it gives the weights of rays.
fn surface(plan: &SurfacePlan) -> (String, [bool; 2]) {
    let records = &plan.outputs.records;
    let mut statements = Statements::new(records, &plan.bindings.graph);
    let columns = records.streams[0].len();
    statements.load(&records.streams[0], |index| {
        let first = format!("(nodes[hit] >> 4u) * {}u + (nodes[hit] & 15u)", 16 * columns);
        column("hit_columns", &first, index)
    });
    statements.load(&records.uniforms, |index| format!("numbers[frame.bodies + body * {}u + {index}u]", records.uniforms.len()));
    statements.compute(&records.outputs);
    let mut text = statements.take();
    let [reflected, refracted] = plan.nodes.weights;
    for (name, nodes) in [("own", plan.nodes.own), ("reflected", reflected), ("refracted", refracted)] {
        if let Some(nodes) = nodes {
            let _ = writeln!(text, "        result.{name} = {};", statements.vector(nodes));
        }
    }
    (text, plan.nodes.weights.map(|nodes| nodes.is_some()))
}

/// A number in a column of lines. `first` is where that of the first column is.
fn column(columns: &str, first: &str, index: usize) -> String {
    format!("{columns}[{first} + {}u]", 16 * index)
}

/// The functions that kernels call.
fn definitions(keeps_subnormals: bool) -> Vec<String> {
    let constants = CONSTANTS.iter().map(|(name, number)| format!("const {name}: f32 = {number:?};"));
    let polynomials = POLYNOMIALS.iter().map(|(name, coefficients)| {
        let mut descending = coefficients.iter().rev();
        let first = descending.next().map(|number| format!("{number:?}")).unwrap_or_default();
        let sum = descending.fold(first, |sum, number| format!("({sum}) * x + {number:?}"));
        format!("fn polynomial_{name}(x: f32) -> f32 {{ return {sum}; }}")
    });
    let strict = if keeps_subnormals { SUBNORMALS_AS_ZERO } else { AS_IT_IS };
    let functions = FUNCTIONS.split("\n\n").map(str::to_owned);
    constants.chain(polynomials).chain([strict.to_owned()]).chain(functions).chain([wgsl_noise()]).collect()
}

/// Keeps a result from being changed by the compiler.
const AS_IT_IS: &str = "fn strict(x: f32) -> f32 { return opaque(bitcast<u32>(x)); }\n";
/// The same on a device that knows subnormal numbers.
const SUBNORMALS_AS_ZERO: &str = "fn strict(x: f32) -> f32 {
    let bits = bitcast<u32>(x) ^ frame.zero;
    return bitcast<f32>(select(bits, bits & SIGN, (bits & INFINITE) == 0u));
}
";

/// A kernel that computes a primitive once for each row of operands, and keeps the results.
#[cfg(test)]
pub(super) fn primitive_kernel(primitive: crate::lang::scalars::Primitive, keeps_subnormals: bool) -> String {
    use crate::formula::ParameterId;
    use crate::formula::graph::{Graph, Node, NodeId};
    use crate::lang::scalars::Primitive;
    use crate::plan::{Domain, KernelPlan, Sink};
    let mut graph = Graph::empty(Vec::new().into());
    let leaf = |graph: &mut Graph, index: usize| graph.insert(Node::Parameter(ParameterId(index as u32), 0));
    let leaves: Vec<NodeId> = (0..primitive.arity()).map(|index| leaf(&mut graph, index)).collect();
    let mut operands = [NodeId(0); Primitive::MAX_ARITY];
    operands[..leaves.len()].copy_from_slice(&leaves);
    let output = graph.insert(Node::Apply(primitive, operands));
    let streams = [leaves.clone(), Vec::new(), Vec::new()];
    let (domain, sink) = (Domain::Hits, Sink::Columns);
    let plan = KernelPlan { name: "test", domain, streams, uniforms: Vec::new(), outputs: vec![output], sink };
    let mut statements = Statements::new(&plan, &graph);
    statements.load(&leaves, |index| format!("operands[id.x * {}u + {index}u]", leaves.len()));
    statements.compute(&plan.outputs);
    let (body, result) = (statements.take(), statements.number(output));
    let text = format!(
        "@group(0) @binding(0) var<uniform> frame: Frame;
struct Frame {{ zero: u32 }}
@group(0) @binding(1) var<storage, read> operands: array<f32>;
@group(0) @binding(2) var<storage, read_write> results: array<f32>;
@compute @workgroup_size(1) fn compute(@builtin(global_invocation_id) id: vec3<u32>) {{
{body}        results[id.x] = opaque(bitcast<u32>({result}));
}}"
    );
    needed::with_definitions(text, &definitions(keeps_subnormals))
}
