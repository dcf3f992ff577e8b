//! The only module with unsafe code. It owns machine code in executable memory and calls it: kernels, and the code
//! that adds to pixels. It also holds the function that kernels call for noise.
//!
//! Kernels run with flags that make subnormal numbers zero, because a subnormal operand costs a hundred cycles or
//! more: FTZ and DAZ of the MXCSR register, or FZ of FPCR on AArch64. Rust code must not run with these flags. So the
//! register is set before each call and restored after it, and the other way round where a kernel calls Rust code.
#![allow(unsafe_code)]

use crate::formula::graph::Graph;
use crate::jit::code_call::{AddCall, Bases, KernelCall, OUTPUTS};
use crate::jit::emit::PERLIN_OPERANDS;
use crate::jit::kernel::{self, KernelPart, KernelSpec, LoopShape};
use crate::jit::lanes::{Line, Operands, PLANE_PIXELS, PixelLine, PixelPlanes, Splat, Streams};
use crate::jit::pixels::{self, Strides};
use crate::jit::target::{CompileError, Listing, Target, target};
use crate::jit::widen::{ALIGNMENT, disassembled, widen};
use crate::jit::width::Width;
use crate::jit::writer;
use crate::lang::noise;
use crate::lang::scalars::flush;
use crate::picture::transfer::{SrgbBytes, SrgbTable, Transfer};
use crate::plan::STREAMS;
use crate::trace::{CHUNK_HITS, CHUNK_LINES, LINE_HITS, Segment};
use cranelift_codegen::Context;
use cranelift_codegen::control::ControlPlane;
use cranelift_codegen::ir::types::I64;
use cranelift_codegen::ir::{AbiParam, Signature};
use cranelift_codegen::isa::{CallConv, TargetIsa};
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{FuncId, Linkage, Module, ModuleError, ModuleReloc};
use smallvec::SmallVec;
use std::mem::ManuallyDrop;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// The type of every kernel function. [`writer`] explains the parameters.
///
/// # Safety
/// At the offsets of `call` from `bases`, each stream and output has at least the lines of the rounds of `call`, and
/// there are as many uniform values as the kernel reads. Outputs do not overlap anything.
type Entry = unsafe extern "C" fn(call: *const KernelCall, bases: *const Bases);

/// The executable memory of a batch of kernels. It is freed with the last kernel.
pub(super) struct CodeMemory(ManuallyDrop<JITModule>);

// SAFETY: the module is touched only when it is made and, by the one owner left, when it is dropped; kernels only run
// code in its memory.
unsafe impl Send for CodeMemory {}
// SAFETY: as above; there is no method that reads or changes the module through a shared reference.
unsafe impl Sync for CodeMemory {}

impl CodeMemory {
    /// Takes ownership of the module at once: a module that is merely dropped leaks its memory.
    fn new(builder: JITBuilder) -> Self {
        Self(ManuallyDrop::new(JITModule::new(builder)))
    }
}

impl Drop for CodeMemory {
    fn drop(&mut self) {
        // SAFETY: the value is not used after this, since it is being dropped. Every kernel holds the memory by an
        // `Arc`, so no code in it can be running or be called any more.
        unsafe { ManuallyDrop::take(&mut self.0).free_memory() }
    }
}

