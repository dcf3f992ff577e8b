//! The kernels that a formula needs while some of its parameter numbers move.

use crate::formula::binding::Bindings;
use crate::formula::graph::NodeId;
use crate::formula::layout::Layout;
use crate::formula::separation::{Dependence, Separation};
use crate::formula::{Parameter, ParameterId};
use crate::plan::contribution::ContributionPlan;
use crate::plan::kernel::Sink;

/// Components of parameters that move together, each counted from 0.
pub type Moved = [(ParameterId, u8)];

/// The components of parameters whose numbers have these indices in the layout: index, parameter and component, 0..3.
/// Indices beyond the layout are left out.
pub fn moved_parameters(layout: &Layout, parameters: &[Parameter], indices: &[usize]) -> Vec<(usize, ParameterId, u8)> {
    let moved = |index: &usize| {
        let (owner, _, slot) = layout.owner_of(*index)?;
        let holds = |parameter: &Parameter| {
            let first = parameter.slot as usize;
            parameter.owner == owner && (first..first + parameter.ty.slots()).contains(&slot)
        };
        let parameter = parameters.iter().position(holds)?;
        // A vector has three components.
        Some((*index, ParameterId(parameter as u32), (slot - parameters[parameter].slot as usize) as u8))
    };
    indices.iter().filter_map(moved).collect()
}

/// The kernels for a slider that moves some components of parameters.
#[derive(Debug, Clone)]
pub struct SliderPlan {
    /// Which parts of the contribution move, and the graph that all nodes belong to.
    pub separation: Separation,
    /// The components of the contribution that the moving kernels compute, 0 red, 1 green, 2 blue: none, one, or all
    /// three.
    pub channels: Vec<usize>,
    /// The part of the contribution of moved pairs that does not move, where it is not 0. All three components.
    pub fixed: Option<ContributionPlan>,
    /// If the contribution is separable, one plan for the image of each term, in the order of the terms. Otherwise one
    /// plan, for the live part.
    pub moving: Vec<ContributionPlan>,
    /// Values that do not move and that the moving part reads from columns, one for each lit record.
    pub columns: Option<ContributionPlan>,
}

/// The outputs of a kernel that is planned later.
struct Wanted {
    name: &'static str,
    outputs: Vec<NodeId>,
}

impl SliderPlan {
    /// Plans the kernels for a drag that moves these components of parameters.
    pub fn new(bindings: &Bindings, moved: &Moved) -> Self {
        let mut separation = Separation::new(bindings, moved);
        let [zero, one] = [0.0, 1.0].map(|value| separation.bindings.constant(value));
        let (mut channels, mut moving, stored) = moving_outputs(&separation.dependence, zero, one);
        // Kernels compute one component or all three: with two, the third is 0.
        if channels.len() == 2 {
            let given = std::mem::replace(&mut channels, vec![0, 1, 2]);
            for wanted in &mut moving {
                let outputs = (0..3).map(|channel| given.iter().position(|known| *known == channel));
                wanted.outputs = outputs.map(|output| output.map_or(zero, |output| wanted.outputs[output])).collect();
            }
        }
        let bindings = &separation.bindings;
        let moving = moving
            .into_iter()
            .map(|wanted| ContributionPlan::new(wanted.name, bindings, wanted.outputs, &stored, Sink::Sums))
            .collect();
        let some = separation.fixed.iter().flatten().any(|node| *node != zero);
        let fixed = (some && separation.dependence != Dependence::None).then(|| {
            let outputs = separation.fixed.map(|node| node.unwrap_or(zero)).to_vec();
            ContributionPlan::new("fixed", bindings, outputs, &[], Sink::Sums)
        });
        let columns =
            (!stored.is_empty()).then(|| ContributionPlan::new("columns", bindings, stored.clone(), &[], Sink::Columns));
        Self { channels, fixed, moving, columns, separation }
    }
}

/// The components that move, the outputs of the kernels for them, and the nodes that these read from columns.
fn moving_outputs(dependence: &Dependence, zero: NodeId, one: NodeId) -> (Vec<usize>, Vec<Wanted>, Vec<NodeId>) {
    match dependence {
        Dependence::None => Default::default(),
        Dependence::Separable(terms) => {
            let moves = |channel: &usize| terms.iter().any(|term| term.factors[*channel].is_some());
            let channels: Vec<usize> = (0..3).filter(moves).collect();
            let wanted = terms.iter().map(|term| {
                let part = |channel: &usize| match term.factors[*channel] {
                    Some(_) => term.parts[*channel].unwrap_or(one),
                    None => zero,
                };
                Wanted { name: "term", outputs: channels.iter().map(part).collect() }
            });
            (channels.clone(), wanted.collect(), Vec::new())
        }
        Dependence::Inseparable { moving, stored } => {
            let channels: Vec<usize> = (0..3).filter(|channel| moving[*channel].is_some()).collect();
            let outputs = channels.iter().map(|channel| moving[*channel].unwrap_or(zero)).collect();
            (channels, vec![Wanted { name: "moving", outputs }], stored.clone())
        }
    }
}
