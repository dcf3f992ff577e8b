//! The room of unsafe code: kernels in executable memory, calls into them, and the function that they call out to; and the code that
//! adds to pixels.
//!
//! Kernels run with subnormal numbers switched off (FTZ and DAZ of the MXCSR register: a subnormal operand costs a hundred
//! cycles and more), which Rust code must not see; so the register is set and restored around each call, and around what a kernel calls.
#![allow(unsafe_code)]

use crate::formula::graph::Graph;
use crate::jit::emit::PERLIN_OPERANDS;
use crate::jit::kernel::{self, KernelPlan, Shape};
use crate::jit::lanes::{Line, PLANE_PIXELS, PixelLine, PixelPlanes, STREAMS, Splat, Streams, Sums};
use crate::jit::pixels;
use crate::jit::target::{CompileError, Listing, Target, target};
use crate::jit::widen::{ALIGNMENT, disassembled, widen};
use crate::lang::noise;
use crate::lang::scalars::flush;
use crate::segment::{CHUNK_LINES, LINE_HITS, Segment};
use cranelift_codegen::Context;
use cranelift_codegen::control::ControlPlane;
use cranelift_codegen::ir::types::I64;
use cranelift_codegen::ir::{AbiParam, Signature};
use cranelift_codegen::isa::CallConv;
use cranelift_jit::{JITBuilder, JITModule};
use cranelift_module::{Linkage, Module, ModuleError};
use smallvec::SmallVec;
use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
use std::mem::ManuallyDrop;
use std::sync::{Arc, OnceLock};

/// What every kernel is: see the [kernel](super::kernel) room for the meaning of the parameters.
///
/// # Safety
/// The tables hold as many pointers as the kernel reads, each stream and output at least the lines of that many rounds, the uniforms
/// as many as it reads; outputs overlap nothing.
type Entry = unsafe extern "C" fn(streams: *const *const Line, uniforms: *const Splat, outputs: *const *mut Line, rounds: usize);

/// The memory that holds a formula's kernels; freed with the last of them.
pub(super) struct CodeMemory(ManuallyDrop<JITModule>);

// SAFETY: the module is touched only when it is made and, by the one owner left, when it is dropped; kernels only run code in its memory.
unsafe impl Send for CodeMemory {}
// SAFETY: as above; there is no method that reads or changes the module through a shared reference.
unsafe impl Sync for CodeMemory {}

impl Drop for CodeMemory {
    fn drop(&mut self) {
        // SAFETY: the value is not used after this, since it is being dropped. Every kernel holds the memory by an `Arc`, so no
        // code in it can be running or be called any more.
        unsafe { ManuallyDrop::take(&mut self.0).free_memory() }
    }
}

/// Compiles kernels into one piece of memory; where a listing is wanted, writes the stages into it.
///
/// # Errors
/// The processor is not supported, a plan does not read what it needs, or the code generator refuses (too large a function).
pub(super) fn generate(plans: &[KernelPlan], graph: &Graph, listing: Option<&mut Listing>) -> Result<Vec<Kernel>, CompileError> {
    generate_for(&target()?, plans, graph, listing)
}

