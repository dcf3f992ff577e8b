//! How kernels are compiled: their parts, shapes, and order of computation.
//!
//! 1. A kernel of many outputs is compiled in *parts*, functions that compute some of the outputs each. So the time of
//!    compilation is linear in the number of outputs. Register allocation of one large function may not be.
//! 2. A part may be written in several *shapes*: for wider or narrower vectors, which are computed side by side or one
//!    after the other. The quickest that works is taken.
//! 3. Registers are allocated with care. Where too many values are alive at a time, that would take long, and a quicker
//!    [allocation](Allocation) is used.
//!
//! [`writer`](super::writer) turns a part of some shape into instructions.

use crate::formula::graph::{Graph, Node, NodeId};
use crate::jit::emit::{Callee, LANES_BYTES};
use crate::jit::lanes::Line;
use crate::jit::target::{Allocation, Target};
use crate::jit::widen::Spills;
use crate::lang::scalars::Primitive;
use crate::plan::{Domain, KernelPlan, Schedule, Sink};
use crate::trace::ROUND_LINES;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// A kernel of a plan, as it is compiled.
#[derive(Debug, Clone, Copy)]
pub(super) struct KernelSpec<'p> {
    pub(super) plan: &'p KernelPlan,
    pub(super) output: Output,
}

/// How a kernel writes its outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Output {
    /// It stores them, in one stream.
    Columns,
    /// They are terms of sums. It stores them, each in a column of its own. Products may be added in one instruction.
    OverwriteSums,
    /// They are terms of sums. It adds them to the sums.
    AddToSums,
}

/// At most this many vectors are computed side by side. Four hide most of the latency of a polynomial's chain of
/// multiplications.
const MOST_INTERLEAVED: usize = ROUND_LINES;

impl<'p> KernelSpec<'p> {
    /// The kernel of a plan that stores its outputs.
    pub(super) fn overwriting(plan: &'p KernelPlan) -> Self {
        let output = match plan.sink {
            Sink::Columns => Output::Columns,
            Sink::Sums => Output::OverwriteSums,
        };
        Self { plan, output }
    }

    /// The kernel of a plan that adds its outputs to sums; one that stores columns has none.
    pub(super) fn adding(plan: &'p KernelPlan) -> Option<Self> {
        (plan.sink == Sink::Sums).then_some(Self { plan, output: Output::AddToSums })
    }

    /// Whether there are enough records for wide vectors.
    fn wide(&self) -> bool {
        self.plan.domain != Domain::Pairs
    }

    /// How many columns there are in each stream of outputs.
    pub(super) fn output_streams(&self) -> Vec<usize> {
        match self.output {
            Output::Columns => vec![self.plan.outputs.len()],
            Output::OverwriteSums | Output::AddToSums => vec![1; self.plan.outputs.len()],
        }
    }

    /// The parts in which it is compiled. A kernel of sums, which has at most three outputs, is one part.
    pub(super) fn parts(&self, graph: &Graph) -> Vec<KernelPart<'p>> {
        let whole = 0..self.plan.outputs.len();
        if self.output != Output::Columns {
            return vec![KernelPart { kernel: *self, outputs: whole }];
        }
        let size = |id: NodeId| match graph.node(id) {
            Node::Apply(primitive, _) => primitive.cost().min(LARGEST_NODE),
            Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => 1,
        };
        // A part computes again what it shares with earlier ones.
        let (mut earlier, mut own) = (HashSet::new(), Vec::new());
        let (mut new, mut repeated) = (0, 0);
        let mut schedule = Schedule::new(self.plan, graph);
        let mut parts = Vec::new();
        let mut first = 0;
        for output in whole.clone() {
            for id in schedule.further(graph, [self.plan.outputs[output]]).unwrap_or_default() {
                *if earlier.contains(&id) { &mut repeated } else { &mut new } += size(id);
                own.push(id);
            }
            if new >= PART_SIZE.max(repeated) {
                parts.push(KernelPart { kernel: *self, outputs: first..output + 1 });
                first = output + 1;
                (new, repeated) = (0, 0);
                earlier.extend(own.drain(..));
                schedule = Schedule::new(self.plan, graph);
            }
        }
        if first < whole.end || parts.is_empty() {
            parts.push(KernelPart { kernel: *self, outputs: first..whole.end });
        }
        parts
    }

    /// The most vectors that are computed side by side, a power of two. Their chains of dependent instructions overlap,
    /// and constants are loaded once for all of them. Columns are stored one vector at a time, because they end with
    /// their last line, not with a whole round.
    fn interleave(&self) -> usize {
        if self.output == Output::Columns { 1 } else { MOST_INTERLEAVED }
    }
}

