//! Compiled kernels: the code generator is run on the IR of their parts, and the code is kept with its memory.

use crate::formula::graph::Graph;
use crate::jit::call::memory::CodeMemory;
use crate::jit::call::processor::{CodeCall, address_of, perform};
use crate::jit::code_call::{Bases, KernelCall, OUTPUTS};
use crate::jit::emit::Callee;
use crate::jit::kernel::{self, KernelPart, KernelSpec, LoopShape};
use crate::jit::lanes::{Line, Splat, Streams};
use crate::jit::target::{CompileError, Listing, Target, target};
use crate::jit::widen::{ALIGNMENT, disassembled, widen};
use crate::jit::writer;
use crate::plan::STREAMS;
use crate::simd::Width;
use cranelift_codegen::Context;
use cranelift_codegen::control::ControlPlane;
use cranelift_codegen::ir::types::I64;
use cranelift_codegen::ir::{AbiParam, Signature};
use cranelift_codegen::isa::{CallConv, TargetIsa};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, ModuleError, ModuleReloc};
use smallvec::SmallVec;
use std::collections::HashSet;
use std::sync::Arc;

/// The type of every kernel function. [`writer`] explains the parameters.
///
/// # Safety
/// At the offsets of `call` from `bases`, each stream and output has at least the lines of the rounds of `call`, and
/// there are as many uniform values as the kernel reads. Outputs do not overlap anything.
type Entry = unsafe extern "C" fn(call: *const KernelCall, bases: *const Bases);

/// Compiles kernels for vectors of a width, into one piece of memory. If there is a listing, the stages are written
/// into it.
///
/// # Errors
/// The processor is not supported, a plan does not read what it needs, or the code generator refuses (too large a
/// function).
pub(in crate::jit) fn generate(
    width: Width,
    specs: &[KernelSpec],
    graph: &Graph,
    mut listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let target = target(width)?;
    let failed = |error: ModuleError| CompileError::Generator(error.to_string());
    let mut builder = JITBuilder::with_isa(target.isa.clone(), cranelift_module::default_libcall_names());
    for callee in Callee::ALL {
        builder.symbol(callee.primitive().name(), address_of(callee));
    }
    let mut memory = CodeMemory::new(builder);
    let module = &mut *memory.0;
    let mut callee_signature = Signature::new(CallConv::SystemV);
    callee_signature.params.push(AbiParam::new(I64));
    let mut callees: Vec<FuncId> = Vec::new();
    for callee in Callee::ALL {
        callees.push(module.declare_function(callee.primitive().name(), Linkage::Import, &callee_signature).map_err(failed)?);
    }
    let mut defined: Vec<Vec<(FuncId, LoopShape)>> = Vec::with_capacity(specs.len());
    for (index, spec) in specs.iter().enumerate() {
        let mut functions = Vec::new();
        for part in spec.parts(graph) {
            let mut signature = Signature::new(CallConv::SystemV);
            signature.params.extend(writer::parameters());
            let name = format!("{}{index}_{}", spec.plan.name, part.outputs.start);
            let id = module.declare_function(&name, Linkage::Local, &signature).map_err(failed)?;
            let function = KernelFunction { target: &target, part, graph, id, signature, callees: &callees };
            functions.push((id, function.define(module, listing.as_deref_mut())?));
        }
        defined.push(functions);
    }
    module.finalize_definitions().map_err(failed)?;
    let finished: Vec<Vec<(*const u8, LoopShape)>> = defined
        .into_iter()
        .map(|functions| functions.into_iter().map(|(id, shape)| (module.get_finalized_function(id), shape)).collect())
        .collect();
    let memory = Arc::new(memory);
    let kernel = |(spec, functions): (&KernelSpec, Vec<(*const u8, LoopShape)>)| {
        let function = |(address, shape): (*const u8, LoopShape)| {
            // SAFETY: at the address is the finished code of the function that was written just now with the parameters
            // of `Entry`, none of which is wider than a register; its memory lives as long as the kernel.
            let entry = unsafe { std::mem::transmute::<*const u8, Entry>(address) };
            (entry, shape)
        };
        let functions = functions.into_iter().map(function).collect();
        let streams = spec.plan.streams.each_ref().map(Vec::len);
        let (uniforms, outputs) = (spec.plan.uniforms.len(), SmallVec::from_vec(spec.output_streams()));
        Kernel { functions, streams, uniforms, outputs, memory: Arc::clone(&memory) }
    };
    Ok(specs.iter().zip(finished).map(kernel).collect())
}

