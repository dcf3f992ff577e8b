//! A part of a kernel as Cranelift IR: some nodes of a graph computed for every record, from columns and uniform
//! values.
//!
//! The function is `fn(call, bases)`. The [`KernelCall`] holds the offsets of the
//! [streams](crate::plan::KernelPlan::streams), of the uniform values (each in as many lanes as the widest vectors
//! have) and of the outputs, from [`Bases`]. It also holds the number of rounds of the loop. A round is some
//! vectors side by side. A vector is a block of four records, or two or four blocks in code that is going to be
//! [widened](super::widen). There are only whole rounds, so there is no tail.

use crate::formula::graph::{Graph, Node, NodeId};
use crate::jit::code_call::{Bases, KernelCall};
use crate::jit::emit::{Callee, Callees, LANES_BYTES, NodeEmitter};
use crate::jit::kernel::{Addend, KernelPart, LINE_BYTES, LoopShape, Output};
use crate::jit::lanes::{Line, Splat};
use crate::lang::scalars::Scalars;
use crate::plan::STREAMS;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{F32X4, I64};
use cranelift_codegen::ir::{
    AbiParam, FuncRef, Function, Inst, InstBuilder, MemFlagsData, Opcode, StackSlotData, StackSlotKind, Value,
};
use cranelift_codegen::isa::TargetIsa;
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};
use std::mem::offset_of;

/// The parameters that every kernel has.
pub(super) fn parameters() -> [AbiParam; 2] {
    [AbiParam::new(I64); 2]
}

/// Writes a part with this schedule into an empty function with the [`parameters`]. `callees` are the
/// functions that the part calls.
pub(super) fn write(
    part: &KernelPart,
    schedule: &[NodeId],
    graph: &Graph,
    isa: &dyn TargetIsa,
    shape: LoopShape,
    callees: [Option<FuncRef>; Callee::COUNT],
    function: &mut Function,
) {
    let mut context = FunctionBuilderContext::new();
    let mut builder = FunctionBuilder::new(function, &mut context);
    let entry = builder.create_block();
    builder.append_block_params_for_function_params(entry);
    builder.switch_to_block(entry);
    let callees: Callees = Callee::ALL.map(|callee| {
        let function = callees[callee as usize]?;
        let size = (callee.operands() + 1) * LANES_BYTES;
        Some((function, builder.create_sized_stack_slot(StackSlotData::new(StackSlotKind::ExplicitSlot, size, 4))))
    });
    let [call, bases] = std::array::from_fn(|index| builder.block_params(entry)[index]);
    let word = |builder: &mut FunctionBuilder, table: Value, offset: usize| {
        builder.ins().load(I64, MemFlagsData::trusted().with_readonly(), table, offset as i32)
    };
    let mut pointer = |from_base: usize, base: usize| {
        let [from_base, base] = [(call, from_base), (bases, base)].map(|(table, offset)| word(&mut builder, table, offset));
        builder.ins().iadd(from_base, base)
    };
    let streams = std::array::from_fn(|index| {
        let own = index * size_of::<usize>();
        let read = !part.kernel.plan.streams[index].is_empty();
        read.then(|| pointer(offset_of!(KernelCall, streams) + own, offset_of!(Bases, streams) + own))
    });
    let outputs = (0..part.kernel.output_streams().len())
        .map(|index| pointer(offset_of!(KernelCall, outputs) + index * size_of::<usize>(), offset_of!(Bases, outputs)))
        .collect();
    let uniforms = pointer(offset_of!(KernelCall, uniforms), offset_of!(Bases, uniforms));
    let rounds = word(&mut builder, call, offset_of!(KernelCall, rounds));
    let shift = builder.ins().iconst(I64, i64::from(shape.round_bytes().trailing_zeros()));
    let end = builder.ins().ishl(rounds, shift);
    let mut writer =
        Writer { part, graph, builder, shape, callees, streams, uniforms, outputs, values: vec![Vec::new(); graph.len()] };
    writer.counted_loop(schedule, end);
    writer.builder.ins().return_(&[]);
    writer.builder.seal_all_blocks();
    writer.builder.finalize(isa.frontend_config());
}

