//! Nodes of a plan as statements of WGSL.

use crate::export::wgsl_primitive;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::scalars::Primitive;
use crate::plan::{KernelPlan, Schedule};
use std::collections::HashMap;
use std::fmt::Write;

/// How a primitive is written.
enum PrimitiveForm {
    /// As WGSL writes it.
    Natively,
    /// As WGSL writes it, and the compiler must not change it.
    Strictly,
    /// By a function of `functions.wgsl`, or that of noise.
    By(&'static str),
}

impl PrimitiveForm {
    fn of(primitive: Primitive) -> PrimitiveForm {
        match primitive {
            Primitive::Neg | Primitive::Abs | Primitive::Floor | Primitive::Ceil => PrimitiveForm::Natively,
            Primitive::Min | Primitive::Max | Primitive::Select => PrimitiveForm::Natively,
            Primitive::Less | Primitive::LessEqual | Primitive::Equal => PrimitiveForm::Natively,
            Primitive::And | Primitive::Or | Primitive::Not => PrimitiveForm::Natively,
            Primitive::Add | Primitive::Sub | Primitive::Mul | Primitive::Sqrt => PrimitiveForm::Strictly,
            Primitive::Div => PrimitiveForm::By("divided"),
            Primitive::Exp => PrimitiveForm::By("exponential"),
            Primitive::Exp2 => PrimitiveForm::By("exponential_2"),
            Primitive::Log => PrimitiveForm::By("logarithm"),
            Primitive::Log2 => PrimitiveForm::By("logarithm_2"),
            Primitive::Pow => PrimitiveForm::By("power"),
            Primitive::Sin => PrimitiveForm::By("sine"),
            Primitive::Cos => PrimitiveForm::By("cosine"),
            Primitive::Tan => PrimitiveForm::By("tangent"),
            Primitive::Asin => PrimitiveForm::By("arc_sine"),
            Primitive::Acos => PrimitiveForm::By("arc_cosine"),
            Primitive::Atan => PrimitiveForm::By("arc_tangent"),
            Primitive::Atan2 => PrimitiveForm::By("arc_tangent_2"),
            Primitive::Perlin => PrimitiveForm::By("noise_sum"),
            Primitive::Texture => PrimitiveForm::By("texture_component"),
            // Formulas that compute it on the device are refused before.
            Primitive::Measured => PrimitiveForm::By("measured_component"),
        }
    }
}

/// Whether the operands of a primitive are truth values: the first ones, this many.
fn truth_operands(primitive: Primitive) -> usize {
    match primitive {
        Primitive::And | Primitive::Or => 2,
        Primitive::Not | Primitive::Select => 1,
        Primitive::Neg
        | Primitive::Add
        | Primitive::Sub
        | Primitive::Mul
        | Primitive::Div
        | Primitive::Sqrt
        | Primitive::Floor
        | Primitive::Ceil
        | Primitive::Abs
        | Primitive::Min
        | Primitive::Max
        | Primitive::Exp
        | Primitive::Exp2
        | Primitive::Log
        | Primitive::Log2
        | Primitive::Pow
        | Primitive::Sin
        | Primitive::Cos
        | Primitive::Tan
        | Primitive::Asin
        | Primitive::Acos
        | Primitive::Atan
        | Primitive::Atan2
        | Primitive::Perlin
        | Primitive::Texture
        | Primitive::Measured
        | Primitive::Less
        | Primitive::LessEqual
        | Primitive::Equal => 0,
    }
}

/// A value in the text.
struct KernelValue {
    text: String,
    is_truth: bool,
}

impl KernelValue {
    fn number(&self) -> String {
        if self.is_truth { format!("select(0.0, 1.0, {})", self.text) } else { self.text.clone() }
    }

    fn truth(&self) -> String {
        // NaN is not 0.
        if self.is_truth { self.text.clone() } else { format!("(!({} == 0.0))", self.text) }
    }
}

/// Statements that compute the outputs of a plan.
pub(super) struct Statements<'g> {
    graph: &'g Graph,
    schedule: Schedule,
    known: HashMap<NodeId, KernelValue>,
    text: String,
}

impl<'g> Statements<'g> {
    /// No statements yet.
    pub(super) fn new(plan: &KernelPlan, graph: &'g Graph) -> Self {
        Self { graph, schedule: Schedule::new(plan, graph), known: HashMap::new(), text: String::new() }
    }

    /// Loads the nodes of a list, each from its place there.
    pub(super) fn load(&mut self, nodes: &[NodeId], place: impl Fn(usize) -> String) {
        for (index, node) in nodes.iter().enumerate() {
            let name = format!("n{}", node.0);
            let _ = writeln!(self.text, "        let {name} = {};", place(index));
            self.known.insert(*node, KernelValue { text: name, is_truth: false });
        }
    }

    /// Computes nodes.
    pub(super) fn compute(&mut self, nodes: &[NodeId]) {
        // A plan reads all variables and parameters that it needs.
        for id in self.schedule.further(self.graph, nodes.iter().copied()).unwrap_or_default() {
            let value = match self.graph.node(id) {
                Node::Constant(bits) => KernelValue { text: constant(f32::from_bits(bits)), is_truth: false },
                node @ Node::Apply(primitive, _) => self.applied(id, primitive, node.operands()),
                Node::Variable(..) | Node::Parameter(..) => continue,
            };
            self.known.insert(id, value);
        }
    }

    /// Writes the statement of a primitive.
    fn applied(&mut self, id: NodeId, primitive: Primitive, operands: &[NodeId]) -> KernelValue {
        let truths = truth_operands(primitive);
        let known = |node: &NodeId| self.known.get(node);
        let chosen = |node: &NodeId| known(node).is_some_and(|value| value.is_truth);
        let chooses_truth = primitive == Primitive::Select && operands[1..].iter().all(chosen);
        let texts: Vec<String> = (0..)
            .zip(operands)
            .map(|(index, node)| match known(node) {
                Some(value) if index < truths || chooses_truth => value.truth(),
                Some(value) => value.number(),
                None => constant(f32::NAN),
            })
            .collect();
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        let value = match PrimitiveForm::of(primitive) {
            PrimitiveForm::Natively => wgsl_primitive(primitive, &texts),
            PrimitiveForm::Strictly => format!("strict({})", wgsl_primitive(primitive, &texts)),
            PrimitiveForm::By(function) => format!("{function}({})", texts.join(", ")),
        };
        let name = format!("n{}", id.0);
        let _ = writeln!(self.text, "        let {name} = {value};");
        KernelValue { text: name, is_truth: primitive.yields_truth() || chooses_truth }
    }

    /// A computed node as a number.
    pub(super) fn number(&self, node: NodeId) -> String {
        self.known.get(&node).map_or_else(|| constant(f32::NAN), KernelValue::number)
    }

    /// Three computed nodes as a vector.
    pub(super) fn vector(&self, nodes: [NodeId; 3]) -> String {
        format!("vec3<f32>({})", nodes.map(|node| self.number(node)).join(", "))
    }

    /// Takes the statements so far.
    pub(super) fn take(&mut self) -> String {
        std::mem::take(&mut self.text)
    }
}

/// A number. What a compiler might calculate with by rules for finite numbers is kept from it.
fn constant(number: f32) -> String {
    if number == 0.0 || !number.is_finite() {
        format!("opaque({:#x}u)", number.to_bits())
    } else if number < 0.0 {
        format!("({number:?})")
    } else {
        format!("{number:?}")
    }
}
