//! The room of unsafe code: kernels in executable memory, calls into them, and the function that they call out to; and the code that
//! adds to pixels.
//!
//! Kernels run with subnormal numbers switched off (FTZ and DAZ of the MXCSR register: a subnormal operand costs a hundred
//! cycles and more), which Rust code must not see; so the register is set and restored around each call, and around what a kernel calls.
#![allow(unsafe_code)]

use crate::formula::graph::Graph;
use crate::jit::emit::PERLIN_OPERANDS;
use crate::jit::kernel::{self, KernelPart, KernelSpec, Shape};
use crate::jit::lanes::{Line, Operands, PLANE_PIXELS, PixelLine, PixelPlanes, Splat, Streams};
use crate::jit::pixels::{self, Strides};
use crate::jit::step::{Addition, Bases, OUTPUTS, Reading};
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
use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
use std::mem::ManuallyDrop;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// What every kernel is: see the [kernel](super::kernel) room for the meaning of the parameters.
///
/// # Safety
/// Where the reading says, counted from the bases, each stream and output has at least the lines of that many rounds, and there are as many
/// uniforms as the kernel reads; outputs overlap nothing.
type Entry = unsafe extern "C" fn(reading: *const Reading, bases: *const Bases);

/// The memory that holds a formula's kernels; freed with the last of them.
pub(super) struct CodeMemory(ManuallyDrop<JITModule>);

// SAFETY: the module is touched only when it is made and, by the one owner left, when it is dropped; kernels only run code in its memory.
unsafe impl Send for CodeMemory {}
// SAFETY: as above; there is no method that reads or changes the module through a shared reference.
unsafe impl Sync for CodeMemory {}

impl CodeMemory {
    /// A module that is owned at once by what frees it: one that is merely dropped leaks its memory.
    fn new(builder: JITBuilder) -> Self {
        Self(ManuallyDrop::new(JITModule::new(builder)))
    }
}

impl Drop for CodeMemory {
    fn drop(&mut self) {
        // SAFETY: the value is not used after this, since it is being dropped. Every kernel holds the memory by an `Arc`, so no
        // code in it can be running or be called any more.
        unsafe { ManuallyDrop::take(&mut self.0).free_memory() }
    }
}

