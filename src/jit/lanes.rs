//! What compiled code reads and writes: columns, uniform values, and pixels.

use crate::plan::STREAMS;
use crate::trace::{CHUNK_LINES, LINE_HITS, Segment, TILE_PIXELS};

/// A line of a column: the numbers of as many records as the widest kernels compute at a time, and a line of the cache.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub struct Line(pub [f32; Line::RECORDS]);

impl Line {
    /// How many records a line holds.
    pub const RECORDS: usize = LINE_HITS;
    /// How many vectors of four.
    pub const BLOCKS: usize = Self::RECORDS / 4;
}

/// What a kernel reads: each a stream of lines, in which some columns take turns: the first line of each, then the second of each, and so on.
/// Those that it does not read may be empty.
pub type Streams<'c> = [&'c [Line]; STREAMS];

/// So many bytes ahead of what they read kernels fetch: with less, memory would be too late, with more, the first cache would overflow. What is
/// read next lies behind what is read now, also where a kernel's work ends.
pub const PREFETCH_DISTANCE: usize = 16384;

/// A uniform value, in as many lanes as the widest kernels have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C, align(64))]
pub struct Splat([f32; Line::RECORDS]);

impl Splat {
    /// The value in all lanes.
    pub fn new(value: f32) -> Self {
        Self([value; Line::RECORDS])
    }
}

/// Sixteen pixels of a framebuffer: a line of the cache.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(64))]
pub struct PixelLine(pub [u32; Line::RECORDS]);

/// What is added to the pixels of hits: red, green and blue of each line of a chunk.
pub type Sums = [[Line; CHUNK_LINES]; 3];

/// Pixels of a plane: those of a tile, behind a [margin](Segment::MARGIN), and room for two lines beyond.
pub const PLANE_PIXELS: usize = Segment::MARGIN + TILE_PIXELS as usize + 2 * LINE_HITS;

/// Red, green and blue of the pixels of a tile, each behind its margin.
#[derive(Debug, Clone, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct PixelPlanes(pub [[f32; PLANE_PIXELS]; 3]);

/// What a [program](super::call::Program) works on.
pub struct Operands<'o> {
    /// Lines in which the streams of kernels are.
    pub streams: Streams<'o>,
    /// Lines that are read from front to back: what is fetched ahead.
    pub coming: &'o [Line],
    /// Uniform values.
    pub uniforms: &'o [Splat],
    /// The segments of hits.
    pub segments: &'o [Segment],
    /// The weight of each span; behind the last one so many more that each of a chunk ([`CHUNK_HITS`](crate::trace::CHUNK_HITS)) could have one.
    pub weights: &'o [f32],
    /// What kernels write and pixels get.
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