/// A part with at least this many simple instructions is complete. It is compiled in a few milliseconds.
const PART_SIZE: u32 = 1 << 12;
/// The largest size of a primitive. Noise costs more, but is a call.
const LARGEST_NODE: u32 = 64;

/// A part of a kernel: a function that computes some of its outputs.
#[derive(Debug, Clone)]
pub(super) struct KernelPart<'p> {
    pub(super) kernel: KernelSpec<'p>,
    /// The outputs that it computes.
    pub(super) outputs: Range<usize>,
}

/// How a part is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LoopShape {
    /// The number of blocks of four records in a vector: two or four in code that is going to be widened.
    pub(super) blocks: usize,
    /// The number of vectors that are computed side by side.
    pub(super) interleave: usize,
    /// Whether the processor multiplies and adds in one instruction.
    pub(super) fma: bool,
}

impl LoopShape {
    /// Whether values that do not fit the registers may go to the stack. They may if no shape of the same width needs
    /// fewer registers.
    pub(super) fn spills(self) -> Spills {
        if self.interleave == 1 { Spills::Allowed } else { Spills::Refused }
    }

    /// The number of blocks in a round of the loop.
    pub(super) fn round(self) -> usize {
        self.blocks * self.interleave
    }

    /// The number of lines in a round, at least one.
    pub(super) fn lines(self) -> usize {
        self.round().div_ceil(Line::BLOCKS)
    }

    /// Bytes of a vector.
    fn bytes(self) -> usize {
        self.blocks * LANES_BYTES as usize
    }

    /// Bytes of a round in each column.
    pub(super) fn round_bytes(self) -> usize {
        self.round() * LANES_BYTES as usize
    }

    /// The offset of a vector of a round in a column of a stream of this many columns, in bytes from the beginning of
    /// the round.
    pub(super) fn offset(self, vector: usize, columns: usize, column: usize) -> i32 {
        let bytes = self.bytes() * vector;
        let (lines, within) = (bytes / LINE_BYTES, bytes % LINE_BYTES);
        // The columns that kernels read take far fewer than 2³¹ bytes.
        ((lines * columns + column) * LINE_BYTES + within) as i32
    }
}

/// Bytes of a line of a column.
pub(super) const LINE_BYTES: usize = size_of::<Line>();

/// An addend of an output: a node, or a product of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Addend {
    pub(super) factor: NodeId,
    pub(super) other: Option<NodeId>,
}

/// With more nodes than this, vectors are computed one after the other. Side by side, they would need far more
/// registers than there are, and one vector has enough independent instructions.
const MANY_NODES: usize = 60;