/// Compiles kernels for vectors of a width, into one piece of memory; where a listing is wanted, writes the stages into it.
///
/// # Errors
/// The processor is not supported, a plan does not read what it needs, or the code generator refuses (too large a function).
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
    let mut defined: Vec<Vec<(FuncId, Shape)>> = Vec::with_capacity(specs.len());
    for (index, spec) in specs.iter().enumerate() {
        let mut functions = Vec::new();
        for part in spec.parts(graph) {
            let mut signature = Signature::new(CallConv::SystemV);
            signature.params.extend(writer::parameters());
            let name = format!("{}{index}_{}", spec.plan.name, part.outputs.start);
            let id = module.declare_function(&name, Linkage::Local, &signature).map_err(failed)?;
            let function = Defining { target: &target, part, graph, id, signature, noise };
            functions.push((id, function.define(module, listing.as_deref_mut())?));
        }
        defined.push(functions);
    }
    module.finalize_definitions().map_err(failed)?;
    let finished: Vec<Vec<(*const u8, Shape)>> = defined
        .into_iter()
        .map(|functions| functions.into_iter().map(|(id, shape)| (module.get_finalized_function(id), shape)).collect())
        .collect();
    let memory = Arc::new(memory);
    let kernel = |(spec, functions): (&KernelSpec, Vec<(*const u8, Shape)>)| {
        let function = |(address, shape): (*const u8, Shape)| {
            // SAFETY: at the address is the finished code of the function that was written just now with the parameters of `Entry`, none
            // of which is wider than a register; its memory lives as long as the kernel.
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

/// The function of a part of a kernel, which is declared and not yet defined.
struct Defining<'d> {
    target: &'d Target,
    part: KernelPart<'d>,
    graph: &'d Graph,
    id: FuncId,
    signature: Signature,
    /// The function that it calls for noise.
    noise: FuncId,
}

impl Defining<'_> {
    /// Writes the code in the quickest shape that is possible, which is the result.
    fn define(&self, module: &mut JITModule, mut listing: Option<&mut Listing>) -> Result<Shape, CompileError> {
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

    /// Compiles what was written and defines the function by it: its instructions as text, if they are wanted. None where there is no such code for so
    /// many lanes.
    fn compile(
        &self,
        module: &mut JITModule,
        context: &mut Context,
        isa: &dyn TargetIsa,
        shape: Shape,
        listed: bool,
    ) -> Result<Option<String>, CompileError> {
        let compiled = context.compile(isa, &mut ControlPlane::default());
        compiled.map_err(|error| CompileError::Generator(error.inner.to_string()))?;
        let Some(compiled) = context.compiled_code() else { return Ok(None) };
        let relocations = compiled.buffer.relocs();
        let own = relocations.is_empty().then(|| compiled.code_buffer());
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
    /// The functions of its parts, which together write all outputs.
    functions: SmallVec<[(Entry, Shape); 1]>,
    /// How many columns there are in each stream that it reads.
    streams: [usize; STREAMS],
    uniforms: usize,
    /// How many columns there are in each stream that it writes.
    outputs: SmallVec<[usize; OUTPUTS]>,
    memory: Arc<CodeMemory>,
}

impl Kernel {
    /// How many columns it writes.
    pub fn outputs(&self) -> usize {
        self.outputs.iter().sum()
    }

    /// How many lines it reads and writes where so many are wanted: whole rounds, of up to [`ROUND_LINES`](crate::trace::ROUND_LINES).
    pub fn whole_rounds(&self, lines: usize) -> usize {
        // Powers of two.
        let round = self.functions.iter().map(|(_, shape)| shape.lines()).max();
        lines.next_multiple_of(round.unwrap_or(1))
    }

    /// Runs the kernel over so many lines of records, from these streams and uniform values: stores or adds into `outputs`, one stream where values
    /// are stored, a column for each output where terms are added up. What becomes of lines beyond, see [`whole_rounds`](Self::whole_rounds),
    /// has no meaning.
    ///
    /// # Panics
    /// Where there are not as many uniforms and outputs as the kernel was written for, or a stream or an output is shorter than its
    /// [whole rounds](Self::whole_rounds) of `lines`.
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
        let steps: SmallVec<[Step; 1]> = self.steps(streams, uniforms.as_ptr().expose_provenance(), places, whole).collect();
        // SAFETY: a kernel has a function. Its code reads of every stream, and writes of every output, the lines of its rounds, times as many as the stream has
        // columns, and `self.uniforms` splats; the assertions guarantee all of them, `&mut` that outputs overlap nothing. Places are addresses, so
        // they are counted from 0.
        unsafe { perform(&steps, &Bases::default()) }
    }

    /// The calls that work on whole rounds at these places.
    fn steps(
        &self,
        streams: [usize; STREAMS],
        uniforms: usize,
        outputs: [usize; OUTPUTS],
        whole: usize,
    ) -> impl Iterator<Item = Step> {
        self.functions.iter().map(move |(entry, shape)| {
            let rounds = whole * Line::BLOCKS / shape.round();
            Step { work: Reading { streams, outputs, uniforms, rounds }, entry: *entry as usize }
        })
    }
}

/// Whether a stream of so many lines has these of so many columns. A product that does not fit is longer than any stream.
fn holds(length: usize, lines: usize, columns: usize) -> bool {
    lines.checked_mul(columns).is_some_and(|needed| length >= needed)
}

/// A call of compiled code: what it works on (of a kernel; for code that adds to pixels it is the bytes of an [`Addition`]), and where the code is.
#[derive(Clone, Copy)]
#[repr(C)]
struct Step {
    work: Reading,
    entry: usize,
}

/// Work for compiled code on the pixels of a tile: put together once, then done in one go, frame after frame. To enter and leave compiled code costs
/// some ten nanoseconds, and while columns stream through the first cache, nothing else would stay in it.
///
/// A program knows where everything lies in what it works on, not where that is: [`Operands`] are given anew each time.
#[derive(Default)]
pub struct Program {
    steps: Vec<Step>,
    reach: Reach,
    /// What holds the code of the steps.
    memory: SmallVec<[Arc<CodeMemory>; 1]>,
}

/// How many of each operand there must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Reach {
    streams: [usize; STREAMS],
    uniforms: usize,
    segments: usize,
    weights: usize,
}