/// Compiles kernels for vectors of a width, into one piece of memory. If there is a listing, the stages are written
/// into it.
///
/// # Errors
/// The processor is not supported, a plan does not read what it needs, or the code generator refuses (too large a
/// function).
pub(super) fn generate(
    width: Width,
    specs: &[KernelSpec],
    graph: &Graph,
    mut listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let target = target(width)?;
    let failed = |error: ModuleError| CompileError::Generator(error.to_string());
    let mut builder = JITBuilder::with_isa(target.isa.clone(), cranelift_module::default_libcall_names());
    builder.symbol("perlin", perlin_lanes as *const u8);
    let mut memory = CodeMemory::new(builder);
    let module = &mut *memory.0;
    let mut noise_signature = Signature::new(CallConv::SystemV);
    noise_signature.params.push(AbiParam::new(I64));
    let noise = module.declare_function("perlin", Linkage::Import, &noise_signature).map_err(failed)?;
    let mut defined: Vec<Vec<(FuncId, LoopShape)>> = Vec::with_capacity(specs.len());
    for (index, spec) in specs.iter().enumerate() {
        let mut functions = Vec::new();
        for part in spec.parts(graph) {
            let mut signature = Signature::new(CallConv::SystemV);
            signature.params.extend(writer::parameters());
            let name = format!("{}{index}_{}", spec.plan.name, part.outputs.start);
            let id = module.declare_function(&name, Linkage::Local, &signature).map_err(failed)?;
            let function = KernelFunction { target: &target, part, graph, id, signature, noise };
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
    /// The function that it calls for noise.
    noise: FuncId,
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
            let noisy = schedule.iter().any(|id| kernel::calls_perlin(graph, *id));
            if shape.blocks > 1 && noisy {
                continue;
            }
            let mut context = Context::new();
            context.func.signature = self.signature.clone();
            let callee = noisy.then(|| module.declare_func_in_func(self.noise, &mut context.func));
            let isa = target.isa(kernel::allocation(&schedule, graph));
            writer::write(part, &schedule, graph, isa, shape, callee, &mut context.func);
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
    streams: [usize; STREAMS],
    uniforms: usize,
    /// The number of columns in each stream that it writes.
    outputs: SmallVec<[usize; OUTPUTS]>,
    memory: Arc<CodeMemory>,
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
        let mut places = [0; OUTPUTS];
        for ((output, columns), place) in outputs.iter_mut().zip(&self.outputs).zip(&mut places) {
            assert!(holds(output.len(), whole, *columns), "a kernel's outputs");
            *place = output.as_mut_ptr().expose_provenance();
        }
        let streams = streams.map(|stream| stream.as_ptr().expose_provenance());
        let calls: SmallVec<[CodeCall; 1]> = self.calls(streams, uniforms.as_ptr().expose_provenance(), places, whole).collect();
        // SAFETY: a kernel has at least one function. Its code reads `whole` lines of each column of every stream and
        // `self.uniforms` splats, and writes `whole` lines of each column of every output. The assertions guarantee
        // that they exist, and `&mut` that outputs do not overlap anything. The places are addresses, so the bases
        // are 0.
        unsafe { perform(&calls, &Bases::default()) }
    }

    /// The calls of its functions, for whole rounds at these places.
    fn calls(
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
fn holds(length: usize, lines: usize, columns: usize) -> bool {
    lines.checked_mul(columns).is_some_and(|needed| length >= needed)
}

/// A call of compiled code: the operands, and the address of the code. For code that adds to pixels, the operands are
/// the bytes of an [`AddCall`].
#[derive(Clone, Copy)]
#[repr(C)]
struct CodeCall {
    work: KernelCall,
    entry: usize,
}

/// The calls of compiled code for a tile. The list is built once and run in each frame, all calls in one go: to enter
/// and leave compiled code costs some ten nanoseconds, and columns that stream through the L1 cache displace
/// everything else.
///
/// A list holds offsets into the operands, not their addresses. Each run gets its own [`Operands`].
#[derive(Default)]
pub struct CallList {
    calls: Vec<CodeCall>,
    sizes: OperandSizes,
    /// The memory that holds the code of the calls.
    memory: SmallVec<[Arc<CodeMemory>; 1]>,
}

/// The least number of each operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct OperandSizes {
    streams: [usize; STREAMS],
    uniforms: usize,
    segments: usize,
    weights: usize,
}

impl CallList {
    /// The memory of a call, in bytes.
    pub const BYTES_PER_CALL: usize = size_of::<CodeCall>();

    /// Removes all calls.
    pub fn clear(&mut self) {
        self.calls.clear();
        self.memory.clear();
        self.sizes = OperandSizes::default();
    }

    /// The number of calls.
    pub fn len(&self) -> usize {
        self.calls.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.calls.is_empty()
    }

    /// The memory of the calls, in bytes.
    pub fn bytes(&self) -> usize {
        self.calls.capacity() * size_of::<CodeCall>()
    }

    /// Frees memory that is not needed.
    pub fn shrink(&mut self) {
        self.calls.shrink_to_fit();
    }

    /// Prefetches the calls.
    pub fn fetch(&self) {
        fetch(&self.calls);
    }

    /// Adds a call of a kernel of sums for some lines of a chunk. `streams` are the ranges of lines that it reads. It
    /// writes the sums of these `components`, one for each output, at the same lines of the chunk. Its uniform values
    /// begin at index `uniforms`.
    ///
    /// # Panics
    /// If a range of a stream is shorter than the [whole rounds](Kernel::whole_rounds) of the lines, the lines are
    /// not within a chunk, or the number of components is not that of the kernel.
    pub fn contribute(
        &mut self,
        kernel: &Kernel,
        streams: [Range<usize>; STREAMS],
        uniforms: usize,
        components: Range<usize>,
        lines: Range<usize>,
    ) {
        let whole = kernel.whole_rounds(lines.len());
        assert!(lines.start + whole <= CHUNK_LINES, "lines of a chunk");
        assert!(components.len() == kernel.outputs.len() && components.end <= OUTPUTS, "components for a kernel's outputs");
        assert!(kernel.outputs.iter().all(|columns| *columns <= 1), "a kernel of terms");
        let enough = streams.iter().zip(kernel.streams).all(|(stream, columns)| holds(stream.len(), whole, columns));
        assert!(enough, "a kernel's columns");
        for (size, stream) in self.sizes.streams.iter_mut().zip(&streams) {
            *size = stream.end.max(*size);
        }
        self.sizes.uniforms = self.sizes.uniforms.max(uniforms + kernel.uniforms);
        if !self.memory.iter().any(|memory| Arc::ptr_eq(memory, &kernel.memory)) {
            self.memory.push(Arc::clone(&kernel.memory));
        }
        let mut places = [0; OUTPUTS];
        for (component, place) in components.zip(&mut places) {
            *place = (component * CHUNK_LINES + lines.start) * size_of::<Line>();
        }
        let streams = streams.map(|stream| stream.start * size_of::<Line>());
        self.calls.extend(kernel.calls(streams, uniforms * size_of::<Splat>(), places, whole));
    }

    /// Adds a call that adds the sums of the hits of these segments, times the weight of their span, to their pixels:
    /// all components, or one (0 red, 1 green, 2 blue). The weights of their chunk begin at index `weights`. For each
    /// segment it prefetches some lines of [`Operands::coming`], from index `coming` on.
    pub fn add(
        &mut self,
        code: &'static PixelCode,
        segments: Range<usize>,
        weights: usize,
        component: Option<usize>,
        coming: usize,
    ) {
        if segments.is_empty() {
            return;
        }
        let place = component.unwrap_or(0);
        assert!(place < OUTPUTS, "a component");
        self.sizes.segments = self.sizes.segments.max(segments.end);
        // Enough for any span that a segment may name.
        self.sizes.weights = self.sizes.weights.max(weights + CHUNK_HITS);
        let addition = AddCall {
            segments: segments.start * size_of::<Segment>(),
            end: segments.end * size_of::<Segment>(),
            sums: place * size_of::<[Line; CHUNK_LINES]>(),
            planes: place * size_of::<[f32; PLANE_PIXELS]>(),
            coming: coming * size_of::<Line>(),
            weights: weights * size_of::<f32>(),
            unused: Default::default(),
        };
        let entry = if component.is_some() { code.adding_one } else { code.adding_all };
        self.calls.push(CodeCall { work: bytemuck::cast(addition), entry });
    }

    /// Makes some of the calls, in order.
    ///
    /// # Panics
    /// If there are fewer operands than any call of the list needs.
    pub fn run(&self, calls: Range<usize>, operands: &mut Operands) {
        let Operands { streams, coming, uniforms, segments, weights, sums, planes } = operands;
        let OperandSizes { streams: lines, uniforms: splats, segments: places, weights: spans } = self.sizes;
        assert!(streams.iter().zip(lines).all(|(stream, lines)| stream.len() >= lines), "a program's columns");
        assert!(uniforms.len() >= splats && segments.len() >= places && weights.len() >= spans, "a program's operands");
        let calls = &self.calls[calls];
        if calls.is_empty() {
            return;
        }
        let bases = Bases {
            streams: streams.map(|stream| stream.as_ptr().expose_provenance()),
            outputs: (&raw mut **sums).expose_provenance(),
            uniforms: uniforms.as_ptr().expose_provenance(),
            segments: segments.as_ptr().expose_provenance(),
            planes: (&raw mut **planes).expose_provenance(),
            weights: weights.as_ptr().expose_provenance(),
            coming: coming.as_ptr().addr(),
        };
        // SAFETY: there is at least one call, and the two methods above made all of them. The code of a kernel reads
        // the lines of its rounds of each column of every stream, and its uniform splats: `contribute` counted them
        // in `sizes`, and the assertions here guarantee that they exist. It writes as many lines of sums, within a
        // chunk of each component. Code that adds to pixels reads at least one segment, and only segments that
        // `sizes` counts. The line of a segment is one of a chunk, and its place is such that a line from there ends
        // within a plane (see `Segment::line` and `Segment::place`; only their module can make a segment). Sums and
        // planes are arrays, so they have as many consecutive components from the given one on as the code was
        // written for. `sizes` counts the weight of each span that a segment may name. A prefetch of any address is
        // harmless. Everything that is written is borrowed uniquely. The code lives as long as the list or for ever,
        // and the processor was checked for the instructions that it uses.
        unsafe { perform(calls, &bases) }
    }
}

/// Flush to zero, denormals are zero, and all exceptions masked.
#[cfg(target_arch = "x86_64")]
static KERNEL_MODE: u32 = 0x9fc0;
/// The state for Rust code: round to nearest, all exceptions masked.
#[cfg(target_arch = "x86_64")]
static RUST_MODE: u32 = 0x1f80;
/// Flush to zero, for operands and results. No exception traps.
#[cfg(target_arch = "aarch64")]
static KERNEL_MODE: u64 = 1 << 24;
/// The state for Rust code: round to nearest, no exception traps.
#[cfg(target_arch = "aarch64")]
static RUST_MODE: u64 = 0;

/// Makes the calls in order. Subnormal operands and results count as zero.
///
/// # Safety
/// There is at least one call, and it is sound to make each of them with these bases.
#[cfg(target_arch = "x86_64")]
unsafe fn perform(calls: &[CodeCall], bases: &Bases) {
    let mut saved: u32 = RUST_MODE;
    let calls = calls.as_ptr_range();
    // SAFETY: saves MXCSR, sets it for the compiled code, makes the calls by the C calling convention (whose registers
    // are all declared lost), and restores MXCSR, so that Rust code never runs under the changed one. r12 to r15
    // survive calls by that convention. `Line` is aligned as the code's loads and stores need.
    unsafe {
        std::arch::asm!(
            "stmxcsr [r12]",
            "ldmxcsr [rax]",
            "2:",
            "mov rdi, r13",
            "mov rsi, r15",
            "call [r13 + {entry}]",
            "add r13, {size}",
            "cmp r13, r14",
            "jb 2b",
            "ldmxcsr [r12]",
            entry = const std::mem::offset_of!(CodeCall, entry),
            size = const size_of::<CodeCall>(),
            in("r12") &raw mut saved,
            in("rax") &raw const KERNEL_MODE,
            inout("r13") calls.start => _,
            in("r14") calls.end,
            in("r15") bases,
            clobber_abi("C"),
        );
    }
}

/// Makes the calls in order. Subnormal operands and results count as zero.
///
/// # Safety
/// There is at least one call, and it is sound to make each of them with these bases.
#[cfg(target_arch = "aarch64")]
unsafe fn perform(calls: &[CodeCall], bases: &Bases) {
    let calls = calls.as_ptr_range();
    // SAFETY: saves FPCR, sets it for the compiled code, makes the calls by the C calling convention (whose registers
    // are all declared lost), and restores FPCR, so that Rust code never runs under the changed one. x20 to x23 survive
    // calls by that convention. `Line` is aligned as the code's loads and stores need.
    unsafe {
        std::arch::asm!(
            "mrs x23, fpcr",
            "msr fpcr, {mode}",
            "2:",
            "mov x0, x20",
            "mov x1, x22",
            "ldr x9, [x20, {entry}]",
            "blr x9",
            "add x20, x20, {size}",
            "cmp x20, x21",
            "b.lo 2b",
            "msr fpcr, x23",
            entry = const std::mem::offset_of!(CodeCall, entry),
            size = const size_of::<CodeCall>(),
            mode = in(reg) KERNEL_MODE,
            inout("x20") calls.start => _,
            in("x21") calls.end,
            in("x22") bases,
            out("x23") _,
            clobber_abi("C"),
        );
    }
}

/// The function that kernels call for noise. `lanes` points to six operands of four lanes, followed by the place of
/// the result.
///
/// # Safety
/// `lanes` points to room for seven times four numbers, of which the first six times four are there.
unsafe extern "C" fn perlin_lanes(lanes: *mut f32) {
    let mut saved = KERNEL_MODE;
    // SAFETY: reads and writes nothing but MXCSR or FPCR, and `saved`. Rust's floating point needs the default state.
    unsafe {
        #[cfg(target_arch = "x86_64")]
        std::arch::asm!("stmxcsr [{saved}]", "ldmxcsr [{rust}]", saved = in(reg) &raw mut saved, rust = in(reg) &raw const RUST_MODE, options(nostack));
        #[cfg(target_arch = "aarch64")]
        std::arch::asm!("mrs {saved}, fpcr", "msr fpcr, {rust}", saved = out(reg) saved, rust = in(reg) RUST_MODE, options(nostack));
    }
    const WIDTH: usize = Line::RECORDS / Line::BLOCKS;
    const OPERANDS: usize = PERLIN_OPERANDS as usize;
    for lane in 0..WIDTH {
        // SAFETY: kernels pass the address of a stack slot of `OPERANDS + 1` times `WIDTH` floats whose operands they
        // have written.
        let [x, y, z, a, b, n] =
            std::array::from_fn::<f32, OPERANDS, _>(|index| unsafe { lanes.add(index * WIDTH + lane).read() });
        let value = flush(noise::perlin([x, y, z], a, b, n));
        // SAFETY: as above; the result's place is behind the operands.
        unsafe { lanes.add(OPERANDS * WIDTH + lane).write(value) };
    }
    // SAFETY: gives the kernel its register back.
    unsafe {
        #[cfg(target_arch = "x86_64")]
        std::arch::asm!("ldmxcsr [{saved}]", saved = in(reg) &raw const saved, options(nostack, readonly));
        #[cfg(target_arch = "aarch64")]
        std::arch::asm!("msr fpcr, {saved}", saved = in(reg) saved, options(nostack));
    }
}

/// Prefetches a list that is going to be read, without waiting. Several lists can then come from memory at the same
/// time.
pub fn fetch<T>(list: &[T]) {
    let bytes = list.as_ptr_range();
    for line in (bytes.start.addr()..bytes.end.addr()).step_by(size_of::<Line>()) {
        // SAFETY: a prefetch has no visible effect, and any address is allowed. Every processor of the architecture has
        // the instruction.
        unsafe {
            #[cfg(target_arch = "x86_64")]
            std::arch::x86_64::_mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(std::ptr::without_provenance(line));
            #[cfg(target_arch = "aarch64")]
            std::arch::asm!("prfm pldl1keep, [{line}]", line = in(reg) line, options(nostack, readonly, preserves_flags));
        }
    }
}

/// Code that adds contributions to pixels and writes pixels, for vectors of a width.
pub struct PixelCode {
    /// The addresses of the code of [`pixels`] that adds all components, and one.
    adding_all: usize,
    adding_one: usize,
    /// The code that writes pixels, with the linear transfer and with that of sRGB.
    writing: [Writing; 2],
    _memory: CodeMemory,
}

/// The code of [`pixels`] that writes pixels.
///
/// # Safety
/// There is at least one line. All lines are readable from `planes` on in three planes, and writable from `pixels`
/// on. The processor has vectors of this width.
type Writing =
    unsafe extern "C" fn(planes: *const f32, pixels: *mut PixelLine, lines: usize, coming: *const Line, table: *const SrgbTable);

impl PixelCode {
    /// The code for vectors of this width. It is made at its first use. `None` if the processor is not x86-64 or does
    /// not have such vectors, or there is no memory for code.
    pub fn get(width: Width) -> Option<&'static PixelCode> {
        static CODE: [OnceLock<Option<PixelCode>>; Width::ALL.len()] = [const { OnceLock::new() }; Width::ALL.len()];
        CODE[width as usize].get_or_init(|| Self::new(width)).as_ref()
    }

    fn new(width: Width) -> Option<Self> {
        if !cfg!(target_arch = "x86_64") {
            return None;
        }
        let target = target(width).ok()?;
        let builder = JITBuilder::with_isa(target.isa, cranelift_module::default_libcall_names());
        let mut memory = CodeMemory::new(builder);
        let module = &mut *memory.0;
        let strides = Strides { sums: size_of::<[Line; CHUNK_LINES]>() as i64, plane: size_of::<[f32; PLANE_PIXELS]>() as i64 };
        let codes = [
            ("adding", pixels::adding_code(width, strides, 3)),
            ("adding_one", pixels::adding_code(width, strides, 1)),
            ("writing_linear", pixels::writing_code(width, Transfer::Linear, strides.plane)),
            ("writing_srgb", pixels::writing_code(width, Transfer::Srgb, strides.plane)),
        ];
        let mut define = |(name, code): (&str, Result<Vec<u8>, _>)| {
            let id = module.declare_function(name, Linkage::Local, &Signature::new(CallConv::SystemV)).ok()?;
            module.define_function_bytes(id, ALIGNMENT, &code.ok()?, &[]).ok()?;
            Some(id)
        };
        let [adding_all, adding_one, linear, srgb] = codes.map(&mut define);
        let ids = [adding_all?, adding_one?, linear?, srgb?];
        module.finalize_definitions().ok()?;
        let [adding_all, adding_one, linear, srgb] = ids.map(|id| module.get_finalized_function(id));
        // SAFETY: at the address is the finished code of a function with these parameters and the C calling
        // convention. Its memory lives as long as the result.
        let writing = [linear, srgb].map(|code| unsafe { std::mem::transmute::<*const u8, Writing>(code) });
        let [adding_all, adding_one] = [adding_all, adding_one].map(<*const u8>::expose_provenance);
        Some(Self { adding_all, adding_one, writing, _memory: memory })
    }

    /// Writes lines of pixels, `0x00RRGGBB`, from index `place` of the planes on. The transfer turns components into
    /// bytes. It prefetches as many lines of `coming`.
    ///
    /// # Panics
    /// If a plane has fewer pixels.
    pub fn write(&self, transfer: Transfer, planes: &PixelPlanes, place: usize, pixels: &mut [PixelLine], coming: &[Line]) {
        if pixels.is_empty() {
            return;
        }
        assert!(
            pixels.len() <= PLANE_PIXELS / LINE_HITS && place + pixels.len() * LINE_HITS <= PLANE_PIXELS,
            "pixels of a plane"
        );
        let first = (&raw const planes.0).cast::<f32>();
        // If there is nothing to prefetch, it is something that is in the cache already.
        let coming = if coming.is_empty() { first.cast() } else { coming.as_ptr() };
        let writing = match transfer {
            Transfer::Linear => self.writing[0],
            Transfer::Srgb => self.writing[1],
        };
        // SAFETY: there is at least one line. All lines lie within their plane, from `place` on. The planes are an
        // array, so green and blue follow red at the distance of a plane (the pointer comes from a pointer to the
        // whole array). `pixels` has as many lines, aligned as their type requires. A prefetch of any address is
        // harmless. The code reads entries of the table for numbers from `SrgbBytes::LEAST` to 1, and the table has
        // one for each. The processor was checked for the instructions.
        unsafe {
            writing(first.add(place), pixels.as_mut_ptr(), pixels.len(), coming, SrgbBytes::get().table());
        }
    }
}

#[cfg(test)]
mod tests;