/// The same for a processor that this one can do the work of.
fn generate_for(
    target: &Target,
    plans: &[KernelPlan],
    graph: &Graph,
    mut listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let failed = |error: ModuleError| CompileError::Generator(error.to_string());
    let mut builder = JITBuilder::with_isa(target.isa.clone(), cranelift_module::default_libcall_names());
    builder.symbol("perlin", perlin_lanes as *const u8);
    // Owned at once by what frees it: a module that is merely dropped leaks its memory.
    let mut memory = CodeMemory(ManuallyDrop::new(JITModule::new(builder)));
    let module = &mut *memory.0;
    let mut noise_signature = Signature::new(CallConv::SystemV);
    noise_signature.params.push(AbiParam::new(I64));
    let noise = module.declare_function("perlin", Linkage::Import, &noise_signature).map_err(failed)?;
    let mut functions = Vec::with_capacity(plans.len());
    for (index, plan) in plans.iter().enumerate() {
        let mut signature = Signature::new(CallConv::SystemV);
        signature.params.extend(kernel::parameters());
        let id = module.declare_function(&format!("{}{index}", plan.name), Linkage::Local, &signature).map_err(failed)?;
        let unread = || CompileError::Generator(format!("the kernel of {} does not read all that it needs", plan.name));
        let mut defined = None;
        for shape in kernel::shapes(plan, graph, target) {
            let schedule = plan.schedule(graph, shape).ok_or_else(unread)?;
            let noisy = schedule.iter().any(|id| kernel::calls_perlin(graph, *id));
            if shape.blocks > 1 && noisy {
                continue;
            }
            let mut context = Context::new();
            context.func.signature = signature.clone();
            let callee = noisy.then(|| module.declare_func_in_func(noise, &mut context.func));
            kernel::write(plan, &schedule, graph, &*target.isa, shape, callee, &mut context.func);
            context.set_disasm(listing.is_some());
            let clif = listing.is_some().then(|| context.func.display().to_string());
            let mut assembler = String::new();
            if shape.blocks > 1 {
                let compiled = context.compile(&*target.isa, &mut ControlPlane::default());
                let compiled = compiled.map_err(|error| CompileError::Generator(error.inner.to_string()))?;
                let own = compiled.buffer.relocs().is_empty().then(|| compiled.code_buffer());
                let Some(wide) = own.and_then(|code| widen(code, shape.blocks)) else { continue };
                if listing.is_some() {
                    assembler = disassembled(&wide);
                }
                module.define_function_bytes(id, ALIGNMENT, &wide, &[]).map_err(failed)?;
            } else {
                module.define_function(id, &mut context).map_err(failed)?;
                let code = context.compiled_code().and_then(|code| code.vcode.clone());
                assembler = code.unwrap_or_default();
            }
            if let (Some(listing), Some(clif)) = (&mut listing, clif) {
                listing.clif.push_str(&format!("; {}\n{clif}\n", plan.name));
                listing.asm.push_str(&format!("; {}\n{assembler}\n", plan.name));
            }
            defined = Some(shape);
            break;
        }
        functions.push((id, defined.ok_or_else(unread)?));
    }
    module.finalize_definitions().map_err(failed)?;
    let finished: Vec<(*const u8, Shape)> =
        functions.iter().map(|(id, shape)| (module.get_finalized_function(*id), *shape)).collect();
    let memory = Arc::new(memory);
    let kernel = |(plan, (address, shape)): (&KernelPlan, (*const u8, Shape))| {
        // SAFETY: at the address is the finished code of the function that was written just now with the parameters of `Entry`, none
        // of which is wider than a register; its memory lives as long as the kernel.
        let entry = unsafe { std::mem::transmute::<*const u8, Entry>(address) };
        let streams = plan.streams.each_ref().map(Vec::len);
        let (uniforms, outputs) = (plan.uniforms.len(), plan.output_streams().into());
        Kernel { entry, streams, uniforms, outputs, shape, _memory: Arc::clone(&memory) }
    };
    Ok(plans.iter().zip(finished).map(kernel).collect())
}

/// A compiled kernel.
#[derive(Clone)]
pub struct Kernel {
    entry: Entry,
    /// How many columns there are in each stream that it reads.
    streams: [usize; STREAMS],
    uniforms: usize,
    /// How many columns there are in each stream that it writes.
    outputs: Arc<[usize]>,
    shape: Shape,
    _memory: Arc<CodeMemory>,
}

impl Kernel {
    /// How many columns it writes.
    pub fn outputs(&self) -> usize {
        self.outputs.iter().sum()
    }

    /// How many lines it reads and writes where so many are wanted: whole rounds, of up to [`ROUND_LINES`](crate::segment::ROUND_LINES).
    pub fn whole_rounds(&self, lines: usize) -> usize {
        lines.next_multiple_of(self.shape.lines())
    }

    /// Runs the kernel over so many lines of records, from these streams and uniform values: stores or adds into `outputs`, see
    /// [`run_in_turn`].
    ///
    /// # Panics
    /// As [`run_in_turn`].
    pub fn run(&self, streams: Streams, uniforms: &[Splat], outputs: &mut [&mut [Line]], lines: usize) {
        run_in_turn(&[Call { kernel: self, streams, uniforms }], outputs, lines);
    }
}

/// A kernel and what it reads.
#[derive(Clone, Copy)]
pub struct Call<'c> {
    /// The kernel.
    pub kernel: &'c Kernel,
    /// Its columns.
    pub streams: Streams<'c>,
    /// Its uniform values.
    pub uniforms: &'c [Splat],
}

/// The arguments of a call, as the code below reads them.
#[repr(C)]
struct Arguments {
    streams: [*const Line; STREAMS],
    uniforms: *const Splat,
    outputs: *const *mut Line,
    rounds: usize,
    entry: Entry,
}