impl Program {
    /// The memory of a step, in bytes.
    pub const BYTES_PER_STEP: usize = size_of::<Step>();

    /// Forgets all steps.
    pub fn clear(&mut self) {
        self.steps.clear();
        self.memory.clear();
        self.reach = Reach::default();
    }

    /// How many steps there are.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The memory that the steps take, in bytes.
    pub fn bytes(&self) -> usize {
        self.steps.capacity() * size_of::<Step>()
    }

    /// Gives back memory that is not needed.
    pub fn shrink(&mut self) {
        self.steps.shrink_to_fit();
    }

    /// Has the steps fetched.
    pub fn fetch(&self) {
        fetch(&self.steps);
    }

    /// Runs a kernel of terms over some lines: these parts of the streams are theirs, and the sums are at the same place in the chunk. They are of
    /// these components, one for each output. The uniform values begin at this one.
    ///
    /// # Panics
    /// Where a part of a stream is shorter than the [whole rounds](Kernel::whole_rounds) of the lines, these are not within a chunk, or there are not as
    /// many components as the kernel was written for.
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
        for (reach, stream) in self.reach.streams.iter_mut().zip(&streams) {
            *reach = stream.end.max(*reach);
        }
        self.reach.uniforms = self.reach.uniforms.max(uniforms + kernel.uniforms);
        if !self.memory.iter().any(|memory| Arc::ptr_eq(memory, &kernel.memory)) {
            self.memory.push(Arc::clone(&kernel.memory));
        }
        let mut places = [0; OUTPUTS];
        for (component, place) in components.zip(&mut places) {
            *place = (component * CHUNK_LINES + lines.start) * size_of::<Line>();
        }
        let streams = streams.map(|stream| stream.start * size_of::<Line>());
        self.steps.extend(kernel.steps(streams, uniforms * size_of::<Splat>(), places, whole));
    }

    /// Adds the sums of these segments' hits, times the weight of their span, to their pixels: of all components, or of one (0 red, 1 green, 2 blue).
    /// The weights of their chunk begin at this one. Meanwhile it fetches some lines for each segment, from this one on of those that are coming.
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
        self.reach.segments = self.reach.segments.max(segments.end);
        // Any span that a segment may name.
        self.reach.weights = self.reach.weights.max(weights + CHUNK_HITS);
        let addition = Addition {
            segments: segments.start * size_of::<Segment>(),
            end: segments.end * size_of::<Segment>(),
            sums: place * size_of::<[Line; CHUNK_LINES]>(),
            planes: place * size_of::<[f32; PLANE_PIXELS]>(),
            coming: coming * size_of::<Line>(),
            weights: weights * size_of::<f32>(),
            unused: Default::default(),
        };
        let entry = if component.is_some() { code.adding_one } else { code.adding_all };
        self.steps.push(Step { work: bytemuck::cast(addition), entry });
    }

    /// Takes some of the steps in their order.
    ///
    /// # Panics
    /// Where there are fewer operands than any step of the program reaches.
    pub fn run(&self, steps: Range<usize>, operands: &mut Operands) {
        let Operands { streams, coming, uniforms, segments, weights, sums, planes } = operands;
        let Reach { streams: lines, uniforms: splats, segments: places, weights: spans } = self.reach;
        assert!(streams.iter().zip(lines).all(|(stream, lines)| stream.len() >= lines), "a program's columns");
        assert!(uniforms.len() >= splats && segments.len() >= places && weights.len() >= spans, "a program's operands");
        let steps = &self.steps[steps];
        if steps.is_empty() {
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
        // SAFETY: there is a step, and steps are made by the two methods above. A kernel's code reads of every stream the lines of its rounds, times as
        // many as it has columns, and its uniform splats: `contribute` asserts that they lie before the reach, and the assertions here that so much is
        // given; and it writes as many lines of sums, within a chunk of components. Code that adds reads segments before the reach, at least one;
        // a segment's line is one of a chunk, and its place such that a line from there ends within a plane (see `Segment::line`, `Segment::place`;
        // only its room can make one), and of sums and planes there are as many components from the step's on as the code was written for, one
        // behind the other, since they are arrays; the weight of each span that a segment may name is before the reach. To fetch from where nothing
        // is does nothing. What is written is borrowed uniquely. The code lives as long as the program, or for ever, and the processor was asked for
        // what it needs.
        unsafe { perform(steps, &bases) }
    }
}

