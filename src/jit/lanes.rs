//! The data that compiled code reads and writes: columns, uniform values and pixels.

use crate::plan::STREAMS;
use crate::trace::{CHUNK_LINES, LINE_HITS, Segment, TILE_PIXELS};

/// A line of a column: the numbers of as many records as the widest vectors have lanes. It is one cache line.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub struct Line(pub [f32; Line::RECORDS]);

impl Line {
    /// The number of records in a line.
    pub const RECORDS: usize = LINE_HITS;
    /// The number of vectors of four lanes in a line.
    pub const BLOCKS: usize = Self::RECORDS / 4;
}

/// The streams that a kernel reads. A stream holds some columns line by line: the first line of each, then the second
/// of each, and so on. A stream that the kernel does not read may be empty.
pub type Streams<'c> = [&'c [Line]; STREAMS];

/// How far ahead of their loads kernels prefetch, in bytes. With less, data would come too late. With more, the L1
/// cache would overflow. Data lies in the order in which it is read, also from one call to the next.
pub const PREFETCH_DISTANCE: usize = 16384;

/// A uniform value, in as many lanes as the widest vectors have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C, align(64))]
pub struct Splat([f32; Line::RECORDS]);

impl Splat {
    /// The value in all lanes.
    pub fn new(value: f32) -> Self {
        Self([value; Line::RECORDS])
    }

    /// The value.
    pub fn value(&self) -> f32 {
        self.0[0]
    }
}

/// Sixteen pixels of a framebuffer: one cache line.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub struct PixelLine(pub [u32; Line::RECORDS]);

/// The lines of a component of [`Sums`]: those of a chunk, and one more, because a vector may begin at the last hit.
pub const SUM_LINES: usize = CHUNK_LINES + 1;

/// The contributions of a chunk of hits, summed over lights: red, green and blue of each line.
pub type Sums = [[Line; SUM_LINES]; 3];

/// The numbers of a component of sums, hit by hit.
pub fn numbers(sums: &Sums, component: usize) -> &[f32] {
    bytemuck::cast_slice(&sums[component])
}

/// The pixels of a plane: those of a tile, and room for two lines.
pub const PLANE_PIXELS: usize = TILE_PIXELS as usize + 2 * LINE_HITS;

/// Red, green and blue of the pixels of a tile.
#[derive(Debug, Clone, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct PixelPlanes(pub [[f32; PLANE_PIXELS]; 3]);

/// The operands of a [list of calls](super::call::CallList).
pub struct Operands<'o> {
    /// The lines that hold the streams of kernels.
    pub streams: Streams<'o>,
    /// Lines that are read from front to back, and prefetched.
    pub next_lines: &'o [Line],
    /// Uniform values.
    pub uniforms: &'o [Splat],
    /// The segments of hits.
    pub segments: &'o [Segment],
    /// The weight of each span, followed by more numbers, as many as a chunk has hits
    /// ([`CHUNK_HITS`](crate::trace::CHUNK_HITS)).
    pub weights: &'o [f32],
    /// The sums that kernels write and that are added to pixels.
    pub sums: &'o mut Sums,
    /// The pixels.
    pub planes: &'o mut PixelPlanes,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_splats_are_what_kernels_load() {
        assert_eq!((size_of::<Splat>(), align_of::<Splat>()), (64, 64));
        assert_eq!((size_of::<Line>(), align_of::<Line>()), (64, 64));
    }
}