/// Runs kernels one after the other, over as many lines and into the same outputs: one stream where values are stored, a column for each output
/// where terms are added up. What becomes of lines beyond, see [`Kernel::whole_rounds`], has no meaning. To enter and leave compiled code
/// costs some ten nanoseconds, so it is done once for all of them.
///
/// # Panics
/// Where there are not as many uniforms and outputs as a kernel was written for, or a stream or an output is shorter than its
/// [whole rounds](Kernel::whole_rounds) of `lines`.
pub fn run_in_turn(calls: &[Call], outputs: &mut [&mut [Line]], lines: usize) {
    let mut output_table = SmallVec::<[*mut Line; 4]>::new();
    output_table.extend(outputs.iter_mut().map(|column| column.as_mut_ptr()));
    let mut table = SmallVec::<[Arguments; 8]>::new();
    for Call { kernel, streams, uniforms } in calls {
        let whole = kernel.whole_rounds(lines);
        // Of each stream, as much as is read or written: a product that does not fit is longer than any slice.
        let holds = |length: usize, columns: usize| whole.checked_mul(columns).is_some_and(|needed| length >= needed);
        assert!(streams.iter().zip(kernel.streams).all(|(stream, columns)| holds(stream.len(), columns)), "a kernel's columns");
        assert!(
            outputs.len() == kernel.outputs.len()
                && outputs.iter().zip(&*kernel.outputs).all(|(output, columns)| holds(output.len(), *columns)),
            "a kernel's outputs"
        );
        assert!(uniforms.len() >= kernel.uniforms, "a kernel's uniforms");
        table.push(Arguments {
            streams: streams.map(<[Line]>::as_ptr),
            uniforms: uniforms.as_ptr(),
            outputs: output_table.as_ptr(),
            rounds: whole * Line::BLOCKS / kernel.shape.round(),
            entry: kernel.entry,
        });
    }
    if table.is_empty() {
        return;
    }
    // SAFETY: the table is not empty. Each kernel's code reads of every stream, and writes of every output, the lines of its rounds,
    // times as many as the stream has columns, and `kernel.uniforms` splats; the assertions above guarantee all of them, `&mut` that outputs
    // overlap nothing. `Line` is aligned as the code's loads and stores need. Nothing of Rust runs while subnormals are switched off.
    unsafe { without_subnormals(&table) }
}

/// Flush to zero, denormals are zero, and all exceptions masked.
const KERNEL_MXCSR: u32 = 0x9fc0;
/// What Rust code runs with: round to nearest, all exceptions masked.
const RUST_MXCSR: u32 = 0x1f80;

