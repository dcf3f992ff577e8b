//! A kernel as Cranelift IR: some nodes of a graph computed for every record, from columns and uniform values.
//!
//! The function reads `fn(reading, bases)`: a [`Reading`] says where its [streams](KernelPlan::streams) are, the uniform values (each in as many
//! lanes as any kernel has), and where outputs go, all counted from [`Bases`]; and how many rounds its loop has. A round is some steps side by
//! side, and a step a block of four records, or two or four blocks in code that is going to be [widened](super::widen). Whole rounds can be read, so
//! there is no tail.

use crate::formula::graph::{Graph, Node, NodeId};
use crate::jit::emit::{Emitter, LANES_BYTES, PERLIN_OPERANDS};
use crate::jit::lanes::{Line, Splat};
use crate::jit::step::{Bases, Reading};
use crate::jit::target::Target;
use crate::jit::widen::Spills;
use crate::lang::scalars::{Primitive, Scalars};
use crate::plan::{Domain, KernelPlan, STREAMS, Sink};
use crate::trace::ROUND_LINES;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{F32X4, I64};
use cranelift_codegen::ir::{
    AbiParam, FuncRef, Function, Inst, InstBuilder, MemFlagsData, Opcode, StackSlotData, StackSlotKind, Value,
};
use cranelift_codegen::isa::TargetIsa;
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use std::collections::{HashMap, HashSet};
use std::mem::offset_of;

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
    /// They are terms of sums. It stores them, each in a column of its own; products may be added in one instruction.
    OverwriteSums,
    /// They are terms of sums. It adds them to what is there.
    AddToSums,
}

/// At most this many steps are computed side by side. Four hide most of the latency of a polynomial's chain of multiplications.
pub(super) const MOST_STEPS: usize = ROUND_LINES;

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

    /// Whether there are enough records for wide vectors to be worth their while.
    fn wide(&self) -> bool {
        self.plan.domain != Domain::Pairs
    }

    /// The most steps that are computed side by side, a power of two, so that their chains of dependent instructions overlap and
    /// constants are loaded once for all of them. Columns are stored one step at a time: they end with their last line, not with
    /// a whole round.
    fn interleave(&self) -> usize {
        if self.output == Output::Columns { 1 } else { MOST_STEPS }
    }
}

/// How a plan is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    /// How many blocks of four records are a step: two or four in code that is going to be widened.
    pub(super) blocks: usize,
    /// How many steps are computed side by side.
    pub(super) interleave: usize,
    /// Whether the processor multiplies and adds in one instruction.
    pub(super) fma: bool,
}

/// The shapes that a plan may be written in, the quickest first, the one that always works last.
pub(super) fn shapes(spec: &KernelSpec, graph: &Graph, target: &Target) -> Vec<Shape> {
    let fma = target.fma;
    let narrow = Shape { blocks: 1, interleave: 1, fma };
    let few = spec.schedule(graph, narrow).is_some_and(|schedule| schedule.len() <= MANY_NODES);
    let interleave = if few { spec.interleave() } else { 1 };
    let mut shapes = Vec::new();
    for blocks in target.blocks.iter().copied().filter(|blocks| *blocks > 1 && spec.wide()) {
        let halves = std::iter::successors(Some(interleave), |interleave| (*interleave > 1).then_some(interleave / 2));
        shapes.extend(halves.map(|interleave| Shape { blocks, interleave, fma }));
    }
    shapes.push(Shape { interleave, ..narrow });
    shapes
}

impl Shape {
    /// Whether what does not fit the registers may go to the stack: only where no shape of as many lanes needs fewer.
    pub(super) fn spills(self) -> Spills {
        if self.interleave == 1 { Spills::Allowed } else { Spills::Refused }
    }

    /// How many blocks a round of the loop takes.
    pub(super) fn round(self) -> usize {
        self.blocks * self.interleave
    }

    /// How many lines are computed together at least.
    pub(super) fn lines(self) -> usize {
        self.round().div_ceil(Line::BLOCKS)
    }

    /// Bytes of a step in each column.
    fn bytes(self) -> usize {
        self.blocks * LANES_BYTES as usize
    }

    /// Bytes of a round in each column.
    fn round_bytes(self) -> usize {
        self.round() * LANES_BYTES as usize
    }

    /// Where a step of a round lies in a column of a stream of so many, in bytes from the beginning of the round.
    fn place(self, step: usize, columns: usize, column: usize) -> i32 {
        let bytes = self.bytes() * step;
        let (lines, within) = (bytes / LINE_BYTES, bytes % LINE_BYTES);
        // Kernels read far fewer columns than would fill 2³¹ bytes.
        ((lines * columns + column) * LINE_BYTES + within) as i32
    }
}