impl KernelPart<'_> {
    /// The possible shapes, the fastest first. The last one always works.
    pub(super) fn shapes(&self, graph: &Graph, target: &Target) -> Vec<LoopShape> {
        let fma = target.fma;
        let narrow = LoopShape { blocks: 1, interleave: 1, fma };
        let few = self.schedule(graph, narrow).is_some_and(|schedule| schedule.len() <= MANY_NODES);
        let interleave = if few { self.kernel.interleave() } else { 1 };
        let mut shapes = Vec::new();
        for blocks in target.blocks.iter().copied().filter(|blocks| *blocks > 1 && self.kernel.wide()) {
            let halves = std::iter::successors(Some(interleave), |interleave| (*interleave > 1).then_some(interleave / 2));
            shapes.extend(halves.map(|interleave| LoopShape { blocks, interleave, fma }));
        }
        shapes.push(LoopShape { interleave, ..narrow });
        shapes
    }

    /// The nodes to compute before the addends, operands before their users. `None` where a variable or parameter is
    /// needed that the kernel does not read.
    pub(super) fn schedule(&self, graph: &Graph, shape: LoopShape) -> Option<Vec<NodeId>> {
        let addends = self.addends(graph, shape).into_iter().flatten();
        self.kernel.plan.schedule(graph, addends.flat_map(|addend| [Some(addend.factor), addend.other]).flatten())
    }

    /// The addends of each of its outputs. If outputs are terms of sums, and one instruction can multiply and add,
    /// sums are split into addends. Sums that several outputs share are not split: they would be computed several
    /// times.
    pub(super) fn addends(&self, graph: &Graph, shape: LoopShape) -> Vec<Vec<Addend>> {
        /// The most addends. Further terms are summed up before.
        const MOST: usize = 16;
        let outputs = &self.kernel.plan.outputs[self.outputs.clone()];
        let mut users: HashMap<NodeId, usize> = HashMap::new();
        let stored: HashSet<NodeId> = self.kernel.plan.inputs().collect();
        let parts = |id: NodeId| match graph.node(id) {
            Node::Apply(primitive @ (Primitive::Add | Primitive::Mul), operands) if !stored.contains(&id) => {
                Some((primitive, operands[0], operands[1]))
            }
            Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => None,
        };
        let mut leaves_of = |root: NodeId| {
            let (mut pending, mut leaves) = (vec![root], Vec::new());
            while let Some(id) = pending.pop() {
                *users.entry(id).or_default() += 1;
                match parts(id) {
                    Some((Primitive::Add, x, y)) if leaves.len() + pending.len() < MOST => pending.extend([y, x]),
                    Some(_) | None => leaves.push(id),
                }
            }
            leaves
        };
        let taken: Vec<Vec<NodeId>> = outputs.iter().map(|root| leaves_of(*root)).collect();
        let plain = |id: NodeId| Addend { factor: id, other: None };
        let addend = |id: &NodeId| match parts(*id) {
            Some((Primitive::Mul, x, y)) if users[id] == 1 => Addend { factor: x, other: Some(y) },
            Some(_) | None => plain(*id),
        };
        let shared = |root: &NodeId| users[root] > 1;
        let outputs = outputs.iter().zip(taken);
        outputs
            .map(|(root, leaves)| match self.kernel.output != Output::Columns && shape.fma && !shared(root) {
                true => leaves.iter().map(addend).collect(),
                false => vec![plain(*root)],
            })
            .collect()
    }
}

/// Above this many nodes times values that are alive together, careful allocation would take more than some tenths of a
/// second.
const LARGEST_CAREFUL: usize = 1 << 20;

/// How registers are allocated to nodes that are computed in this order.
pub(super) fn allocation(schedule: &[NodeId], graph: &Graph) -> Allocation {
    let mut last_use: HashMap<NodeId, usize> = HashMap::new();
    for (index, id) in schedule.iter().enumerate() {
        last_use.insert(*id, schedule.len());
        last_use.extend(graph.node(*id).operands().iter().map(|operand| (*operand, index)));
    }
    // Nodes without a user in the schedule are addends: they are alive until the end.
    let mut ends = vec![0; schedule.len()];
    last_use.values().filter(|index| **index < schedule.len()).for_each(|index| ends[*index] += 1);
    let (mut alive, mut most) = (0_usize, 0);
    let mut seen = HashSet::new();
    for (id, ends) in schedule.iter().zip(ends) {
        let begins = graph.node(*id).operands().iter().chain([id]).filter(|node| seen.insert(**node)).count();
        alive += begins;
        most = most.max(alive);
        alive -= ends;
    }
    if schedule.len().saturating_mul(most) > LARGEST_CAREFUL { Allocation::Quick } else { Allocation::Careful }
}

/// The function that a node calls, if it calls one.
pub(super) fn callee(graph: &Graph, id: NodeId) -> Option<Callee> {
    match graph.node(id) {
        Node::Apply(primitive, _) => Callee::of(primitive),
        Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => None,
    }
}
