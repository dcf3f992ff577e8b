//! Code that adds to pixels and writes them: made once for each width, and called.

use crate::jit::call::memory::CodeMemory;
use crate::jit::lanes::{Line, PLANE_PIXELS, PixelLine, PixelPlanes, SUM_LINES};
use crate::jit::pixels::{self, Gaps, Strides, Writing};
use crate::jit::target::target;
use crate::jit::widen::ALIGNMENT;
use crate::picture::encoder::Encoder;
use crate::simd::Width;
use crate::trace::LINE_HITS;
use cranelift_codegen::ir::Signature;
use cranelift_codegen::isa::CallConv;
use cranelift_jit::JITBuilder;
use cranelift_module::{Linkage, Module};
use std::sync::OnceLock;

/// Code that adds contributions to pixels and writes pixels, for vectors of a width.
pub struct PixelCode {
    /// The code that adds all components, and one.
    pub(super) adding_all: AddingCode,
    pub(super) adding_one: AddingCode,
    /// The code that writes pixels, by multiplication and by a table.
    writing: [WritingCode; 2],
    _memory: CodeMemory,
}

/// The addresses of the code of [`pixels`] that adds segments.
#[derive(Clone, Copy)]
pub(super) struct AddingCode {
    /// For segments without gaps.
    pub(super) runs: usize,
    /// For any segments.
    pub(super) with_gaps: usize,
}

/// The code of [`pixels`] that writes pixels.
///
/// # Safety
/// There is at least one line. All lines are readable from `planes` on in three planes, and writable from `pixels`
/// on. There are entries at `table` for all numbers between the two bounds. The processor has vectors of this width.
type WritingCode = unsafe extern "C" fn(
    planes: *const f32,
    pixels: *mut PixelLine,
    lines: usize,
    next_lines: *const Line,
    table: *const u32,
    first: f32,
    second: f32,
);

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
        let strides = Strides { sums: size_of::<[Line; SUM_LINES]>() as i64, plane: size_of::<[f32; PLANE_PIXELS]>() as i64 };
        let codes = [
            ("adding", pixels::adding_code(width, strides, 3, Gaps::None)),
            ("adding_with_gaps", pixels::adding_code(width, strides, 3, Gaps::Any)),
            ("adding_one", pixels::adding_code(width, strides, 1, Gaps::None)),
            ("adding_one_with_gaps", pixels::adding_code(width, strides, 1, Gaps::Any)),
            ("writing_linear", pixels::writing_code(width, Writing::Linear, strides.plane)),
            ("writing_by_table", pixels::writing_code(width, Writing::Table, strides.plane)),
        ];
        let mut define = |(name, code): (&str, Result<Vec<u8>, _>)| {
            let id = module.declare_function(name, Linkage::Local, &Signature::new(CallConv::SystemV)).ok()?;
            module.define_function_bytes(id, ALIGNMENT, &code.ok()?, &[]).ok()?;
            Some(id)
        };
        let mut ids = Vec::with_capacity(codes.len());
        for code in codes {
            ids.push(define(code)?);
        }
        module.finalize_definitions().ok()?;
        let [adding_all, adding_with_gaps, adding_one, adding_one_with_gaps, linear, by_table] =
            <[_; 6]>::try_from(ids).ok()?.map(|id| module.get_finalized_function(id));
        // SAFETY: at the address is the finished code of a function with these parameters and the C calling
        // convention. Its memory lives as long as the result.
        let writing = [linear, by_table].map(|code| unsafe { std::mem::transmute::<*const u8, WritingCode>(code) });
        let adding = |runs: *const u8, with_gaps: *const u8| AddingCode {
            runs: runs.expose_provenance(),
            with_gaps: with_gaps.expose_provenance(),
        };
        let (adding_all, adding_one) = (adding(adding_all, adding_with_gaps), adding(adding_one, adding_one_with_gaps));
        Some(Self { adding_all, adding_one, writing, _memory: memory })
    }

    /// Writes lines of pixels, `0x00RRGGBB`, from index `start` of the planes on. The encoder turns components into
    /// bytes. It prefetches as many lines of `next_lines`.
    ///
    /// # Panics
    /// If a plane has fewer pixels.
    pub(crate) fn write(
        &self,
        encoder: &Encoder,
        planes: &PixelPlanes,
        start: usize,
        pixels: &mut [PixelLine],
        next_lines: &[Line],
    ) {
        if pixels.is_empty() {
            return;
        }
        assert!(
            pixels.len() <= PLANE_PIXELS / LINE_HITS && start + pixels.len() * LINE_HITS <= PLANE_PIXELS,
            "pixels of a plane"
        );
        let first = (&raw const planes.0).cast::<f32>();
        // If there is nothing to prefetch, it is something that is in the cache already.
        let next_lines = if next_lines.is_empty() { first.cast() } else { next_lines.as_ptr() };
        let (writing, table, bounds) = match encoder {
            Encoder::Linear(bytes) => (self.writing[0], std::ptr::null(), [bytes.most, bytes.factor]),
            Encoder::Table(table) => (self.writing[1], table.origin(), [table.least, table.most]),
        };
        // SAFETY: there is at least one line. All lines lie within their plane, from `start` on. The planes are an
        // array, so green and blue follow red at the distance of a plane (the pointer comes from a pointer to the
        // whole array). `pixels` has as many lines, aligned as their type requires. A prefetch of any address is
        // harmless. The code reads entries of the table for numbers from `least` to `most`, and the table has one
        // for each. The other code reads no table. The processor was checked for the instructions.
        unsafe {
            writing(first.add(start), pixels.as_mut_ptr(), pixels.len(), next_lines, table, bounds[0], bounds[1]);
        }
    }
}