/// Flush to zero, denormals are zero, and all exceptions masked.
const KERNEL_MXCSR: u32 = 0x9fc0;
/// What Rust code runs with: round to nearest, all exceptions masked.
const RUST_MXCSR: u32 = 0x1f80;

/// Takes the steps in their order, with subnormal operands and results counting as zero.
///
/// # Safety
/// There is a step, and making the call of each of them, with these bases, must be sound.
unsafe fn perform(steps: &[Step], bases: &Bases) {
    let mut saved: u32 = RUST_MXCSR;
    let steps = steps.as_ptr_range();
    // SAFETY: saves MXCSR, sets it for the compiled code, makes the calls by the C calling convention (whose registers are all declared
    // lost), and restores MXCSR, so that Rust code never runs under the changed one. r12 to r15 survive calls by that convention.
    // `Line` is aligned as the code's loads and stores need.
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
            entry = const std::mem::offset_of!(Step, entry),
            size = const size_of::<Step>(),
            in("r12") &raw mut saved,
            in("rax") &raw const KERNEL_MXCSR_VALUE,
            inout("r13") steps.start => _,
            in("r14") steps.end,
            in("r15") bases,
            clobber_abi("C"),
        );
    }
}

static KERNEL_MXCSR_VALUE: u32 = KERNEL_MXCSR;
static RUST_MXCSR_VALUE: u32 = RUST_MXCSR;

/// The function that kernels call for noise: six operands of four lanes, and room for the result behind them.
///
/// # Safety
/// `lanes` points to room for seven times four numbers, of which the first six times four are there.
unsafe extern "C" fn perlin_lanes(lanes: *mut f32) {
    let mut saved: u32 = KERNEL_MXCSR;
    // SAFETY: reads and writes nothing but MXCSR and `saved`: Rust's floating point needs the default register.
    unsafe {
        std::arch::asm!("stmxcsr [{saved}]", "ldmxcsr [{rust}]", saved = in(reg) &raw mut saved, rust = in(reg) &raw const RUST_MXCSR_VALUE, options(nostack));
    }
    const WIDTH: usize = Line::RECORDS / Line::BLOCKS;
    const OPERANDS: usize = PERLIN_OPERANDS as usize;
    for lane in 0..WIDTH {
        // SAFETY: kernels pass the address of a stack slot of `OPERANDS + 1` times `WIDTH` floats whose operands they have written.
        let [x, y, z, a, b, n] =
            std::array::from_fn::<f32, OPERANDS, _>(|index| unsafe { lanes.add(index * WIDTH + lane).read() });
        let value = flush(noise::perlin([x, y, z], a, b, n));
        // SAFETY: as above; the result's place is behind the operands.
        unsafe { lanes.add(OPERANDS * WIDTH + lane).write(value) };
    }
    // SAFETY: gives the kernel its MXCSR back.
    unsafe {
        std::arch::asm!("ldmxcsr [{saved}]", saved = in(reg) &raw const saved, options(nostack, readonly));
    }
}

