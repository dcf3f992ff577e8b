//! A kernel as Cranelift IR: some nodes of a graph computed for every record, from columns and uniform values.
//!
//! The function reads `fn(columns, uniforms, outputs, blocks)`: pointers to the columns, to the uniform values (each four times, as
//! lanes), to the output columns, and the number of blocks of four records. Columns are whole blocks, so that there is no tail.

use crate::formula::graph::{Graph, Node, NodeId};
use crate::jit::emit::{Emitter, LANES_BYTES, PERLIN_OPERANDS};
use crate::lang::scalars::{Primitive, Scalars};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{F32X4, I64};
use cranelift_codegen::ir::{AbiParam, FuncRef, Function, InstBuilder, MemFlagsData, StackSlotData, StackSlotKind, Value};
use cranelift_codegen::isa::TargetIsa;
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext};

/// What a kernel computes, and from what.
#[derive(Debug, Clone)]
pub(super) struct KernelPlan {
    /// For dumps and symbols.
    pub(super) name: &'static str,
    /// Nodes that are read from columns, in their order.
    pub(super) columns: Vec<NodeId>,
    /// Nodes that are the same for all records, in their order.
    pub(super) uniforms: Vec<NodeId>,
    /// Nodes that are written to the output columns, in their order.
    pub(super) outputs: Vec<NodeId>,
    /// Whether outputs are added to what is there rather than stored.
    pub(super) accumulate: bool,
    /// How many blocks are computed side by side, so that their chains of dependent instructions overlap.
    pub(super) interleave: usize,
}

impl KernelPlan {
    /// The nodes that the kernel must compute, operands before their users; where it reads a node it does not look behind it.
    /// None where it would need a variable or parameter that it does not read.
    pub(super) fn schedule(&self, graph: &Graph) -> Option<Vec<NodeId>> {
        let mut seen = vec![false; graph.len()];
        self.columns.iter().chain(&self.uniforms).for_each(|node| seen[node.0 as usize] = true);
        let mut found = Vec::new();
        let mut pending = self.outputs.clone();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            match graph.node(id) {
                Node::Variable(..) | Node::Parameter(..) => return None,
                node @ (Node::Constant(_) | Node::Apply(..)) => pending.extend_from_slice(node.operands()),
            }
            found.push(id);
        }
        found.sort_unstable();
        Some(found)
    }
}

/// Whether a node calls the noise function.
pub(super) fn calls_perlin(graph: &Graph, id: NodeId) -> bool {
    matches!(graph.node(id), Node::Apply(Primitive::Perlin, _))
}

/// The parameters that every kernel has.
pub(super) fn parameters() -> [AbiParam; 4] {
    [AbiParam::new(I64); 4]
}

/// Beyond so many nodes blocks are computed one after the other: side by side they would need far more registers than there are, and
/// there is enough to overlap within a block.
const MANY_NODES: usize = 400;

/// Writes the kernel, whose plan has this schedule, into an empty function with the [`parameters`]; `perlin` is there if it is called.
pub(super) fn write(
    plan: &KernelPlan,
    schedule: &[NodeId],
    graph: &Graph,
    isa: &dyn TargetIsa,
    fma: bool,
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
    let [columns, uniforms, outputs, blocks] = std::array::from_fn(|index| builder.block_params(entry)[index]);
    let pointers = |builder: &mut FunctionBuilder, table: Value, count: usize| -> Vec<Value> {
        (0..count)
            .map(|index| builder.ins().load(I64, MemFlagsData::trusted().with_readonly(), table, 8 * index as i32))
            .collect()
    };
    let columns = pointers(&mut builder, columns, plan.columns.len());
    let outputs = pointers(&mut builder, outputs, plan.outputs.len());
    let shift = builder.ins().iconst(I64, i64::from(LANES_BYTES.trailing_zeros()));
    let end = builder.ins().ishl(blocks, shift);
    let mut writer = Writer { plan, graph, schedule, builder, fma, perlin, columns, uniforms, outputs };
    let mut at = writer.builder.ins().iconst(I64, 0);
    if plan.interleave > 1 && schedule.len() <= MANY_NODES {
        at = writer.counted_loop(at, end, plan.interleave);
    }
    writer.counted_loop(at, end, 1);
    writer.builder.ins().return_(&[]);
    writer.builder.seal_all_blocks();
    writer.builder.finalize(isa.frontend_config());
}