/// The function of a part of a kernel. It is declared, but not yet defined.
struct KernelFunction<'d> {
    target: &'d Target,
    part: KernelPart<'d>,
    graph: &'d Graph,
    id: FuncId,
    signature: Signature,
    /// The functions that it may call, by their numbers.
    callees: &'d [FuncId],
}

impl KernelFunction<'_> {
    /// Compiles the function in the fastest possible shape, and returns that shape.
    fn define(&self, module: &mut JITModule, mut listing: Option<&mut Listing>) -> Result<LoopShape, CompileError> {
        let Self { target, part, graph, .. } = self;
        let name = part.kernel.plan.name;
        if part.kernel.output_streams().len() > OUTPUTS {
            return Err(CompileError::Generator(format!("the kernel of {name} has too many outputs")));
        }
        for shape in part.shapes(graph, target) {
            let schedule = part.schedule(graph, shape).ok_or_else(|| self.unread())?;
            let called: HashSet<usize> =
                schedule.iter().filter_map(|id| kernel::callee(graph, *id)).map(|callee| callee as usize).collect();
            if shape.blocks > 1 && !called.is_empty() {
                continue;
            }
            let mut context = Context::new();
            context.func.signature = self.signature.clone();
            let callees = std::array::from_fn(|index| {
                called.contains(&index).then(|| module.declare_func_in_func(self.callees[index], &mut context.func))
            });
            let isa = target.isa(kernel::allocation(&schedule, graph));
            writer::write(part, &schedule, graph, isa, shape, callees, &mut context.func);
            context.set_disasm(listing.is_some());
            let clif = listing.is_some().then(|| context.func.display().to_string());
            let Some(assembler) = self.compile(module, &mut context, isa, shape, listing.is_some())? else { continue };
            if let (Some(listing), Some(clif)) = (&mut listing, clif) {
                listing.clif.push_str(&format!("; {name}\n{clif}\n"));
                listing.asm.push_str(&format!("; {name}\n{assembler}\n"));
            }
            return Ok(shape);
        }
        Err(self.unread())
    }

    /// Compiles the IR in `context`, widens it, and defines the function. Returns the instructions as text if
    /// `listed`, else an empty text. `None` if the code cannot be widened.
    fn compile(
        &self,
        module: &mut JITModule,
        context: &mut Context,
        isa: &dyn TargetIsa,
        shape: LoopShape,
        listed: bool,
    ) -> Result<Option<String>, CompileError> {
        let compiled = context.compile(isa, &mut ControlPlane::default());
        compiled.map_err(|error| CompileError::Generator(error.inner.to_string()))?;
        let Some(compiled) = context.compiled_code() else { return Ok(None) };
        let relocations = compiled.buffer.relocs();
        let own = (cfg!(target_arch = "x86_64") && relocations.is_empty()).then(|| compiled.code_buffer());
        let (text, defined) = match own.and_then(|code| widen(code, shape.blocks, shape.spills())) {
            Some(code) => {
                let text = if listed { disassembled(&code) } else { String::new() };
                (text, module.define_function_bytes(self.id, ALIGNMENT, &code, &[]))
            }
            None if shape.blocks > 1 => return Ok(None),
            None => {
                let relocation = |relocation| ModuleReloc::from_mach_reloc(relocation, &context.func, self.id);
                let relocations: Vec<ModuleReloc> = relocations.iter().map(relocation).collect();
                let text = compiled.vcode.clone().unwrap_or_default();
                (text, module.define_function_bytes(self.id, ALIGNMENT, compiled.code_buffer(), &relocations))
            }
        };
        defined.map_err(|error| CompileError::Generator(error.to_string()))?;
        Ok(Some(text))
    }

    fn unread(&self) -> CompileError {
        CompileError::Generator(format!("the kernel of {} does not read all that it needs", self.part.kernel.plan.name))
    }
}