/// Has the processor fetch a list that is going to be read, and goes on: lists that come from memory are then waited for together.
pub fn fetch<T>(list: &[T]) {
    let bytes = list.as_ptr_range();
    for line in (bytes.start.addr()..bytes.end.addr()).step_by(size_of::<Line>()) {
        // SAFETY: fetching reads nothing that the program sees, and does nothing where nothing is. The instruction is of SSE, which every
        // processor of this architecture has.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::without_provenance(line)) };
    }
}

/// Code that adds to pixels what hits in them contribute, and writes pixels, for vectors of a width.
pub struct PixelCode {
    /// Where the code of the [pixels](super::pixels) room is that adds, all components or one.
    adding_all: usize,
    adding_one: usize,
    /// That which writes, by the linear transfer and that of sRGB.
    writing: [Writing; 2],
    _memory: CodeMemory,
}

/// Code of the [pixels](super::pixels) room that writes.
///
/// # Safety
/// There is a line, and all are readable from `planes` on in three planes, and writable from `pixels` on. The processor has the vectors.
type Writing =
    unsafe extern "C" fn(planes: *const f32, pixels: *mut PixelLine, lines: usize, coming: *const Line, table: *const SrgbTable);

impl PixelCode {
    /// The code for vectors of this width, made at its first use; none where the processor does not have them, or there is no memory for code.
    pub fn get(width: Width) -> Option<&'static PixelCode> {
        static CODE: [OnceLock<Option<PixelCode>>; Width::ALL.len()] = [const { OnceLock::new() }; Width::ALL.len()];
        CODE[width as usize].get_or_init(|| Self::new(width)).as_ref()
    }

    fn new(width: Width) -> Option<Self> {
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
        // SAFETY: at the address is the finished code of a function with these parameters, by the C calling convention; its memory lives
        // as long as the result.
        let writing = [linear, srgb].map(|code| unsafe { std::mem::transmute::<*const u8, Writing>(code) });
        let [adding_all, adding_one] = [adding_all, adding_one].map(<*const u8>::expose_provenance);
        Some(Self { adding_all, adding_one, writing, _memory: memory })
    }

    /// Writes lines of pixels, `0x00RRGGBB`, from this place in the planes on, as the transfer makes bytes. Meanwhile it fetches as many lines of what
    /// is coming.
    ///
    /// # Panics
    /// Where there are not so many pixels in a plane.
    pub fn write(&self, transfer: Transfer, planes: &PixelPlanes, place: usize, pixels: &mut [PixelLine], coming: &[Line]) {
        if pixels.is_empty() {
            return;
        }
        assert!(
            pixels.len() <= PLANE_PIXELS / LINE_HITS && place + pixels.len() * LINE_HITS <= PLANE_PIXELS,
            "pixels of a plane"
        );
        let first = (&raw const planes.0).cast::<f32>();
        // Where nothing comes, what is in the cache already.
        let coming = if coming.is_empty() { first.cast() } else { coming.as_ptr() };
        let writing = match transfer {
            Transfer::Linear => self.writing[0],
            Transfer::Srgb => self.writing[1],
        };
        // SAFETY: there is a line; all lie within their plane, from `place` on, and green and blue a plane's length behind one another, since
        // the planes are an array (the pointer is made from that to the whole of it); `pixels` are as many, and aligned as their type says.
        // To fetch from where nothing is does nothing. Of the table is read the entry for a number from `SrgbBytes::LEAST` to 1, and it has one for
        // each. The processor was asked.
        unsafe {
            writing(first.add(place), pixels.as_mut_ptr(), pixels.len(), coming, SrgbBytes::get().table());
        }
    }
}

#[cfg(test)]
mod tests;
