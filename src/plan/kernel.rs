//! One kernel: some nodes of a graph, computed for each record of its domain.

use crate::formula::graph::{Graph, Node, NodeId};

/// A kernel reads at most this many streams of columns: the hit frontier, the record frontier, and columns of a drag.
pub const STREAMS: usize = 3;

/// What the records of a kernel are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Domain {
    /// Hits.
    Hits,
    /// Lit records: pairs of a hit and a light that the formula is evaluated for.
    LitRecords,
    /// Pairs of a body and a light. Their number does not depend on the size of the picture.
    Pairs,
}

/// Where the outputs of a kernel go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sink {
    /// Each output is a column that is stored.
    Columns,
    /// Each output is one component of the contribution of a light to a hit. Contributions are summed over the
    /// lights.
    Sums,
}

/// What a kernel computes, and from what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KernelPlan {
    /// A name for listings.
    pub name: &'static str,
    /// The records that it is computed for.
    pub domain: Domain,
    /// Nodes that are read from columns, in the order of the columns of each stream. Each has one value for each
    /// record.
    pub streams: [Vec<NodeId>; STREAMS],
    /// Nodes that have one value for all records of a call, in the order of the uniform values.
    pub uniforms: Vec<NodeId>,
    /// Nodes that are computed, in the order of the outputs. Each has one value for each record.
    pub outputs: Vec<NodeId>,
    /// Where the outputs go.
    pub sink: Sink,
}

/// What a kernel does for one record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct KernelWork {
    /// What it computes, in [simple instructions](crate::lang::scalars::Primitive::cost).
    pub instructions: u32,
    /// How many numbers it reads from columns.
    pub columns: u32,
}

impl KernelPlan {
    /// The plan of a kernel that computes `outputs` from leaves, one column each, and stores them.
    pub(super) fn stage(name: &'static str, domain: Domain, leaves: Vec<NodeId>, outputs: Vec<NodeId>) -> Self {
        let streams = [leaves, Vec::new(), Vec::new()];
        Self { name, domain, streams, uniforms: Vec::new(), outputs, sink: Sink::Columns }
    }

    /// The nodes that are read: from columns and from uniform values.
    pub fn inputs(&self) -> impl Iterator<Item = NodeId> {
        self.streams.iter().flatten().chain(&self.uniforms).copied()
    }

    /// What it does for one record.
    pub fn work(&self, graph: &Graph) -> KernelWork {
        let mut uniform = vec![false; graph.len()];
        self.uniforms.iter().for_each(|node| uniform[node.0 as usize] = true);
        let mut column = vec![false; graph.len()];
        self.streams.iter().flatten().for_each(|node| column[node.0 as usize] = true);
        let mut seen = vec![false; graph.len()];
        let mut work = KernelWork::default();
        let mut pending = self.outputs.clone();
        while let Some(id) = pending.pop() {
            let index = id.0 as usize;
            if std::mem::replace(&mut seen[index], true) || uniform[index] {
                continue;
            }
            if column[index] {
                work.columns += 1;
            } else if let node @ Node::Apply(primitive, _) = graph.node(id) {
                work.instructions = work.instructions.saturating_add(primitive.cost());
                pending.extend_from_slice(node.operands());
            }
        }
        work
    }

    /// The nodes to compute for `roots`, operands before their users; inputs are not among them. `None` where a
    /// variable or a parameter is needed that is not an input.
    pub fn schedule(&self, graph: &Graph, roots: impl IntoIterator<Item = NodeId>) -> Option<Vec<NodeId>> {
        Schedule::new(self, graph).further(graph, roots)
    }
}

/// The nodes of a kernel that are computed so far.
#[derive(Debug, Clone)]
pub struct Schedule {
    /// Inputs count as computed.
    computed: Vec<bool>,
}

impl Schedule {
    /// Nothing is computed yet.
    pub fn new(plan: &KernelPlan, graph: &Graph) -> Self {
        let mut computed = vec![false; graph.len()];
        plan.inputs().for_each(|node| computed[node.0 as usize] = true);
        Self { computed }
    }

    /// The nodes to compute next for `roots`, operands before their users. `None` where a variable or a parameter is
    /// needed that is not an input.
    pub fn further(&mut self, graph: &Graph, roots: impl IntoIterator<Item = NodeId>) -> Option<Vec<NodeId>> {
        let mut found = Vec::new();
        let mut pending: Vec<NodeId> = roots.into_iter().collect();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut self.computed[id.0 as usize], true) {
                continue;
            }
            match graph.node(id) {
                Node::Variable(..) | Node::Parameter(..) => return None,
                node @ (Node::Constant(_) | Node::Apply(..)) => pending.extend_from_slice(node.operands()),
            }
            found.push(id);
        }
        // Nodes are numbered operands first.
        found.sort_unstable();
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::plan::{FormulaPlan, KernelWork};

    #[test]
    fn shared_nodes_and_columns_count_once() {
        let text = "body_specific; p: scalar; formula; Q = exp(p*alpha); = <Q, Q + Q, Q*alpha>;";
        let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
        let plan = FormulaPlan::new(&formula);
        let work = plan.contribution.records.work(&plan.bindings.graph);
        // p·α, the exponential, one sum, one product, and ki times three components.
        assert_eq!(work, KernelWork { instructions: 1 + 16 + 1 + 1 + 3, columns: 1 });
    }
}