struct Writer<'w, 'f> {
    plan: &'w KernelPlan,
    graph: &'w Graph,
    schedule: &'w [NodeId],
    builder: FunctionBuilder<'f>,
    fma: bool,
    perlin: Option<(FuncRef, cranelift_codegen::ir::StackSlot)>,
    columns: Vec<Value>,
    uniforms: Value,
    outputs: Vec<Value>,
}

impl Writer<'_, '_> {
    /// A loop from byte offset `at` that computes `interleave` blocks at a time, as long as so many are left before `end`.
    /// Yields the offset where it stops, in the block behind the loop.
    fn counted_loop(&mut self, at: Value, end: Value, interleave: usize) -> Value {
        let [head, body, exit] = [(); 3].map(|()| self.builder.create_block());
        let offset = self.builder.append_block_param(head, I64);
        let after = self.builder.append_block_param(exit, I64);
        let step = i64::from(LANES_BYTES) * interleave as i64;
        self.builder.ins().jump(head, &[at.into()]);
        self.builder.switch_to_block(head);
        let stride = self.builder.ins().iconst(I64, step);
        let next = self.builder.ins().iadd(offset, stride);
        let room = self.builder.ins().icmp(IntCC::UnsignedLessThanOrEqual, next, end);
        self.builder.ins().brif(room, body, &[], exit, &[offset.into()]);
        self.builder.switch_to_block(body);
        self.body(offset, interleave);
        self.builder.ins().jump(head, &[next.into()]);
        self.builder.switch_to_block(exit);
        after
    }

    /// Computes the blocks that begin at byte `offset`, each node for all of them before the next node.
    fn body(&mut self, offset: Value, interleave: usize) {
        let flags = MemFlagsData::trusted();
        let mut values: Vec<Vec<Value>> = vec![Vec::new(); self.graph.len()];
        for id in self.schedule {
            let node = self.graph.node(*id);
            for operand in node.operands() {
                self.read(*operand, offset, interleave, &mut values);
            }
            let mut emitter = Emitter { builder: &mut self.builder, fma: self.fma, perlin: self.perlin };
            let value = |block: usize| match node {
                Node::Constant(bits) => emitter.constant(f32::from_bits(bits)),
                Node::Apply(primitive, _) => {
                    let operands: Vec<Value> = node.operands().iter().map(|operand| values[operand.0 as usize][block]).collect();
                    primitive.apply(&mut emitter, &operands)
                }
                Node::Variable(..) | Node::Parameter(..) => unreachable!("schedules hold no leaves"),
            };
            values[id.0 as usize] = (0..interleave).map(value).collect();
        }
        for (node, pointer) in self.plan.outputs.iter().zip(self.outputs.clone()) {
            self.read(*node, offset, interleave, &mut values);
            let address = self.builder.ins().iadd(pointer, offset);
            for (block, value) in values[node.0 as usize].iter().enumerate() {
                let mut value = *value;
                if self.plan.accumulate {
                    let sum = self.builder.ins().load(F32X4, flags, address, place(block));
                    value = self.builder.ins().fadd(sum, value);
                }
                self.builder.ins().store(flags, value, address, place(block));
            }
        }
    }

    /// Loads a node that is read from a column or the uniforms, at its first use: all at once they would not fit the registers.
    fn read(&mut self, id: NodeId, offset: Value, interleave: usize, values: &mut [Vec<Value>]) {
        if !values[id.0 as usize].is_empty() {
            return;
        }
        let flags = MemFlagsData::trusted().with_readonly();
        if let Some(column) = self.plan.columns.iter().position(|node| *node == id) {
            let address = self.builder.ins().iadd(self.columns[column], offset);
            let load = |block| self.builder.ins().load(F32X4, flags, address, place(block));
            values[id.0 as usize] = (0..interleave).map(load).collect();
        } else if let Some(uniform) = self.plan.uniforms.iter().position(|node| *node == id) {
            let value = self.builder.ins().load(F32X4, flags, self.uniforms, place(uniform));
            values[id.0 as usize] = vec![value; interleave];
        }
    }
}

/// The offset of a block, in bytes.
fn place(block: usize) -> i32 {
    (LANES_BYTES as usize * block) as i32
}