struct Writer<'w, 'f> {
    part: &'w KernelPart<'w>,
    graph: &'w Graph,
    builder: FunctionBuilder<'f>,
    shape: LoopShape,
    callees: Callees,
    streams: [Option<Value>; STREAMS],
    uniforms: Value,
    outputs: Vec<Value>,
    /// The values of each node that is read or computed, one for each vector of a round.
    values: Vec<Vec<Value>>,
}

impl Writer<'_, '_> {
    /// The loop over all rounds, from offset 0 to `end`, in bytes of a column. The writer ends in the basic
    /// block behind it.
    fn counted_loop(&mut self, schedule: &[NodeId], end: Value) {
        let [head, body, exit] = [(); 3].map(|()| self.builder.create_block());
        let offset = self.builder.append_block_param(head, I64);
        let start = self.builder.ins().iconst(I64, 0);
        self.builder.ins().jump(head, &[start.into()]);
        self.builder.switch_to_block(head);
        let more = self.builder.ins().icmp(IntCC::UnsignedLessThan, offset, end);
        self.builder.ins().brif(more, body, &[], exit, &[]);
        self.builder.switch_to_block(body);
        self.body(schedule, offset);
        let round = self.builder.ins().iconst(I64, self.shape.round_bytes() as i64);
        let next = self.builder.ins().iadd(offset, round);
        self.builder.ins().jump(head, &[next.into()]);
        // Placed after the loop, so that the loop body is contiguous.
        self.builder.set_cold_block(exit);
        self.builder.switch_to_block(exit);
    }

    /// Computes the vectors that begin at byte `offset` of a column.
    fn body(&mut self, schedule: &[NodeId], offset: Value) {
        let offsets = std::array::from_fn(|stream| self.offset_in(offset, self.part.kernel.plan.streams[stream].len()));
        let addends = self.part.addends(self.graph, self.shape);
        let width = if self.part.kernel.output == Output::Columns { self.part.kernel.plan.outputs.len() } else { 1 };
        for id in schedule {
            self.compute(*id, &offsets);
        }
        let target = self.offset_in(offset, width);
        for (output, addends) in self.part.outputs.clone().zip(&addends) {
            self.write_output(output, addends, width, target, &offsets);
        }
    }

    /// Computes a node, for all vectors of a round before the next node.
    fn compute(&mut self, id: NodeId, offsets: &[Value; STREAMS]) {
        let node = self.graph.node(id);
        for operand in node.operands() {
            self.read(*operand, offsets);
        }
        let mut copies = Vec::with_capacity(self.shape.interleave);
        let mut computed = Vec::with_capacity(self.shape.interleave);
        for vector in 0..self.shape.interleave {
            let before = self.last_instruction();
            let LoopShape { fma, blocks, .. } = self.shape;
            let mut emitter =
                NodeEmitter { builder: &mut self.builder, fma, sixteen: blocks == Line::BLOCKS, callees: self.callees };
            computed.push(match node {
                Node::Constant(bits) => emitter.constant(f32::from_bits(bits)),
                Node::Apply(primitive, _) => {
                    let operands: Vec<Value> =
                        node.operands().iter().map(|operand| self.values[operand.0 as usize][vector]).collect();
                    primitive.apply(&mut emitter, &operands)
                }
                Node::Variable(..) | Node::Parameter(..) => unreachable!("only constants and operations are computed"),
            });
            copies.push(self.instructions_after(before));
        }
        self.interleave(&copies);
        self.values[id.0 as usize] = computed;
    }