/// Bytes of a line of a column.
const LINE_BYTES: usize = size_of::<Line>();

/// An addend of an output: a node, or a product of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Addend {
    factor: NodeId,
    other: Option<NodeId>,
}

impl KernelSpec<'_> {
    /// The nodes that the kernel must compute before its addends, operands before their users. `None` where it would need a
    /// variable or parameter that it does not read.
    pub(super) fn schedule(&self, graph: &Graph, shape: Shape) -> Option<Vec<NodeId>> {
        let addends = self.addends(graph, shape).into_iter().flatten();
        self.plan.schedule(graph, addends.flat_map(|addend| [Some(addend.factor), addend.other]).flatten())
    }

    /// How many columns there are in each stream of outputs.
    pub(super) fn output_streams(&self) -> Vec<usize> {
        match self.output {
            Output::Columns => vec![self.plan.outputs.len()],
            Output::OverwriteSums | Output::AddToSums => vec![1; self.plan.outputs.len()],
        }
    }

    /// The addends of each output. Where outputs are terms of sums, and products can be added in one instruction, sums are
    /// taken apart; but not what several outputs share, which would be computed several times.
    fn addends(&self, graph: &Graph, shape: Shape) -> Vec<Vec<Addend>> {
        /// More addends than this are summed up before.
        const MOST: usize = 16;
        let mut users: HashMap<NodeId, usize> = HashMap::new();
        let stored: HashSet<NodeId> = self.plan.inputs().collect();
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
        let taken: Vec<Vec<NodeId>> = self.plan.outputs.iter().map(|root| leaves_of(*root)).collect();
        let plain = |id: NodeId| Addend { factor: id, other: None };
        let addend = |id: &NodeId| match parts(*id) {
            Some((Primitive::Mul, x, y)) if users[id] == 1 => Addend { factor: x, other: Some(y) },
            Some(_) | None => plain(*id),
        };
        let shared = |root: &NodeId| users[root] > 1;
        let outputs = self.plan.outputs.iter().zip(taken);
        outputs
            .map(|(root, leaves)| match self.output != Output::Columns && shape.fma && !shared(root) {
                true => leaves.iter().map(addend).collect(),
                false => vec![plain(*root)],
            })
            .collect()
    }
}

/// Whether a node calls the noise function.
pub(super) fn calls_perlin(graph: &Graph, id: NodeId) -> bool {
    matches!(graph.node(id), Node::Apply(Primitive::Perlin, _))
}

/// The parameters that every kernel has.
pub(super) fn parameters() -> [AbiParam; 2] {
    [AbiParam::new(I64); 2]
}

/// Beyond so many nodes steps are computed one after the other: side by side they would need far more registers than there are, and
/// there is enough to overlap within a step.
const MANY_NODES: usize = 60;

/// Writes a kernel with this schedule into an empty function with the [`parameters`]; `perlin` is there if it is called.
pub(super) fn write(
    spec: &KernelSpec,
    schedule: &[NodeId],
    graph: &Graph,
    isa: &dyn TargetIsa,
    shape: Shape,
    perlin: Option<FuncRef>,
    function: &mut Function,
) {
    let mut context = FunctionBuilderContext::new();
    let mut builder = FunctionBuilder::new(function, &mut context);
    let entry = builder.create_block();
    builder.append_block_params_for_function_params(entry);
    builder.switch_to_block(entry);
    let perlin = perlin.map(|function| {
        let size = (PERLIN_OPERANDS + 1) * LANES_BYTES;
        (function, builder.create_sized_stack_slot(StackSlotData::new(StackSlotKind::ExplicitSlot, size, 4)))
    });
    let [reading, bases] = std::array::from_fn(|index| builder.block_params(entry)[index]);
    let word = |builder: &mut FunctionBuilder, table: Value, offset: usize| {
        builder.ins().load(I64, MemFlagsData::trusted().with_readonly(), table, offset as i32)
    };
    let mut pointer = |from_base: usize, base: usize| {
        let [from_base, base] = [(reading, from_base), (bases, base)].map(|(table, offset)| word(&mut builder, table, offset));
        builder.ins().iadd(from_base, base)
    };
    let streams = std::array::from_fn(|index| {
        let own = index * size_of::<usize>();
        let read = !spec.plan.streams[index].is_empty();
        read.then(|| pointer(offset_of!(Reading, streams) + own, offset_of!(Bases, streams) + own))
    });
    let outputs = (0..spec.output_streams().len())
        .map(|index| pointer(offset_of!(Reading, outputs) + index * size_of::<usize>(), offset_of!(Bases, outputs)))
        .collect();
    let uniforms = pointer(offset_of!(Reading, uniforms), offset_of!(Bases, uniforms));
    let rounds = word(&mut builder, reading, offset_of!(Reading, rounds));
    let shift = builder.ins().iconst(I64, i64::from(shape.round_bytes().trailing_zeros()));
    let end = builder.ins().ishl(rounds, shift);
    let mut writer = Writer { spec, graph, schedule, builder, shape, perlin, streams, uniforms, outputs };
    writer.counted_loop(end);
    writer.builder.ins().return_(&[]);
    writer.builder.seal_all_blocks();
    writer.builder.finalize(isa.frontend_config());
}

