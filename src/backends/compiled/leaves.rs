//! What static kernels read: variables, and the numbers of the textures that they look up.

use crate::formula::graph::{Graph, Node};
use crate::formula::layout::Layout;
use crate::formula::{Formula, Parameter};
use crate::lang::scalars::flush;
use crate::lang::variables::{Owner, Variable};
use crate::plan::{FormulaPlan, KernelPlan, ParameterSlot, parameter_slots};
use crate::scene::{BodyId, LightId};
use crate::trace::HitVariables;

/// What a column that a static kernel reads holds.
#[derive(Clone, Copy)]
pub(super) enum StaticLeaf {
    /// A component of a variable.
    Variable(Variable, usize),
    /// The number of a texture.
    Texture(ParameterSlot),
}

impl StaticLeaf {
    /// The leaves of a static kernel, in the order of its columns.
    pub(super) fn of(plan: &KernelPlan, graph: &Graph, parameters: &[Parameter]) -> Vec<Self> {
        let mut slots = parameter_slots(plan, graph, parameters).into_iter();
        let leaf = |node| match graph.node(node) {
            Node::Variable(variable, component) => Some(StaticLeaf::Variable(variable, usize::from(component))),
            Node::Parameter(..) => slots.next().map(StaticLeaf::Texture),
            Node::Constant(_) | Node::Apply(..) => None,
        };
        plan.streams[0].iter().copied().filter_map(leaf).collect()
    }

    /// The variable, if it is one.
    pub(super) fn variable(&self) -> Option<Variable> {
        match self {
            StaticLeaf::Variable(variable, _) => Some(*variable),
            StaticLeaf::Texture(_) => None,
        }
    }
}

/// The numbers of the textures that static values of a formula were looked up in.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::backends) struct StaticTextures {
    layout: Layout,
    /// The indices of the numbers in the layout, in order, and the numbers.
    numbers: Vec<(usize, f32)>,
}

impl StaticTextures {
    /// The textures among parameter numbers. Numbers that are missing count as 0, white.
    pub(in crate::backends) fn new(plan: &FormulaPlan, formula: &Formula, layout: Layout, parameters: &[f32]) -> Self {
        let of = |kernel: &KernelPlan, graph| parameter_slots(kernel, graph, &formula.parameters);
        let graph = &plan.bindings.graph;
        let mut slots = of(&plan.hits, graph);
        slots.extend(of(&plan.records, graph));
        slots.extend(plan.surface.iter().flat_map(|surface| of(&surface.hits, &surface.bindings.graph)));
        let indices = |slot: &ParameterSlot| {
            let slot = *slot;
            (0..layout.owners(slot.owner)).map(move |owner| layout.row(slot.owner, owner) + slot.slot)
        };
        let mut indices: Vec<usize> = slots.iter().flat_map(indices).collect();
        indices.sort_unstable();
        indices.dedup();
        let mut textures = Self { layout, numbers: indices.into_iter().map(|index| (index, 0.0)).collect() };
        textures.numbers = textures.among(parameters).collect();
        textures
    }

    /// Whether no static value is looked up in a texture.
    pub(super) fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Whether the number with this index is that of one of the textures.
    pub(super) fn has(&self, index: usize) -> bool {
        self.numbers.binary_search_by_key(&index, |(known, _)| *known).is_ok()
    }

    /// Whether these parameter numbers have the same textures.
    pub(in crate::backends) fn are_in(&self, parameters: &[f32]) -> bool {
        self.among(parameters).eq(self.numbers.iter().copied())
    }

    fn among(&self, parameters: &[f32]) -> impl Iterator<Item = (usize, f32)> {
        self.numbers.iter().map(|(index, _)| (*index, flush(parameters.get(*index).copied().unwrap_or(0.0))))
    }

    /// The value of a leaf that is the same for all lights, at a hit on a body.
    pub(super) fn at_hit(&self, leaf: StaticLeaf, hit: &HitVariables, body: BodyId) -> f32 {
        match leaf {
            StaticLeaf::Variable(symbol, component) => hit.value(symbol).map_or(0.0, |value| value[component]),
            StaticLeaf::Texture(slot) => self.number(slot, body, None),
        }
    }

    /// The number of a texture on a body, in a light.
    pub(super) fn number(&self, slot: ParameterSlot, body: BodyId, light: Option<LightId>) -> f32 {
        let owner = match slot.owner {
            Owner::Global => 0,
            Owner::Body => body.index(),
            Owner::Light => light.map_or(0, LightId::index),
        };
        let index = self.layout.row(slot.owner, owner) + slot.slot;
        self.numbers.binary_search_by_key(&index, |(known, _)| *known).map_or(0.0, |at| self.numbers[at].1)
    }
}