    /// Sums up the addends of an output and writes it, into a stream of `width` columns at `target`.
    fn write_output(&mut self, output: usize, addends: &[Addend], width: usize, target: Value, offsets: &[Value; STREAMS]) {
        let flags = MemFlagsData::trusted();
        let shape = self.shape;
        let pointer = self.outputs[output / width];
        let address = self.builder.ins().iadd(pointer, target);
        let offset = |vector| shape.offset(vector, width, output % width);
        let mut sums: Vec<Option<Value>> = vec![None; shape.interleave];
        if self.part.kernel.output == Output::AddToSums {
            for (vector, sum) in sums.iter_mut().enumerate() {
                *sum = Some(self.builder.ins().load(F32X4, flags, address, offset(vector)));
            }
        }
        for Addend { factor, other } in addends {
            for operand in std::iter::once(factor).chain(other) {
                self.read(*operand, offsets);
            }
            for (vector, sum) in sums.iter_mut().enumerate() {
                let [x, y] = [Some(*factor), *other].map(|node| node.map(|node| self.values[node.0 as usize][vector]));
                *sum = match (*sum, x, y) {
                    (Some(sum), Some(x), Some(y)) => Some(self.builder.ins().fma(x, y, sum)),
                    (Some(sum), Some(x), None) => Some(self.builder.ins().fadd(sum, x)),
                    (None, Some(x), Some(y)) => Some(self.builder.ins().fmul(x, y)),
                    (None, x, _) => x,
                    (sum, None, _) => sum,
                };
            }
        }
        for (vector, sum) in sums.into_iter().enumerate() {
            if let Some(sum) = sum {
                self.builder.ins().store(flags, sum, address, offset(vector));
            }
        }
    }

    fn last_instruction(&self) -> Option<Inst> {
        self.builder.func.layout.last_inst(self.builder.current_block()?)
    }

    /// The instructions of the current basic block that come after one.
    fn instructions_after(&self, before: Option<Inst>) -> Vec<Inst> {
        let layout = &self.builder.func.layout;
        let first = match before {
            Some(before) => layout.next_inst(before),
            None => self.builder.current_block().and_then(|block| layout.first_inst(block)),
        };
        std::iter::successors(first, |inst| layout.next_inst(*inst)).collect()
    }

    /// Interleaves the instructions of several vectors: the first of each, then the second of each. A constant that is
    /// the same in all of them is loaded once.
    fn interleave(&mut self, copies: &[Vec<Inst>]) {
        let Some((first, others)) = copies.split_first() else { return };
        let Some(block) = self.builder.current_block() else { return };
        if others.is_empty() || others.iter().any(|other| other.len() != first.len()) {
            return;
        }
        let function = &mut *self.builder.func;
        // Calls pass their operands through one stack slot: they stay in order.
        let ordered = |inst: &Inst| function.dfg.insts[*inst].opcode().is_call();
        if first.iter().any(ordered) {
            return;
        }
        copies.iter().flatten().for_each(|inst| function.layout.remove_inst(*inst));
        for (index, own) in first.iter().enumerate() {
            function.layout.append_inst(*own, block);
            for other in others.iter().map(|other| other[index]) {
                let constant = matches!(function.dfg.insts[*own].opcode(), Opcode::Vconst | Opcode::Iconst);
                if constant && function.dfg.insts[*own] == function.dfg.insts[other] {
                    function.dfg.replace_with_aliases(other, *own);
                } else {
                    function.layout.append_inst(other, block);
                }
            }
        }
    }

    /// Loads a node that is read from a column or the uniform values, at its first use: all at once they would not fit
    /// the registers.
    fn read(&mut self, id: NodeId, offsets: &[Value; STREAMS]) {
        if !self.values[id.0 as usize].is_empty() {
            return;
        }
        let interleave = self.shape.interleave;
        let flags = MemFlagsData::trusted().with_readonly();
        for (index, stream) in self.part.kernel.plan.streams.iter().enumerate() {
            let Some(column) = stream.iter().position(|node| *node == id) else { continue };
            let Some(pointer) = self.streams[index] else { continue };
            let address = self.builder.ins().iadd(pointer, offsets[index]);
            let vector_offsets: Vec<i32> =
                (0..interleave).map(|vector| self.shape.offset(vector, stream.len(), column)).collect();
            let load = |offset| self.builder.ins().load(F32X4, flags, address, offset);
            self.values[id.0 as usize] = vector_offsets.into_iter().map(load).collect();
            return;
        }
        if let Some(uniform) = self.part.kernel.plan.uniforms.iter().position(|node| *node == id) {
            let offset = (size_of::<Splat>() * uniform) as i32;
            let value = self.builder.ins().load(F32X4, flags, self.uniforms, offset);
            self.values[id.0 as usize] = vec![value; interleave];
        }
    }

    /// The offset in a stream of this many columns of the round that begins at byte `offset` of a column.
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
