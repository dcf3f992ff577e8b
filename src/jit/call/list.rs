//! Lists of calls of compiled code.

use crate::jit::call::kernels::{Kernel, holds};
use crate::jit::call::memory::CodeMemory;
use crate::jit::call::pixel_code::PixelCode;
use crate::jit::call::processor::{CodeCall, fetch, perform};
use crate::jit::code_call::{AddCall, Bases, OUTPUTS};
use crate::jit::lanes::{Line, Operands, PLANE_PIXELS, SUM_LINES, Splat};
use crate::plan::STREAMS;
use crate::trace::{CHUNK_HITS, CHUNK_LINES, Segment};
use smallvec::SmallVec;
use std::ops::Range;
use std::sync::Arc;

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
        let mut offsets = [0; OUTPUTS];
        for (component, offset) in components.zip(&mut offsets) {
            *offset = component * size_of::<[Line; SUM_LINES]>() + lines.start * size_of::<Line>();
        }
        let streams = streams.map(|stream| stream.start * size_of::<Line>());
        self.calls.extend(kernel.calls(streams, uniforms * size_of::<Splat>(), offsets, whole));
    }

    /// Adds a call that adds the sums of the hits of these segments of `all`, times the weight of their span, to their
    /// pixels: all components, or one (0 red, 1 green, 2 blue). The weights of their chunk begin at index `weights`.
    /// For each segment it prefetches some lines of [`Operands::next_lines`], from index `next_lines` on.
    ///
    /// The segments of [`run`](Self::run) must be the same: the code depends on whether they have gaps.
    ///
    /// # Panics
    /// If `all` has fewer segments, or there is no such component.
    pub fn add(
        &mut self,
        code: &'static PixelCode,
        all: &[Segment],
        segments: Range<usize>,
        weights: usize,
        component: Option<usize>,
        next_lines: usize,
    ) {
        if segments.is_empty() {
            return;
        }
        let first_component = component.unwrap_or(0);
        assert!(first_component < OUTPUTS, "a component");
        self.sizes.segments = self.sizes.segments.max(segments.end);
        // Enough for any span that a segment may name.
        self.sizes.weights = self.sizes.weights.max(weights + CHUNK_HITS);
        let addition = AddCall {
            segments: segments.start * size_of::<Segment>(),
            end: segments.end * size_of::<Segment>(),
            sums: first_component * size_of::<[Line; SUM_LINES]>(),
            planes: first_component * size_of::<[f32; PLANE_PIXELS]>(),
            next_lines: next_lines * size_of::<Line>(),
            weights: weights * size_of::<f32>(),
            unused: Default::default(),
        };
        let has_gaps = !all[segments].iter().all(|segment| segment.is_run());
        let adding = if component.is_some() { code.adding_one } else { code.adding_all };
        let entry = if has_gaps { adding.with_gaps } else { adding.runs };
        self.calls.push(CodeCall { work: bytemuck::cast(addition), entry });
    }

    /// Makes some of the calls, in order.
    ///
    /// # Panics
    /// If there are fewer operands than any call of the list needs.
    pub fn run(&self, calls: Range<usize>, operands: &mut Operands) {
        let Operands { streams, next_lines, uniforms, segments, weights, sums, planes } = operands;
        let OperandSizes { streams: lines, uniforms: splats, segments: least_segments, weights: spans } = self.sizes;
        assert!(streams.iter().zip(lines).all(|(stream, lines)| stream.len() >= lines), "a list's columns");
        assert!(uniforms.len() >= splats && segments.len() >= least_segments && weights.len() >= spans, "a list's operands");
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
            next_lines: next_lines.as_ptr().addr(),
        };
        // SAFETY: there is at least one call, and the two methods above made all of them. The code of a kernel reads
        // the lines of its rounds of each column of every stream, and its uniform splats: `contribute` counted them
        // in `sizes`, and the assertions here guarantee that they exist. It writes as many lines of sums, within a
        // chunk of each component. Code that adds to pixels reads at least one segment, and only segments that
        // `sizes` counts. The first hit of a segment is one of a chunk and its first pixel one of a tile, so a line
        // from there ends within the sums of a component and within a plane, which have that much room (only the module
        // of segments can make one). Sums and planes are arrays, so they have as many consecutive components from the
        // given one on as the code was written for. `sizes` counts the weight of each span that a segment may name. A
        // prefetch of any address is harmless. Everything that is written is borrowed uniquely. The code lives as long
        // as the list or for ever, and the processor was checked for the instructions that it uses.
        unsafe { perform(calls, &bases) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::jit::lanes::{PixelPlanes, Sums};
    use crate::lang::source::Source;
    use crate::workspace::{FileKind, presets};

    #[test]
    fn lists_run_on_nothing_that_is_too_short() {
        let (formula, _) = Formula::parse(&Source::new("formula", presets::text(FileKind::Formula, "phong").unwrap())).unwrap();
        let compiled = crate::jit::CompiledFormula::new(&formula).unwrap();
        let columns = compiled.plan.bindings.frontier.records.len();
        let kernel = &compiled.contribution.overwrite;
        let mut list = CallList::default();
        list.contribute(kernel, [0..0, 4..4 + 4 * columns, 0..0], 2, 0..3, 8..12);
        let code = PixelCode::get(compiled.width);
        let segments = vec![Segment::new(0, 0, 0); 3];
        assert_eq!(code.is_some(), cfg!(target_arch = "x86_64"));
        if let Some(code) = code {
            list.add(code, &segments, 1..3, 5, None, 0);
        }
        let lines = vec![Line::default(); 4 + 4 * columns];
        let uniforms = vec![Splat::default(); 2 + compiled.contribution.uniforms.outputs()];
        let weights = vec![0.0; 5 + CHUNK_HITS];
        let (mut sums, mut planes) = (bytemuck::zeroed_box::<Sums>(), bytemuck::zeroed_box::<PixelPlanes>());
        let mut run = |lines: &[Line], uniforms: &[Splat], segments: &[Segment], weights: &[f32]| {
            let (sums, planes) = (&mut *sums, &mut *planes);
            let mut operands =
                Operands { streams: [&[], lines, &[]], next_lines: &[], uniforms, segments, weights, sums, planes };
            std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| list.run(0..list.len(), &mut operands))).is_ok()
        };
        assert!(run(&lines, &uniforms, &segments, &weights));
        assert!(!run(&lines[1..], &uniforms, &segments, &weights) && !run(&lines, &uniforms[1..], &segments, &weights));
        if code.is_some() {
            assert!(!run(&lines, &uniforms, &segments[1..], &weights) && !run(&lines, &uniforms, &segments, &weights[1..]));
        }
    }
}