struct Writer<'w, 'f> {
    spec: &'w KernelSpec<'w>,
    graph: &'w Graph,
    schedule: &'w [NodeId],
    builder: FunctionBuilder<'f>,
    shape: Shape,
    perlin: Option<(FuncRef, cranelift_codegen::ir::StackSlot)>,
    streams: [Option<Value>; STREAMS],
    uniforms: Value,
    outputs: Vec<Value>,
}

impl Writer<'_, '_> {
    /// The loop over all rounds, from offset 0 to `end`, in bytes of a column; leaves the writer in the block behind it.
    fn counted_loop(&mut self, end: Value) {
        let [head, body, exit] = [(); 3].map(|()| self.builder.create_block());
        let offset = self.builder.append_block_param(head, I64);
        let start = self.builder.ins().iconst(I64, 0);
        self.builder.ins().jump(head, &[start.into()]);
        self.builder.switch_to_block(head);
        let more = self.builder.ins().icmp(IntCC::UnsignedLessThan, offset, end);
        self.builder.ins().brif(more, body, &[], exit, &[]);
        self.builder.switch_to_block(body);
        self.body(offset, self.shape.interleave);
        let round = self.builder.ins().iconst(I64, self.shape.round_bytes() as i64);
        let next = self.builder.ins().iadd(offset, round);
        self.builder.ins().jump(head, &[next.into()]);
        // Behind the loop, so that nothing else stands between its instructions.
        self.builder.set_cold_block(exit);
        self.builder.switch_to_block(exit);
    }

    /// Computes the steps that begin at byte `offset` of a column, each node for all of them before the next node.
    fn body(&mut self, offset: Value, interleave: usize) {
        let flags = MemFlagsData::trusted();
        let offsets = std::array::from_fn(|stream| self.offset_in(offset, self.spec.plan.streams[stream].len()));
        let mut values: Vec<Vec<Value>> = vec![Vec::new(); self.graph.len()];
        for id in self.schedule {
            let node = self.graph.node(*id);
            for operand in node.operands() {
                self.read(*operand, &offsets, interleave, &mut values);
            }
            let mut copies = Vec::with_capacity(interleave);
            let mut computed = Vec::with_capacity(interleave);
            #[expect(clippy::needless_range_loop, reason = "it is the place in the values of every operand")]
            for step in 0..interleave {
                let before = self.last_instruction();
                let Shape { fma, blocks, .. } = self.shape;
                let (builder, sixteen) = (&mut self.builder, blocks == Line::BLOCKS);
                let mut emitter = Emitter { builder, fma, sixteen, perlin: self.perlin };
                computed.push(match node {
                    Node::Constant(bits) => emitter.constant(f32::from_bits(bits)),
                    Node::Apply(primitive, _) => {
                        let operands: Vec<Value> =
                            node.operands().iter().map(|operand| values[operand.0 as usize][step]).collect();
                        primitive.apply(&mut emitter, &operands)
                    }
                    Node::Variable(..) | Node::Parameter(..) => unreachable!("schedules hold no leaves"),
                });
                copies.push(self.instructions_after(before));
            }
            self.interleave(&copies);
            values[id.0 as usize] = computed;
        }
        let addends = self.spec.addends(self.graph, self.shape);
        let width = if self.spec.output == Output::Columns { addends.len() } else { 1 };
        let target = self.offset_in(offset, width);
        for (column, addends) in addends.iter().enumerate() {
            let pointer = self.outputs[column / width];
            let address = self.builder.ins().iadd(pointer, target);
            let shape = self.shape;
            let place = |step| shape.place(step, width, column % width);
            let mut sums: Vec<Option<Value>> = vec![None; interleave];
            if self.spec.output == Output::AddToSums {
                for (step, sum) in sums.iter_mut().enumerate() {
                    *sum = Some(self.builder.ins().load(F32X4, flags, address, place(step)));
                }
            }
            for Addend { factor, other } in addends {
                for operand in std::iter::once(factor).chain(other) {
                    self.read(*operand, &offsets, interleave, &mut values);
                }
                for (step, sum) in sums.iter_mut().enumerate() {
                    let [x, y] = [Some(*factor), *other].map(|node| node.map(|node| values[node.0 as usize][step]));
                    *sum = match (*sum, x, y) {
                        (Some(sum), Some(x), Some(y)) => Some(self.builder.ins().fma(x, y, sum)),
                        (Some(sum), Some(x), None) => Some(self.builder.ins().fadd(sum, x)),
                        (None, Some(x), Some(y)) => Some(self.builder.ins().fmul(x, y)),
                        (None, x, _) => x,
                        (sum, None, _) => sum,
                    };
                }
            }
            for (step, sum) in sums.into_iter().enumerate() {
                if let Some(sum) = sum {
                    self.builder.ins().store(flags, sum, address, place(step));
                }
            }
        }
    }