/// Makes calls with subnormal operands and results counting as zero.
///
/// # Safety
/// There is a call, and making each of them must be sound.
unsafe fn without_subnormals(calls: &[Arguments]) {
    let mut saved: u32 = RUST_MXCSR;
    let calls = calls.as_ptr_range();
    // SAFETY: saves MXCSR, sets it for the kernels, makes the calls by the C calling convention (whose registers are all declared
    // lost), and restores MXCSR, so that Rust code never runs under the changed one. r12, r13 and r14 survive calls by that convention.
    unsafe {
        std::arch::asm!(
            "stmxcsr [r12]",
            "ldmxcsr [rax]",
            "2:",
            "lea rdi, [r13 + {streams}]",
            "mov rsi, [r13 + {uniforms}]",
            "mov rdx, [r13 + {outputs}]",
            "mov rcx, [r13 + {rounds}]",
            "call [r13 + {entry}]",
            "add r13, {size}",
            "cmp r13, r14",
            "jb 2b",
            "ldmxcsr [r12]",
            streams = const std::mem::offset_of!(Arguments, streams),
            uniforms = const std::mem::offset_of!(Arguments, uniforms),
            outputs = const std::mem::offset_of!(Arguments, outputs),
            rounds = const std::mem::offset_of!(Arguments, rounds),
            entry = const std::mem::offset_of!(Arguments, entry),
            size = const size_of::<Arguments>(),
            in("r12") &raw mut saved,
            in("rax") &raw const KERNEL_MXCSR_VALUE,
            inout("r13") calls.start => _,
            in("r14") calls.end,
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

/// Code that adds to pixels what hits in them contribute, and writes pixels, sixteen at a time.
pub struct PixelCode {
    adding_all: Adding,
    adding_one: Adding,
    writing: Writing,
    _memory: CodeMemory,
}

/// Code of the [pixels](super::pixels) room that adds; it says what the parameters are.
///
/// # Safety
/// There is a segment, and all from the first to the end are readable; so are the lines of a chunk of each component, as far as the code was
/// written for one or three, and the planes are readable and writable. What is coming may be anywhere. The processor has AVX-512.
type Adding = unsafe extern "C" fn(
    segments: *const Segment,
    end: *const Segment,
    sums: *const Line,
    planes: *mut f32,
    coming: *const Line,
    weight: f32,
);

/// Code of the [pixels](super::pixels) room that writes.
///
/// # Safety
/// There is a line, and all are readable from `planes` on in three planes, and writable from `pixels` on. The processor has AVX-512.
type Writing = unsafe extern "C" fn(planes: *const f32, pixels: *mut PixelLine, lines: usize);

impl PixelCode {
    /// The code, made at its first use; none where the processor has no AVX-512.
    pub fn get() -> Option<&'static PixelCode> {
        static CODE: OnceLock<Option<PixelCode>> = OnceLock::new();
        CODE.get_or_init(Self::new).as_ref()
    }

    fn new() -> Option<Self> {
        if !std::arch::is_x86_feature_detected!("avx512f") {
            return None;
        }
        let target = target().ok()?;
        let builder = JITBuilder::with_isa(target.isa.clone(), cranelift_module::default_libcall_names());
        let mut memory = CodeMemory(ManuallyDrop::new(JITModule::new(builder)));
        let module = &mut *memory.0;
        let [sums, plane] = [size_of::<[Line; CHUNK_LINES]>() as i64, size_of::<[f32; PLANE_PIXELS]>() as i64];
        let codes = [
            ("adding", pixels::adding_code(sums, plane, 3)),
            ("adding_one", pixels::adding_code(sums, plane, 1)),
            ("writing", pixels::writing_code(plane)),
        ];
        let mut define = |(name, code): (&str, Result<Vec<u8>, _>)| {
            let id = module.declare_function(name, Linkage::Local, &Signature::new(CallConv::SystemV)).ok()?;
            module.define_function_bytes(id, ALIGNMENT, &code.ok()?, &[]).ok()?;
            Some(id)
        };
        let [adding_all, adding_one, writing] = codes.map(&mut define);
        let ids = [adding_all?, adding_one?, writing?];
        module.finalize_definitions().ok()?;
        let [adding_all, adding_one, writing] = ids.map(|id| module.get_finalized_function(id));
        // SAFETY: at the addresses is the finished code of functions with these parameters, by the C calling convention; their memory lives
        // as long as the result.
        let (adding_all, adding_one, writing) = unsafe {
            let adding = |address| std::mem::transmute::<*const u8, Adding>(address);
            (adding(adding_all), adding(adding_one), std::mem::transmute::<*const u8, Writing>(writing))
        };
        Some(Self { adding_all, adding_one, writing, _memory: memory })
    }

    /// Adds the sums of these segments' hits, times `weight`, to their pixels: of all components, or of one (0 red, 1 green, 2 blue). Meanwhile
    /// it fetches lines from the beginning of what is `coming`, so many for each segment; how many in all.
    pub fn add(
        &self,
        segments: &[Segment],
        sums: &Sums,
        weight: f32,
        component: Option<usize>,
        planes: &mut PixelPlanes,
        coming: &[Line],
    ) -> usize {
        if segments.is_empty() {
            return 0;
        }
        let fetched = segments.len() * pixels::FETCHED;
        let place = component.unwrap_or(0);
        let (sums, planes) = (&sums[place..], &mut planes.0[place..]);
        let entry = if component.is_some() { self.adding_one } else { self.adding_all };
        let segments = segments.as_ptr_range();
        // SAFETY: the segments are those of a slice that is not empty. A segment's line is one of a chunk, and its place such that a line from
        // there ends within a plane (see `Segment::line`, `Segment::place`; only its room can make one); of `sums` and `planes` there are as many
        // components as the code was written for, one behind the other, since they are parts of arrays. To fetch from where nothing is does nothing. The processor was asked.
        unsafe { entry(segments.start, segments.end, sums.as_ptr().cast(), planes.as_mut_ptr().cast(), coming.as_ptr(), weight) }
        fetched
    }

    /// Writes lines of pixels, `0x00RRGGBB`, from this place in the planes on. Clamped, NaN as 0, and rounded to the nearest of 0..=255.
    ///
    /// # Panics
    /// Where there are not so many pixels in a plane.
    pub fn write(&self, planes: &PixelPlanes, place: usize, pixels: &mut [PixelLine]) {
        if pixels.is_empty() {
            return;
        }
        assert!(
            pixels.len() <= PLANE_PIXELS / LINE_HITS && place + pixels.len() * LINE_HITS <= PLANE_PIXELS,
            "pixels of a plane"
        );
        // SAFETY: there is a line; all lie within their plane, from `place` on, and green and blue a plane's length behind one another, since
        // the planes are an array (the pointer is made from that to the whole of it); `pixels` are as many, and aligned as their type says.
        // The processor was asked.
        unsafe {
            (self.writing)((&raw const planes.0).cast::<f32>().add(place), pixels.as_mut_ptr(), pixels.len());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::formula::binding::Bindings;
    use crate::jit::kernel::Output;
    use crate::lang::source::Source;
    use crate::presets::{self, Kind};
    use crate::segment::ROUND_LINES;

    /// What the contribution kernels of a formula yield on some numbers, compiled for at most so many blocks at a time.
    fn contributions(bindings: &Bindings, widest: usize) -> (usize, Vec<f32>) {
        let mut target = target().unwrap();
        target.widths.retain(|width| *width <= widest);
        let frontier = &bindings.frontier;
        let plan = |output| KernelPlan {
            name: "contributions",
            streams: [frontier.hits.clone(), frontier.records.clone(), Vec::new()],
            uniforms: frontier.uniforms.clone(),
            outputs: bindings.contribution.to_vec(),
            output,
            wide: true,
            interleave: 4,
        };
        let kernels = generate_for(&target, &[plan(Output::FirstTerms), plan(Output::MoreTerms)], &bindings.graph, None).unwrap();
        const LINES: usize = 3 * ROUND_LINES;
        let number = |place: usize| 1.25 * ((place as f32 * 0.618_034).fract() - 0.3);
        let line = |first: usize| Line(std::array::from_fn(|lane| number(first + lane)));
        let stream = |columns: &usize| (0..LINES * columns).map(|place| line(16 * place + 1000 * columns)).collect();
        let streams: [Vec<Line>; STREAMS] = kernels[0].streams.each_ref().map(stream);
        let uniforms: Vec<Splat> = (0..kernels[0].uniforms).map(|place| Splat::new(number(7 * place).abs() * 3.0)).collect();
        let mut outputs = vec![vec![Line::default(); LINES]; 3];
        let mut planes: Vec<&mut [Line]> = outputs.iter_mut().map(Vec::as_mut_slice).collect();
        // One stores, the other adds twice.
        for kernel in [&kernels[0], &kernels[1], &kernels[1]] {
            kernel.run(streams.each_ref().map(Vec::as_slice), &uniforms, &mut planes, LINES);
        }
        (kernels[0].shape.round(), outputs.iter().flatten().flat_map(|line| line.0).collect())
    }

    #[test]
    fn kernels_of_all_widths_compute_the_same() {
        let every = "body_specific; a: scalar; b: scalar; formula;
            = <sin(a*alpha) + asin(N.V) + tan(b*beta), exp(a*(N.L)) + log(b + dist) + atan2(a*alpha, beta), (a*dist)^(b*(N.L))>
            + if(a*alpha < b, <1, floor(a*beta), 0>, V*sqrt(b*dist));";
        let presets = presets::names(Kind::Formula).map(|name| presets::text(Kind::Formula, name).unwrap().to_owned());
        for text in presets.chain([every.to_owned()]) {
            let (formula, _) = Formula::parse(&Source::new("formula", text.clone())).unwrap();
            let bindings = Bindings::new(&formula);
            let (round, narrow) = contributions(&bindings, 1);
            assert!(round <= 4 && narrow.iter().any(|x| *x != 0.0));
            for width in target().unwrap().widths {
                let (round, wide) = contributions(&bindings, width);
                assert!(round.is_multiple_of(width), "as wide as there are registers for: {text}");
                // Two to the power of a negative number may differ in the last place, see `vreduceps`.
                let same = |(x, y): (&f32, &f32)| x == y || x.is_nan() && y.is_nan() || (x - y).abs() <= 2e-6 * x.abs().max(1.0);
                let other = narrow.iter().zip(&wide).find(|pair| !same(*pair));
                assert_eq!(other, None, "{width} blocks: {text}");
            }
        }
    }
}