/// A compiled kernel.
#[derive(Clone)]
pub struct Kernel {
    /// The functions of its parts. Together they write all outputs.
    functions: SmallVec<[(Entry, LoopShape); 1]>,
    /// The number of columns in each stream that it reads.
    pub(super) streams: [usize; STREAMS],
    pub(super) uniforms: usize,
    /// The number of columns in each stream that it writes.
    pub(super) outputs: SmallVec<[usize; OUTPUTS]>,
    pub(super) memory: Arc<CodeMemory>,
}

impl Kernel {
    /// The number of columns that it writes.
    pub fn outputs(&self) -> usize {
        self.outputs.iter().sum()
    }

    /// Rounds a number of lines up to whole rounds, which are up to [`ROUND_LINES`](crate::trace::ROUND_LINES) long.
    /// A kernel reads and writes whole rounds.
    pub fn whole_rounds(&self, lines: usize) -> usize {
        // The lines of rounds are powers of two, so the largest is a multiple of the others.
        let round = self.functions.iter().map(|(_, shape)| shape.lines()).max();
        lines.next_multiple_of(round.unwrap_or(1))
    }

    /// Runs the kernel over this many lines of 16 records. It reads the streams, each with a line of every column for
    /// each line of records, and the uniform values, one splat each. It stores or adds into `outputs`: one stream if
    /// values are stored, one column for each output if terms are added up. The contents of lines after the last, up to
    /// [whole rounds](Self::whole_rounds), have no meaning.
    ///
    /// # Panics
    /// If the number of uniform values or outputs is not that of the kernel, or a stream or an output is shorter than
    /// the [whole rounds](Self::whole_rounds) of `lines`.
    pub fn run(&self, streams: Streams, uniforms: &[Splat], outputs: &mut [&mut [Line]], lines: usize) {
        let whole = self.whole_rounds(lines);
        let enough = streams.iter().zip(self.streams).all(|(stream, columns)| holds(stream.len(), whole, columns));
        assert!(enough, "a kernel's columns");
        assert!(uniforms.len() >= self.uniforms, "a kernel's uniforms");
        assert!(outputs.len() == self.outputs.len(), "a kernel's outputs");
        let mut addresses = [0; OUTPUTS];
        for ((output, columns), address) in outputs.iter_mut().zip(&self.outputs).zip(&mut addresses) {
            assert!(holds(output.len(), whole, *columns), "a kernel's outputs");
            *address = output.as_mut_ptr().expose_provenance();
        }
        let streams = streams.map(|stream| stream.as_ptr().expose_provenance());
        let calls: SmallVec<[CodeCall; 1]> =
            self.calls(streams, uniforms.as_ptr().expose_provenance(), addresses, whole).collect();
        // SAFETY: a kernel has at least one function. Its code reads `whole` lines of each column of every stream and
        // `self.uniforms` splats, and writes `whole` lines of each column of every output. The assertions guarantee
        // that they exist, and `&mut` that outputs do not overlap anything. The operands are addresses, so the bases
        // are 0.
        unsafe { perform(&calls, &Bases::default()) }
    }

    /// The calls of its functions, for whole rounds of these operands.
    pub(super) fn calls(
        &self,
        streams: [usize; STREAMS],
        uniforms: usize,
        outputs: [usize; OUTPUTS],
        whole: usize,
    ) -> impl Iterator<Item = CodeCall> {
        self.functions.iter().map(move |(entry, shape)| {
            let rounds = whole * Line::BLOCKS / shape.round();
            CodeCall { work: KernelCall { streams, outputs, uniforms, rounds }, entry: *entry as usize }
        })
    }
}

/// Whether a stream of this length holds this many lines of this many columns. A product that overflows is longer
/// than any stream.
pub(super) fn holds(length: usize, lines: usize, columns: usize) -> bool {
    lines.checked_mul(columns).is_some_and(|needed| length >= needed)
}

#[cfg(test)]
mod tests;