    fn last_instruction(&self) -> Option<Inst> {
        self.builder.func.layout.last_inst(self.builder.current_block()?)
    }

    /// What was written into the current block after an instruction.
    fn instructions_after(&self, before: Option<Inst>) -> Vec<Inst> {
        let layout = &self.builder.func.layout;
        let first = match before {
            Some(before) => layout.next_inst(before),
            None => self.builder.current_block().and_then(|block| layout.first_inst(block)),
        };
        std::iter::successors(first, |inst| layout.next_inst(*inst)).collect()
    }

    /// Puts instructions that were written step by step side by side: the first of each step, then the second of each. What is the same
    /// constant in all of them is loaded once.
    fn interleave(&mut self, copies: &[Vec<Inst>]) {
        let Some((first, others)) = copies.split_first() else { return };
        let Some(block) = self.builder.current_block() else { return };
        if others.is_empty() || others.iter().any(|other| other.len() != first.len()) {
            return;
        }
        let function = &mut *self.builder.func;
        // Calls pass their operands through one place on the stack: they stay in order.
        let ordered = |inst: &Inst| function.dfg.insts[*inst].opcode().is_call();
        if first.iter().any(ordered) {
            return;
        }
        copies.iter().flatten().for_each(|inst| function.layout.remove_inst(*inst));
        for (place, own) in first.iter().enumerate() {
            function.layout.append_inst(*own, block);
            for other in others.iter().map(|other| other[place]) {
                let constant = matches!(function.dfg.insts[*own].opcode(), Opcode::Vconst | Opcode::Iconst);
                if constant && function.dfg.insts[*own] == function.dfg.insts[other] {
                    function.dfg.replace_with_aliases(other, *own);
                } else {
                    function.layout.append_inst(other, block);
                }
            }
        }
    }

    /// Loads a node that is read from a column or the uniforms, at its first use: all at once they would not fit the registers.
    fn read(&mut self, id: NodeId, offsets: &[Value; STREAMS], interleave: usize, values: &mut [Vec<Value>]) {
        if !values[id.0 as usize].is_empty() {
            return;
        }
        let flags = MemFlagsData::trusted().with_readonly();
        for (index, stream) in self.spec.plan.streams.iter().enumerate() {
            let Some(column) = stream.iter().position(|node| *node == id) else { continue };
            let Some(pointer) = self.streams[index] else { continue };
            let address = self.builder.ins().iadd(pointer, offsets[index]);
            let places: Vec<i32> = (0..interleave).map(|step| self.shape.place(step, stream.len(), column)).collect();
            let load = |place| self.builder.ins().load(F32X4, flags, address, place);
            values[id.0 as usize] = places.into_iter().map(load).collect();
            return;
        }
        if let Some(uniform) = self.spec.plan.uniforms.iter().position(|node| *node == id) {
            let place = (size_of::<Splat>() * uniform) as i32;
            let value = self.builder.ins().load(F32X4, flags, self.uniforms, place);
            values[id.0 as usize] = vec![value; interleave];
        }
    }

    /// Where a round that begins at byte `offset` of a column begins in a stream of so many columns.
    fn offset_in(&mut self, offset: Value, columns: usize) -> Value {
        if columns <= 1 {
            return offset;
        }
        let whole_lines = self.shape.round_bytes().is_multiple_of(LINE_BYTES);
        let [mut lines, mut within] = [offset, offset];
        if !whole_lines {
            lines = self.builder.ins().band_imm_s(offset, -(LINE_BYTES as i64));
            within = self.builder.ins().band_imm_s(offset, LINE_BYTES as i64 - 1);
        }
        let lines = self.builder.ins().imul_imm_s(lines, columns as i64);
        if whole_lines { lines } else { self.builder.ins().iadd(lines, within) }
    }
}
